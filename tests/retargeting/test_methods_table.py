"""The table of methods: each is what it is listed as, and is loaded only when it is asked for."""

from __future__ import annotations

import subprocess
import sys

from mien.retargeting import METHODS


def test_every_method_is_listed_by_its_own_name() -> None:
    assert [method.name for method in METHODS.values()] == list(METHODS)
    assert len(METHODS) == len(set(METHODS.values()))


def test_asking_for_one_method_loads_no_other() -> None:
    program = "import sys; from mien.retargeting import METHODS; METHODS['copy']; print(*sys.modules)"
    loaded = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True).stdout.split()
    assert "mien.retargeting.copying" in loaded
    assert "mien.retargeting.latent" not in loaded
