"""Task 2: a clip becomes a clip on another rig.  One paper or baseline, one file or folder."""

from mien.retargeting.methods import METHODS, make_method, parameters

__all__ = ["METHODS", "make_method", "parameters"]
