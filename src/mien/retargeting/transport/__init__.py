"""Learning from few labels by matching the unlabelled rows of both sides as two clouds (optimal transport)."""

from mien.retargeting.transport.learnt import LearntTransport
from mien.retargeting.transport.model import TransportModel

__all__ = ["LearntTransport", "TransportModel"]
