"""FMUs of several platforms in one file, as the release workflow makes them."""

from __future__ import annotations

import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import numpy as np
import pytest
from fmpy import platform, simulate_fmu, supported_platforms
from fmpy.validation import validate_fmu

from .support.contract import FMUS
from .support.paths import DIST, ROOT, fmu_path

#: A platform that is not this one, and the ending of its libraries.
FOREIGN, SUFFIX = ("linux64", ".so") if platform == "win64" else ("win64", ".dll")


def merge(*folders: Path, out: Path) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, str(ROOT / ".github" / "merge_fmus.py"), *map(str, folders), "--out", str(out)]
    return subprocess.run(command, capture_output=True, text=True, check=False)


def rewritten(source: Path, target: Path, change: dict[str, bytes] | None = None) -> None:
    """A copy whose library is of another platform, and whose members are changed."""
    target.parent.mkdir(parents=True, exist_ok=True)
    with zipfile.ZipFile(source) as old, zipfile.ZipFile(target, "w") as new:
        for entry in old.infolist():
            name = entry.filename
            if name.startswith("binaries/"):
                name = f"binaries/{FOREIGN}/{Path(name).stem}{SUFFIX}"
            new.writestr(name, (change or {}).get(entry.filename, old.read(entry)))


@pytest.fixture
def platforms(tmp_path: Path) -> tuple[Path, Path]:
    here, there = tmp_path / "here", tmp_path / "there"
    here.mkdir()
    for name in FMUS:
        shutil.copy(fmu_path(name), here)
        rewritten(fmu_path(name), there / f"{name}.fmu")
    for system in DIST.glob("*.ssp"):
        shutil.copy(system, here)
    return here, there


def test_merged_fmus_hold_all_libraries_and_run(platforms: tuple[Path, Path], tmp_path: Path) -> None:
    out = tmp_path / "out"
    done = merge(*platforms, out=out)
    assert done.returncode == 0, done.stderr
    for name in FMUS:
        assert set(supported_platforms(str(out / f"{name}.fmu"))) == {platform, FOREIGN}
        assert validate_fmu(str(out / f"{name}.fmu")) == []
    ours, theirs = (
        simulate_fmu(str(path / "DualArmPlant.fmu"), stop_time=0.01, start_values={"theta1_dot_0": 1.0})
        for path in (out, platforms[0])
    )
    assert np.array_equal(ours, theirs)


def test_systems_hold_the_merged_fmus(platforms: tuple[Path, Path], tmp_path: Path) -> None:
    out = tmp_path / "out"
    assert merge(*platforms, out=out).returncode == 0
    systems = sorted(out.glob("*.ssp"))
    assert len(systems) == len(list(DIST.glob("*.ssp"))) > 0
    for system in systems:
        with zipfile.ZipFile(system) as archive:
            fmus = [name for name in archive.namelist() if name.endswith(".fmu")]
            assert {"DualArmPlant.fmu"} < {Path(name).name for name in fmus}
            for name in fmus:
                assert archive.read(name) == (out / Path(name).name).read_bytes()


def test_what_does_not_fit_together_is_refused(platforms: tuple[Path, Path], tmp_path: Path) -> None:
    here, there = platforms
    out = tmp_path / "out"
    same = merge(here, here, out=out)
    assert same.returncode == 1
    assert "both have binaries/" in same.stderr
    rewritten(fmu_path("PdController"), there / "PdController.fmu", {"modelDescription.xml": b"<another/>"})
    other = merge(here, there, out=out)
    assert other.returncode == 1
    assert "different descriptions" in other.stderr
    (there / "PdController.fmu").unlink()
    missing = merge(here, there, out=out)
    assert missing.returncode == 1
    assert "same .fmu files" in missing.stderr
    assert not out.exists()
