"""What a request cannot ask for together: refused before anything is read or fitted."""

from __future__ import annotations

from mien.core import InputError
from mien.job.performance import Performance, check_same_mesh
from mien.job.request import Request
from mien.retargeting import METHODS, parameters


def known_parameters(method: str) -> dict[str, object] | None:
    """Return a method's parameters by name; None if there is no such method."""
    return parameters(METHODS[method]()) if method in METHODS else None


def check_correctives(request: Request) -> None:
    """Refuse correctives for a method that does not solve for weights.

    Raises:
        InputError: the method has no solve that they could be part of.
    """
    known = known_parameters(request.method)
    if request.correctives is not None and known is not None and "prior_kind" not in known:
        raise InputError(
            f"the method {request.method!r} does not solve for weights frame by frame, so it cannot take correctives; "
            "use range-of-motion, rbf or direct, or leave --correctives out."
        )


def check_no_targets(request: Request) -> None:
    """Refuse targets where the labels say what is driven.

    Raises:
        InputError: there are some.
    """
    if request.targets is not None or request.poses is not None:
        raise InputError(
            f"the method {request.method!r} drives what its labels name, bones as joint.rx and so on; leave --targets and "
            "--poses out."
        )


def check_training(performance: Performance, training: Performance) -> None:
    """Refuse a training take that says nothing about the performance.

    Raises:
        InputError: one is markers and the other a mesh, or they are different meshes.
    """
    if (performance.markers is None) != (training.markers is None):
        kinds = ("markers", "an animated face or weights")
        mine, other = kinds if performance.markers is not None else kinds[::-1]
        raise InputError(
            f"the performance {performance.path} is {mine}, but the training take {training.path} is {other}; "
            "both must have been captured the same way."
        )
    if training.actor is not None and performance.actor is not None:
        check_same_mesh(performance.actor, training.actor, training.path)
