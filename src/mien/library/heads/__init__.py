"""The cast's bare heads: meshes with landmarks and no rig, each with its own proportions and triangulation."""

from collections.abc import Callable, Mapping

from mien.core import Rig
from mien.library.heads.actor import actor_head
from mien.library.heads.cartoon import cartoon_head
from mien.library.heads.goat import goat_head
from mien.library.heads.tortoise import tortoise_head

__all__ = ["HEADS", "actor_head", "cartoon_head", "goat_head", "tortoise_head"]

HEADS: Mapping[str, Callable[[], Rig]] = {
    "actor": actor_head,
    "cartoon": cartoon_head,
    "tortoise": tortoise_head,
    "goat": goat_head,
}
"""What makes each head."""
