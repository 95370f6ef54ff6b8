"""Figures, each measured beside its peer in one run; see `python -m benchmarks.speed.solve` and its neighbours."""
