"""The command line tool."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from .once import once
from .paths import DIST, ROOT, TARGET


def tool() -> Path:
    """The release build of `dualarm`."""
    path = TARGET / "release" / ("dualarm.exe" if sys.platform == "win32" else "dualarm")
    if not path.is_file():
        pytest.fail("the command line tool is not built: run `cargo build --release`", pytrace=False)
    return path


@pytest.fixture(scope="session")
def verification(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with all that `dualarm verify` writes, and what it prints with `--json`, in `printed.json`."""

    def verify(folder: Path) -> None:
        done = dualarm("verify", "--no-package", "--fmus", str(DIST), "--out", str(folder), "--json")
        assert done.returncode == 0, done.stderr
        (folder / "printed.json").write_text(done.stdout, encoding="utf-8")

    return once(tmp_path_factory, "verification", verify)


def dualarm(*arguments: str, cwd: Path = ROOT) -> subprocess.CompletedProcess[str]:
    """Runs the tool; the caller looks at the exit code."""
    return subprocess.run([tool(), *arguments], cwd=cwd, capture_output=True, text=True)
