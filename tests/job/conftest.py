"""Faces to work on: the small one as files, and the built-in demonstration, made once."""

from __future__ import annotations

from pathlib import Path

import pytest

from mien.job.demo import prepare
from mien.job.request import Request, Result
from mien.job.retarget import run
from tests.job.small_files import SmallFiles, write_small_files


@pytest.fixture
def files(tmp_path: Path) -> SmallFiles:
    return write_small_files(tmp_path)


@pytest.fixture(scope="session")
def demo(tmp_path_factory: pytest.TempPathFactory) -> Request:
    """The built-in job, on files that no test changes."""
    return prepare(tmp_path_factory.mktemp("demo"))


@pytest.fixture(scope="session")
def demo_result(demo: Request) -> Result:
    return run(demo)
