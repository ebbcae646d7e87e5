"""The command line tool."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from .paths import ROOT, TARGET


def tool() -> Path:
    """The release build of `dualarm`."""
    path = TARGET / "release" / ("dualarm.exe" if sys.platform == "win32" else "dualarm")
    if not path.is_file():
        pytest.fail("the command line tool is not built: run `cargo build --release`", pytrace=False)
    return path


def dualarm(*arguments: str, cwd: Path = ROOT) -> subprocess.CompletedProcess[str]:
    """Runs the tool; the caller looks at the exit code."""
    return subprocess.run([tool(), *arguments], cwd=cwd, capture_output=True, text=True)
