"""Methods that learned from examples as plain values and arrays, and back."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mien.capture import Stabiliser
from mien.core import Clip, Examples, InputError, Markers, Note
from mien.geometry.align import Similarity
from mien.retargeting.by_example import ExampleRetargeter
from mien.retargeting.latent.learnt import Convergence, LearntLatent
from mien.retargeting.latent.observe import Observer
from mien.retargeting.latent.regressor import Regressor
from mien.retargeting.records import record, restored
from mien.retargeting.regions import Apart, Part
from mien.retargeting.regression.gaps import GapFilling
from mien.retargeting.regression.learnt import LearntRegression
from mien.retargeting.regression.predictor import Predictor
from mien.retargeting.rows import ChannelRows, MarkerRows
from mien.retargeting.scaling import Scaling
from mien.retargeting.transport.experts import LinearExpert, ProcessExpert
from mien.retargeting.transport.hull import LocalHull
from mien.retargeting.transport.learnt import LearntTransport
from mien.retargeting.transport.principal import PrincipalSpace
from mien.retargeting.transport.process import LinearRadialKernel, Process
from mien.retargeting.transport.shares import Shares
from mien.solve.gaussian_kernel import Kernel

CLASSES: dict[str, type[Any]] = {
    kind.__name__: kind
    for kind in (
        *(ExampleRetargeter, MarkerRows, ChannelRows, Stabiliser, Similarity, Examples, Note, Scaling),
        *(LearntLatent, Observer, Regressor, Kernel, Convergence, Apart, Part),
        *(LearntRegression, Predictor, GapFilling),
        *(LearntTransport, PrincipalSpace, Process, LinearRadialKernel, LocalHull),
        *(ProcessExpert, LinearExpert, Shares),
    )
}
"""All that a saved model may be made of."""


def packed_examples(fitted: ExampleRetargeter) -> tuple[dict[str, Any], dict[str, NDArray[Any]]]:
    """Return a fitted method as a header of plain values and its arrays."""
    arrays: dict[str, NDArray[Any]] = {}
    return {"kind": "examples", "names": fitted.names, "fitted": record(fitted, arrays)}, arrays


def unpacked_examples(header: Mapping[str, Any], arrays: Mapping[str, NDArray[Any]]) -> ExampleRetargeter:
    """Return the fitted method that `packed_examples` made these from.

    Raises:
        InputError: what is found cannot map a frame.
        KeyError: something is missing.
        TypeError: something is of the wrong kind.
        ValueError: something has the wrong shape.
    """
    fitted = restored(header["fitted"], arrays, CLASSES)
    if not isinstance(fitted, ExampleRetargeter):
        raise InputError(f"the model holds a {type(fitted).__name__} instead of a fitted method; fit it again.")
    size = fitted.reading.size
    if fitted.names != fitted.labels.names or fitted.shown.shape != (len(fitted.labels.frames), size):
        raise ValueError("the labels do not fit the parameters and the source")
    if isinstance(fitted.learnt, LearntLatent):
        _check_observer(fitted.learnt.source, size)
        _check_observer(fitted.learnt.target, len(fitted.names))
    values = fitted.retarget(_trial(fitted))[0].values
    if values.shape != (2, len(fitted.names)) or not np.isfinite(values).all():
        raise ValueError("the model does not map a frame to its parameters")
    if fitted.knows_poses:
        fitted.complete({fitted.names[0]: 0.0})
    return fitted


def _trial(fitted: ExampleRetargeter) -> Markers | Clip:
    """Return a take of two frames to try a model that was read: one at rest, one with a gap."""
    reading = fitted.reading
    if isinstance(reading, MarkerRows):
        points = np.array([reading.neutral, reading.neutral])
        points[1, 0] = np.nan
        return Markers(reading.names, points, fitted.fps)
    values = np.zeros((2, len(reading.names)))
    values[1, 0] = np.nan
    return Clip(reading.names, values, fitted.fps)


def _check_observer(observer: Observer, size: int) -> None:
    """Refuse shapes that do not fit: the compiled search does not look."""
    r = observer.regressor
    n, q = r.centres.shape
    kinds = len(r.reductions)
    fits = (
        r.coefficients.shape == (n, size)
        and r.reductions.shape == (kinds, n, n)
        and r.kind.shape == (size,)
        and (size == 0 or (r.kind.min() >= 0 and r.kind.max() < kinds))
        and observer.rows.shape[1:] == (size,)
        and observer.z.shape == (len(observer.rows), q)
    )
    if not fits:
        raise ValueError("the shapes of the latent space do not fit each other")
