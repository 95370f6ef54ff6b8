"""Example-based facial rigging (Li, Weise, Pauly 2010), as a comparator of the range-of-motion paper."""

from mien.retargeting.example_based.method import ExampleBased

__all__ = ["ExampleBased"]
