"""All templates by name."""

from __future__ import annotations

from collections.abc import Mapping

from mien.core.anatomy import Controls
from mien.library.expressions.actions import controls_for
from mien.library.expressions.arkit import SHAPES
from mien.library.expressions.emotions import DYAD, PRIMARY
from mien.library.expressions.speech import BLINK, VISEME
from mien.vocabularies.arkit import ARKIT_NAMES
from mien.vocabularies.expressions import BLINKS, EMOTIONS, NEUTRAL, VISEMES


def recipes() -> dict[str, Mapping[str, float]]:
    """Return every template as intensities of action units, in the order of the vocabularies."""
    emotions = PRIMARY | DYAD
    return {
        NEUTRAL: {},
        **{name: SHAPES[name] for name in ARKIT_NAMES},
        **{name: emotions[name].units for name in EMOTIONS},
        **{name: VISEME[name] for name in VISEMES},
        **{name: BLINK[name] for name in BLINKS},
    }


def templates(*, tongue: bool = True) -> dict[str, Controls]:
    """Return every template as values of controls.

    Args:
        tongue: whether the rig has a tongue to control.
    """
    return {name: controls_for(units, tongue=tongue) for name, units in recipes().items()}
