"""What goes wrong, said so that the person who meets it can act.

Every error a user can cause is a `MienError`: one paragraph that says what was
found, what was wanted, where, and what to do.  The command line prints that
paragraph and exits with 1; anything else that escapes is a bug of ours.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from difflib import get_close_matches


class MienError(Exception):
    """A mistake in what was given to mien, explained to the person who gave it."""


class FileError(MienError):
    """A file that is missing, damaged, or not what its name says."""


class InputError(MienError):
    """Values that cannot be used: wrong shape, not finite, contradictory."""


class MissingPackage(MienError):
    """An optional package that this file or picture needs is not installed."""

    def __init__(self, purpose: str, package: str, extra: str) -> None:
        super().__init__(
            f"{purpose} needs the package {package!r}, which is not installed. "
            f'Install it with: pip install "mien[{extra}]"'
        )


@dataclass(frozen=True)
class Note:
    """Something repaired or left out on the way: never silent, always counted.

    Attributes:
        code: a short stable identifier that scripts can match, e.g. `gaps-filled`.
        message: one sentence for a person.
        where: the file, marker, frame or shape it is about.
    """

    code: str
    message: str
    where: str = ""


def unknown(what: str, name: str, known: Iterable[str]) -> str:
    """Say that a name is unknown, with the closest known ones first."""
    names = list(known)
    spelled = {known_name.lower(): known_name for known_name in names}
    close = [spelled[match] for match in get_close_matches(name.lower(), list(spelled), n=3, cutoff=0.6)]
    hint = f" Did you mean {', '.join(map(repr, close))}?" if close else ""
    listed = ", ".join(names[:40]) + (f" … ({len(names)} in all)" if len(names) > 40 else "")
    return f"unknown {what} {name!r}.{hint} Known: {listed or 'none'}."
