"""One page that plays an animated face in any browser, opened from disk: no server, no network, no other file."""

from mien.look.player.page import player_page
from mien.look.player.scene import scene_of

__all__ = ["player_page", "scene_of"]
