"""Expression templates of the generic rig: each as action units, and all through one table as controls."""

from mien.library.expressions.arkit import BASES
from mien.library.expressions.scripts import SCRIPTS
from mien.library.expressions.templates import recipes, templates

__all__ = ["BASES", "SCRIPTS", "recipes", "templates"]
