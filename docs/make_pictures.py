"""The README's picture: the built-in actor above, the cartoon that the main job made act below.

Run it with `make pictures`.
"""

from __future__ import annotations

import re
import tempfile
from pathlib import Path

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from mien.core import Clip, Rig
from mien.job import demo
from mien.job.retarget import run
from mien.library import actor, performance
from mien.look.portrait import Portrait, weights_for
from mien.look.raster import Picture

TELLING = {
    "at rest": {},
    "smile": {"mouthSmile": 0.85, "cheekSquint": 0.6, "eyeSquint": 0.4, "browOuterUp": 0.2},
    "surprise": {"browInnerUp": 1.0, "browOuterUp": 1.0, "eyeWide": 1.0, "jawOpen": 1.0},
    "wink": {"eyeBlinkLeft": 1.0, "mouthSmileLeft": 1.0},
    "kiss": {"mouthPucker": 1.0},
    "anger": {"browDown": 1.0, "noseSneer": 0.7, "eyeSquint": 0.5, "mouthUpperUp": 0.5, "mouthStretch": 0.4},
}
"""Captions, and what the actor does there, on both sides where none is named."""

TILE, GAP, CAPTION = (196, 242), 5, 32
PAPER, INK = (255, 255, 255), (87, 96, 106)


def main() -> None:
    """Run the job on the built-in performance and write `docs/pictures/demo.png`."""
    face = actor()
    acted, _ = performance(face)
    with tempfile.TemporaryDirectory() as folder:
        result = run(demo.prepare(Path(folder)))
    frames = [_frame(acted, wanted) for wanted in TELLING.values()]
    above = _pictures(face, acted, frames)
    below = _pictures(result.character, result.clip, frames)
    _strip(above, below).save(Path(__file__).parent / "pictures" / "demo.png", optimize=True)


def _frame(clip: Clip, wanted: dict[str, float]) -> int:
    """Return the frame whose weights are nearest to those wanted, all others being 0."""
    target = [wanted.get(name, wanted.get(re.sub("(Left|Right)$", "", name), 0.0)) for name in clip.names]
    return int(np.linalg.norm(clip.values - target, axis=1).argmin())


def _pictures(rig: Rig, clip: Clip, frames: list[int]) -> list[Picture]:
    weights = weights_for(rig, clip)
    sitter = Portrait.of(rig, size=(2 * TILE[0], 2 * TILE[1]))
    return [sitter.picture(weights[frame]) for frame in frames]


def _strip(above: list[Picture], below: list[Picture]) -> Image.Image:
    """Lay two rows of pictures out with the captions under them."""
    wide, tall = TILE
    size = (len(above) * (wide + GAP) - GAP, 2 * (tall + GAP) + CAPTION)
    paper = Image.new("RGB", size, PAPER)
    draw, words = ImageDraw.Draw(paper), ImageFont.load_default(17)
    for column, (caption, *pair) in enumerate(zip(TELLING, above, below, strict=True)):
        x = column * (wide + GAP)
        for row, picture in enumerate(pair):
            paper.paste(Image.fromarray(picture).resize(TILE, Image.Resampling.LANCZOS), (x, row * (tall + GAP)))
        draw.text((x + wide / 2, size[1] - CAPTION / 2), caption, INK, words, anchor="mm")
    return paper


if __name__ == "__main__":
    main()
