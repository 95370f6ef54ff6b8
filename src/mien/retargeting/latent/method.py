"""`latent` and `sgplvm`: shared Gaussian-process latent spaces as retargeting methods."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar

from mien.core.arrays import Floats
from mien.retargeting.by_example import ExampleMethod, capture_noise
from mien.retargeting.latent.model import PUBLISHED, LatentModel


@dataclass(frozen=True)
class Latent(ExampleMethod):
    """Learn a latent space that actor and character share (Bouaziz and Pauly 2014).

    Attributes:
        model: its parts; noise and change are estimated from the take, as published, if
            `estimate` is set.
        estimate: see there.
    """

    name: ClassVar[str] = "latent"
    about: ClassVar[str] = "a latent space shared by actor and character, from a few labels and many unlabelled frames"
    presets: ClassVar[Mapping[str, Mapping[str, Any]]] = {"paper": PUBLISHED}

    model: LatentModel = field(default_factory=lambda: LatentModel(floor=1e-3, beginning="principal"))
    estimate: bool = True

    def learner(self, take: Floats) -> LatentModel:
        """Return the model, told how noisy the take is."""
        if not self.estimate:
            return self.model
        noise, change = capture_noise(take)
        return replace(self.model, noise=noise, change=change)


@dataclass(frozen=True)
class Sgplvm(Latent):
    """Learn a shared latent space from the labelled frames alone (Ek 2009)."""

    name: ClassVar[str] = "sgplvm"
    about: ClassVar[str] = "a shared latent space from the labelled frames alone; a comparator"
    presets: ClassVar[Mapping[str, Mapping[str, Any]]] = {}

    model: LatentModel = field(default_factory=lambda: LatentModel(unlabelled=False))
