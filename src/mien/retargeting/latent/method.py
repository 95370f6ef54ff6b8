"""`sgplvm`: the shared latent space from labelled frames alone, as a retargeting method."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import ClassVar

from mien.core.arrays import Floats
from mien.retargeting.by_example import ExampleMethod
from mien.retargeting.labelled import capture_noise
from mien.retargeting.latent.model import LatentModel


@dataclass(frozen=True)
class Sgplvm(ExampleMethod):
    """Learn a shared latent space from the labelled frames alone (Ek 2009).

    Attributes:
        model: its parts.
    """

    name: ClassVar[str] = "sgplvm"
    about: ClassVar[str] = "a shared latent space from the labelled frames alone (Ek 2009); a comparator"

    model: LatentModel = field(default_factory=lambda: LatentModel(unlabelled=False))

    def learner(self, take: Floats) -> LatentModel:
        """Return the model, told how noisy the take is."""
        return told(self.model, take)


def told(model: LatentModel, take: Floats) -> LatentModel:
    """Return a model told how noisy a take `(F, d)` is and how fast it changes, where it is not told already."""
    noise, change = capture_noise(take)
    untold = LatentModel()
    return replace(
        model,
        noise=noise if model.noise == untold.noise else model.noise,
        change=change if model.change == untold.change else model.change,
    )
