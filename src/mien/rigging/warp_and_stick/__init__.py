"""Rig transfer by warp and stick (Orvalho, Zacur, Susin)."""
