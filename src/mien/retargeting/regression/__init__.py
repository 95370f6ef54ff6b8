"""Regressions from labelled frames alone: what a model that uses unlabelled frames must beat."""

from mien.retargeting.regression.cross_mapping import CrossMappingModel
from mien.retargeting.regression.gpr import GprModel
from mien.retargeting.regression.learnt import LearntRegression
from mien.retargeting.regression.ridge import RidgeModel
from mien.retargeting.regression.svr import SvrModel

__all__ = ["CrossMappingModel", "GprModel", "LearntRegression", "RidgeModel", "SvrModel"]
