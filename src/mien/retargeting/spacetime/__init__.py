"""Space-time expression cloning for blendshapes (Seol, Lewis, Seo, Choi, Anjyo, Noh 2012)."""

from mien.retargeting.spacetime.method import Spacetime
from mien.retargeting.spacetime.retargeter import SpacetimeRetargeter

__all__ = ["Spacetime", "SpacetimeRetargeter"]
