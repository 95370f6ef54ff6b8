"""glTF 2.0: characters with blendshapes and skins, and their animations, read and written."""

from mien.io.gltf.clip import read_clip, read_poses
from mien.io.gltf.rig import read_rig
from mien.io.gltf.rigged import write_rigged
from mien.io.gltf.write import write_clip, write_rig

__all__ = ["read_clip", "read_poses", "read_rig", "write_clip", "write_rig", "write_rigged"]
