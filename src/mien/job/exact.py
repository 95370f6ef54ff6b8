"""What a character shows exactly: its file with shapes split by region, where its own cannot make the layers' face.

The paper projects the composed face on the character's blendshapes (Kholgade et al. 2011, §5).
A shape of the whole face cannot open the eyes in surprise while the lips close for a /p/; a shape
per extreme and region can.  So an animated file of the character gets those shapes beside its own,
while weights alone (.csv, .npz) stay those of its own shapes.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from mien.core import Clip, Rig
from mien.io import gltf
from mien.io.formats import write_clip
from mien.job.request import Result
from mien.retargeting.layers import LayeredRetargeter, split_clip, split_rig

MESHES = (".glb", ".gltf")


def exactly(result: Result) -> Result:
    """Return a result of the layers method as an animated file shows it; any other as it is."""
    made = result.retargeter
    if not isinstance(made, LayeredRetargeter) or result.markers is None or result.character is None:
        return result
    if not made.splits(result.report):
        return result
    played = split_clip(made.character, made.layers(result.markers))
    clip = replace(result.clip, names=played.names, values=played.values)
    return replace(result, clip=clip, character=split_rig(result.character, made.character))


def write_shown(path: Path, clip: Clip, rig: Rig) -> None:
    """Write an animated character whose clip plays shapes that its file may not have yet.

    Raises:
        FileError: the file cannot be written.
    """
    if rig.source is not None and rig.source.suffix.lower() in MESHES:
        gltf.write_rigged(path, rig, {"mien": clip})
    else:
        write_clip(path, clip, rig)
