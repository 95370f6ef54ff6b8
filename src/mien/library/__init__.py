"""The embedded library: an actor, a character and a performance, made by code so that nothing is downloaded."""

from mien.library.cast import actor, character
from mien.library.script import performance

__all__ = ["actor", "character", "performance"]
