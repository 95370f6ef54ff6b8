"""`latent`: learn from a few labelled frames and many that are not.

The default is what measures best (docs/latent.md): transport.  The model of Bouaziz and Pauly
2014 exactly as printed is `preset=paper`; the same with what makes it better, `preset=improved`.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, ClassVar

from mien.core.arrays import Floats
from mien.retargeting.by_example import ExampleMethod
from mien.retargeting.latent.method import told
from mien.retargeting.latent.model import LatentModel
from mien.retargeting.transport import TransportModel


@dataclass(frozen=True)
class Latent(ExampleMethod):
    """Learn from labels and from what has none.

    Attributes:
        model: what is learned, and its parts.
    """

    name: ClassVar[str] = "latent"
    about: ClassVar[str] = (
        "few labels and many unlabelled frames; preset=paper is the latent space of Bouaziz and Pauly 2014"
    )
    presets: ClassVar[Mapping[str, Mapping[str, Any]]] = {
        "paper": {"model": LatentModel()},
        "improved": {"model": LatentModel(floor=1e-3, beginning="principal")},
    }

    model: TransportModel | LatentModel = field(default_factory=TransportModel)

    def learner(self, take: Floats) -> TransportModel | LatentModel:
        """Return the model; that of the paper is told how noisy the take is."""
        return told(self.model, take) if isinstance(self.model, LatentModel) else self.model
