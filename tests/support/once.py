"""What tests of several files look at and takes long to make: the first process of pytest that needs it makes it."""

from __future__ import annotations

import fcntl
import os
from collections.abc import Callable
from pathlib import Path

import pytest


def once(temporary: pytest.TempPathFactory, name: str, make: Callable[[Path], None]) -> Path:
    """A folder of this name that all processes of one test run share, with what `make` has put into it.

    `make` writes into the folder that it gets. If it fails or its process is killed, tests that wait for it in other processes fail, too.
    """
    base = temporary.getbasetemp()
    # pytest-xdist gives each of its processes a folder within that of the run.
    shared = base.parent if "PYTEST_XDIST_WORKER" in os.environ else base
    folder, done = shared / name, shared / f"{name}.done"
    with (shared / f"{name}.lock").open("w") as lock:
        # One process makes it, the others wait here; the system opens the lock when its process ends, however it ends.
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not done.exists():
            assert not folder.exists(), f"another process could not make {name}"
            folder.mkdir()
            make(folder)
            done.touch()
    return folder
