"""The page itself: markup, style and script of the player with a scene inside."""

from __future__ import annotations

import html
import json
from importlib.resources import files

from mien.core import Clip, Rig
from mien.look.camera import View
from mien.look.player.packing import packed
from mien.look.player.scene import scene_of


def player_page(rig: Rig, clip: Clip | None = None, *, view: View = "front", title: str = "") -> str:
    """Return a whole HTML page that plays a rig and needs nothing but itself.

    Args:
        rig: who is shown.
        clip: what it plays, in the rig's shapes; without one its shapes are set by hand.
        view: from where it is seen first.
        title: the page's title; the rig's name if empty.

    Raises:
        InputError: not one channel of the clip is a shape of the rig.
    """
    words, arrays = scene_of(rig, clip, view)
    words["arrays"], block = packed(arrays)
    told = json.dumps(words, separators=(",", ":")).replace("<", "\\u003c")
    shelf = files("mien.look.player")
    page = shelf.joinpath("player.html").read_text(encoding="utf-8")
    for place, text in {
        "title": html.escape(title or rig.name),
        "style": shelf.joinpath("player.css").read_text(encoding="utf-8"),
        "script": shelf.joinpath("player.js").read_text(encoding="utf-8"),
        "scene": told,
        "arrays": block,
    }.items():
        page = page.replace(f"<!--{place}-->", text, 1)
    return page
