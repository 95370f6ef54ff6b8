"""Solvers and systems of others on mien's own cases: `python -m benchmarks.peers`.

Nothing here is part of the package.  Each adapter says how to get what it adapts; what is
absent is skipped with a word.
"""
