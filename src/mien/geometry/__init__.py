"""Mesh mathematics: pure functions of arrays."""
