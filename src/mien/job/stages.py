"""Stages of a job: said as they begin, and timed."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager

Progress = Callable[[str], None]
Stage = Callable[[str], AbstractContextManager[None]]


def stopwatch(timing: dict[str, float], progress: Progress) -> Stage:
    """Return what times a stage and says that it begins."""

    @contextmanager
    def stage(name: str) -> Iterator[None]:
        progress(name)
        begin = time.perf_counter()
        yield
        timing[name] = round(time.perf_counter() - begin, 4)

    return stage
