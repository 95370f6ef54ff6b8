"""From raw capture to a face at rest in place: gaps, the neutral, head motion."""

from mien.capture.gaps import fill_gaps
from mien.capture.neutral import Neutral, find_neutral
from mien.capture.stabilise import Stabiliser, learn_stabiliser
from mien.capture.trace import trace

__all__ = ["Neutral", "Stabiliser", "fill_gaps", "find_neutral", "learn_stabiliser", "trace"]
