"""The command line: the same verbs as the library, and the only place that prints."""

from mien.cli.app import main

__all__ = ["main"]
