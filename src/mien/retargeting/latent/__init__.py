"""The shared latent space of Bouaziz and Pauly 2014: few labels, many unlabelled frames."""

from mien.retargeting.latent.learnt import LearntLatent, Mapping
from mien.retargeting.latent.model import LatentModel

__all__ = ["LatentModel", "LearntLatent", "Mapping"]
