"""What happened, in numbers a person can judge."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from mien.core.arrays import Floats
from mien.core.errors import Note


@dataclass(frozen=True, eq=False)
class Report:
    """The account a retargeting gives of itself.

    Attributes:
        method: the method's name.
        fit_mm: `(F,)` root-mean-square distance per frame between the actor's points and
            the fitted ones, on a human-sized face [mm]; NaN where nothing was fitted.
        gain: how strongly the character acts: its points' movement over the actor's (1 is right).
        evidence: per shape, how much of the training clip shows it, between 0 and 1.
        settings: the method's parameters as used.
        figures: further named numbers, ready for JSON.
        notes: what was repaired, left out or doubtful.
        timing_s: seconds per stage.
    """

    method: str
    fit_mm: Floats = field(default_factory=lambda: np.zeros(0))
    gain: float = float("nan")
    evidence: Mapping[str, float] = field(default_factory=dict)
    settings: Mapping[str, Any] = field(default_factory=dict)
    figures: Mapping[str, Any] = field(default_factory=dict)
    notes: tuple[Note, ...] = ()
    timing_s: Mapping[str, float] = field(default_factory=dict)

    def as_json(self) -> dict[str, Any]:
        """Return the `mien-report` document (see the file formats page)."""
        seen = self.fit_mm[np.isfinite(self.fit_mm)]
        document = {
            "format": "mien-report",
            "version": 1,
            "method": self.method,
            "fit": {
                "rms_mm": float(np.sqrt((seen**2).mean())) if seen.size else None,
                "max_mm": float(seen.max()) if seen.size else None,
                "per_frame_mm": [round(float(x), 4) if np.isfinite(x) else None for x in self.fit_mm],
            },
            "gain": self.gain,
            "evidence": dict(self.evidence),
            "settings": dict(self.settings),
            **self.figures,
            "warnings": [{"code": n.code, "message": n.message, "where": n.where} for n in self.notes],
            "timing_s": dict(self.timing_s),
        }
        return {key: _finite(value) for key, value in document.items()}


def _finite(value: Any) -> Any:
    """Replace numbers that JSON does not know by None."""
    if isinstance(value, Mapping):
        return {key: _finite(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_finite(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
