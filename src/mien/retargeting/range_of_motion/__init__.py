"""Facial retargeting with automatic range-of-motion alignment (Ribera, Zell, Lewis, Noh, Botsch 2017)."""

from mien.retargeting.range_of_motion.method import Alignment, RangeOfMotion

__all__ = ["Alignment", "RangeOfMotion"]
