"""What tests of several files look at and takes long to make: the first process of pytest that needs it makes it."""

from __future__ import annotations

import os
import sqlite3
from collections.abc import Callable
from pathlib import Path

import pytest

# So long a test waits for another process that makes what it needs, in s.
LONGEST = 1800


def once(temporary: pytest.TempPathFactory, name: str, make: Callable[[Path], None]) -> Path:
    """A folder of this name that all processes of one test run share, with what `make` has put into it.

    `make` writes into the folder that it gets. If it fails, the test that waits for it in another process fails, too. If its process
    ends, the next one that waits makes it again.
    """
    base = temporary.getbasetemp()
    # pytest-xdist gives each of its processes a folder within that of the run.
    shared = base.parent if "PYTEST_XDIST_WORKER" in os.environ else base
    done, failed = (shared / f"{name}.{end}" for end in ("done", "failed"))
    # A lock of the operating system, on each of them; it is gone with its process.
    lock = sqlite3.connect(shared / f"{name}.lock", timeout=LONGEST, isolation_level=None)
    try:
        lock.execute("BEGIN EXCLUSIVE")
        if done.exists():
            return Path(done.read_text(encoding="utf-8"))
        assert not failed.exists(), f"another process could not make {name}"
        # A process that was ended may have left a part.
        number = sum(1 for _ in shared.glob(f"{name}-*"))
        folder = shared / f"{name}-{number}"
        folder.mkdir()
        try:
            make(folder)
        except BaseException:
            failed.touch()
            raise
        done.write_text(str(folder), encoding="utf-8")
        return folder
    finally:
        lock.close()
