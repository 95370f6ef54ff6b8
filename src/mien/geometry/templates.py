"""Expression templates: values of controls that make one expression, alone, as shapes, or over time."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np

from mien.core import Blendshapes, Clip, InputError, Rig
from mien.core.anatomy import Anatomy
from mien.core.arrays import Floats
from mien.core.errors import unknown
from mien.geometry.puppet import Puppet, controls_of


def template_controls(rig: Rig, weights: Mapping[str, float]) -> dict[str, float]:
    """Return the controls that play several templates at once: the weighted sum of theirs.

    Raises:
        InputError: the rig has no template of that name.
    """
    templates = rig.anatomy.templates if rig.anatomy is not None else {}
    total: dict[str, float] = {}
    for name, weight in weights.items():
        if name not in templates:
            raise InputError(unknown(f"template of {rig.name!r}", name, templates))
        for control, value in templates[name].items():
            total[control] = total.get(control, 0.0) + weight * value
    return total


def template_shapes(rig: Rig, names: Iterable[str] | None = None) -> Blendshapes:
    """Return templates as blendshapes: what each adds to the neutral, or to the template it is meant on top of.

    Args:
        rig: with templates.
        names: which; all if None.

    Raises:
        InputError: the rig has no template of that name.
    """
    anatomy, puppet = rig.anatomy or Anatomy(), Puppet.of(rig)
    chosen = tuple(anatomy.templates if names is None else names)
    deltas = np.zeros((len(chosen), *rig.neutral.vertices.shape))
    for row, name in enumerate(chosen):
        under = {anatomy.bases[name]: 1.0} if name in anatomy.bases else {}
        whole = puppet.posed(template_controls(rig, {name: 1.0, **under}))
        deltas[row] = whole - puppet.posed(template_controls(rig, under))
    return Blendshapes(chosen, deltas)


def played(rig: Rig, script: Clip) -> Floats:
    """Return the `(F, C)` values of all controls, in the order of `controls_of`, while a script plays.

    Args:
        rig: with the templates that the script names.
        script: template weights over time; a frame of NaN stays NaN.

    Raises:
        InputError: the rig has no template of that name.
    """
    names = controls_of(rig)
    table = np.zeros((len(script.names), len(names)))
    for row, template in enumerate(script.names):
        for control, value in template_controls(rig, {template: 1.0}).items():
            if control not in names:
                raise InputError(unknown(f"control of template {template!r}", control, names))
            table[row, names.index(control)] = value
    return np.asarray(script.values @ table)
