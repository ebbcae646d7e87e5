"""What tests of several files look at and takes long to make: the first process of pytest that needs it makes it."""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from pathlib import Path

import pytest


def once(temporary: pytest.TempPathFactory, name: str, make: Callable[[Path], None]) -> Path:
    """A folder of this name that all processes of one test run share, with what `make` has put into it.

    `make` writes into the folder that it gets. If it fails, the test that waits for it in another process fails, too.
    """
    base = temporary.getbasetemp()
    # pytest-xdist gives each of its processes a folder within that of the run.
    shared = base.parent if "PYTEST_XDIST_WORKER" in os.environ else base
    folder, done, failed = (shared / f"{name}{suffix}" for suffix in ("", ".done", ".failed"))
    try:
        folder.mkdir()
    except FileExistsError:
        while not done.exists():
            assert not failed.exists(), f"another process could not make {name}"
            time.sleep(0.1)
        return folder
    try:
        make(folder)
    except BaseException:
        failed.touch()
        raise
    done.touch()
    return folder
