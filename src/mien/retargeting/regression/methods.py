"""`ridge`, `gpr`, `svr` and `cross-mapping` as retargeting methods: they use the labelled frames alone."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from mien.core.arrays import Floats
from mien.retargeting.by_example import ExampleMethod
from mien.retargeting.regression.cross_mapping import CrossMappingModel
from mien.retargeting.regression.gpr import GprModel
from mien.retargeting.regression.ridge import RidgeModel
from mien.retargeting.regression.svr import SvrModel


@dataclass(frozen=True)
class Ridge(ExampleMethod):
    """Map frames linearly."""

    name: ClassVar[str] = "ridge"
    about: ClassVar[str] = "a linear map from labelled frames; a baseline"

    def learner(self, take: Floats) -> RidgeModel:
        """Return the model."""
        del take
        return RidgeModel()


@dataclass(frozen=True)
class Gpr(ExampleMethod):
    """Map frames by Gaussian-process regression."""

    name: ClassVar[str] = "gpr"
    about: ClassVar[str] = "Gaussian-process regression from labelled frames; a comparator"

    def learner(self, take: Floats) -> GprModel:
        """Return the model."""
        del take
        return GprModel()


@dataclass(frozen=True)
class Svr(ExampleMethod):
    """Map frames by support vector regression."""

    name: ClassVar[str] = "svr"
    about: ClassVar[str] = "support vector regression from labelled frames (needs scikit-learn); a comparator"

    def learner(self, take: Floats) -> SvrModel:
        """Return the model."""
        del take
        return SvrModel()


@dataclass(frozen=True)
class CrossMapping(ExampleMethod):
    """Map frames by radial basis functions in their principal space.

    Attributes:
        share: of the capture's variance that the space holds.
    """

    name: ClassVar[str] = "cross-mapping"
    about: ClassVar[str] = "radial basis functions from labelled frames (Deng et al. 2006); a comparator"

    share: float = 0.95

    def learner(self, take: Floats) -> CrossMappingModel:
        """Return the model."""
        del take
        return CrossMappingModel(self.share)
