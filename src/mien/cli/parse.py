"""Reading the small languages of the command line's options."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import typer


def settings_of(
    set_: Sequence[str] | None,
    prior: Sequence[str] | None,
    *,
    exclusive: Sequence[str] | None = None,
    symmetric: Sequence[str] | None = None,
    **given: Any,
) -> dict[str, Any]:
    """Return the method's parameters from `--set`, `--prior` and the options that stand for one parameter each.

    Args:
        set_, prior, exclusive, symmetric: items as they were written.
        given: values by parameter; None where the option was left out.
    """
    given["exclusive"] = pair_names(exclusive or [], "--exclusive") or None
    given["symmetric"] = pair_names(symmetric or [], "--symmetric") or None
    stated = {key: value for key, value in given.items() if value is not None}
    return {**assignments(set_ or []), **prior_weights(prior or []), **stated}


def assignments(items: Sequence[str]) -> dict[str, Any]:
    """Read KEY=VALUE items."""
    return dict(_split(item, "--set") for item in items)


def prior_weights(items: Sequence[str]) -> dict[str, Any]:
    """Read NAME and NAME=WEIGHT items of `--prior` into the solve's parameters."""
    from mien.retargeting.prior import PRIORS

    settings: dict[str, Any] = {}
    for item in items:
        name, weight = _split(item, "--prior") if "=" in item else (item.strip(), None)
        if name == "sparsity" and weight is not None:
            settings["sparsity"] = weight
            continue
        if name not in PRIORS:
            known = ", ".join([*PRIORS, "sparsity=WEIGHT"])
            raise typer.BadParameter(f"unknown prior {name!r}; known: {known}.", param_hint="--prior")
        if "prior_kind" in settings:
            raise typer.BadParameter(f"{settings['prior_kind']} and {name}: only one at a time.", param_hint="--prior")
        settings |= {"prior_kind": name, "prior": PRIORS[name].usual if weight is None else weight}
    return settings


def numbers(items: Sequence[str], option: str) -> dict[str, float]:
    """Read NAME=NUMBER items."""
    found = {}
    for item in items:
        name, value = _split(item, option)
        try:
            found[name] = float(value)
        except ValueError:
            raise typer.BadParameter(f"{item!r} does not end in a number.", param_hint=option) from None
    return found


def pair_names(items: Sequence[str], option: str) -> list[tuple[str, str]]:
    """Read A,B items."""
    pairs = []
    for item in items:
        names = [name.strip() for name in item.split(",")]
        if len(names) != 2 or not all(names):
            raise typer.BadParameter(f"{item!r} is not two names with a comma between.", param_hint=option)
        pairs.append((names[0], names[1]))
    return pairs


def _split(item: str, option: str) -> tuple[str, str]:
    key, equals, value = item.partition("=")
    if not equals or not key:
        raise typer.BadParameter(f"{item!r} is not KEY=VALUE.", param_hint=option)
    return key.strip(), value.strip()
