"""How much memory a step takes at most, as the system counts it, without slowing it down."""

from __future__ import annotations

import ctypes
import gc
import re
from pathlib import Path

STATUS, RESET = Path("/proc/self/status"), Path("/proc/self/clear_refs")


class Peak:
    """The most memory used since it was made; only Linux tells, so elsewhere it is unknown."""

    def __init__(self) -> None:
        gc.collect()
        _give_back()
        try:
            RESET.write_text("5", encoding="ascii")
            self._before: float | None = _megabytes("VmRSS")
        except OSError:
            self._before = None

    def above(self) -> float:
        """Return the most memory used beyond what was in use before [MB]; NaN where unknown."""
        return float("nan") if self._before is None else max(0.0, _megabytes("VmHWM") - self._before)


def _give_back() -> None:
    """Let the allocator return what it keeps for later, which would hide what the next step takes."""
    try:
        ctypes.CDLL(None).malloc_trim(0)
    except (OSError, AttributeError, TypeError):
        return


def _megabytes(key: str) -> float:
    found = re.search(rf"^{key}:\s+(\d+) kB$", STATUS.read_text(encoding="ascii"), flags=re.MULTILINE)
    return int(found[1]) / 1024 if found else float("nan")
