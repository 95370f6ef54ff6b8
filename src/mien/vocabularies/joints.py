"""What joints are called: which one is the head."""

from __future__ import annotations

import re
from collections.abc import Sequence


def head_of(names: Sequence[str]) -> int | None:
    """Return which joint is named like a head, the plainest name first; None if none is.

    `HeadTop_End`, `headFront` and `forehead` name other places.
    """
    said = [_words(name) for name in names]
    ranked = [(len(words), i) for i, words in enumerate(said) if words and words[-1] == "head"]
    return min(ranked)[1] if ranked else None


def _words(name: str) -> list[str]:
    """Return the words of a name in lower case, without the namespace before a colon or bar and numbers."""
    own = re.split(r"[:|]", name)[-1]
    return [word.lower() for word in re.findall(r"[A-Z]?[a-z]+|[A-Z]+(?![a-z])", own)]
