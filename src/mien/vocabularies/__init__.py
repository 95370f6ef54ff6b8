"""Names of facial shapes: the published sets as tables, and the maps between spellings."""

from mien.vocabularies.arkit import ARKIT, ARKIT_NAMES, arkit_name
from mien.vocabularies.names import NameMatch, ShapeKey, match, shape_key

__all__ = ["ARKIT", "ARKIT_NAMES", "NameMatch", "ShapeKey", "arkit_name", "match", "shape_key"]
