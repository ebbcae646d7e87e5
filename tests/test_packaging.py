"""The packaging program: what it refuses, and archives that are joined."""

from __future__ import annotations

import os
import shutil
import subprocess
import zipfile
from pathlib import Path

import pytest

from .support.paths import DIST, ROOT

PROGRAM = (ROOT / os.environ.get("CARGO_TARGET_DIR", "target")).resolve() / "release" / "plant-fmu"
FMU = DIST / "DualArmPlant.fmu"


#: What the libraries for linux64 may take [bytes], some 7 % above what they take: room for another compiler, not for another
#: copy of what is there once. What the bytes are: docs/performance.md, "Size of the libraries".
LARGEST = {"NabfcController": 940_000, "DualArmPlant": 920_000, "GraspInstruments": 575_000}


@pytest.mark.parametrize("name", LARGEST)
def test_libraries_stay_as_short_as_they_are(name: str) -> None:
    with zipfile.ZipFile(DIST / f"{name}.fmu") as archive:
        path = f"binaries/linux64/{name}.so"
        if path not in archive.namelist():
            pytest.skip("built for other platforms")
        assert archive.getinfo(path).file_size < LARGEST[name]


def package(out: Path, *arguments: object) -> subprocess.CompletedProcess[str]:
    """The plant's packaging program, as if cargo ran it."""
    if not PROGRAM.is_file():
        pytest.skip(f"{PROGRAM} is not built: `cargo run --release -- package` does it")
    environment = {**os.environ, "CARGO": "cargo", "CARGO_MANIFEST_DIR": str(ROOT / "plant-fmu")}
    command = [PROGRAM, "--out", out, *arguments]
    return subprocess.run(list(map(str, command)), env=environment, capture_output=True, text=True, check=False)


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The plant's library, out of its archive."""
    with zipfile.ZipFile(FMU) as archive:
        name = next(name for name in archive.namelist() if name.startswith("binaries/"))
        return Path(archive.extract(name, tmp_path_factory.mktemp("library")))


def test_the_built_library_gives_the_same_archive(library: Path, tmp_path: Path) -> None:
    done = package(tmp_path, "--library", library)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / FMU.name).read_bytes() == FMU.read_bytes()


def test_what_is_no_library_of_this_model_is_refused(library: Path, tmp_path: Path) -> None:
    empty, cut, other = tmp_path / "empty.so", tmp_path / "cut.so", tmp_path / "other.so"
    empty.write_bytes(b"")
    cut.write_bytes(library.read_bytes()[:4000])
    with zipfile.ZipFile(FMU) as archive:
        guid = archive.read("modelDescription.xml").decode().split('guid="')[1].split('"')[0]
    other.write_bytes(library.read_bytes().replace(guid.encode(), guid[::-1].encode()))
    for file, reason in [
        (tmp_path / "missing.so", "cannot read"),
        (empty, "not a shared library"),
        (cut, "library"),
        (Path(shutil.which("python3") or "").resolve(), "shared library"),
        (other, "FMI2_EXPORT_GUIDS="),
    ]:
        done = package(tmp_path / "out", "--library", file)
        assert done.returncode == 1, file
        assert reason in done.stderr
    twice = package(tmp_path / "out", "--library", library, "--library", library)
    assert "second one for" in twice.stderr
    assert not list((tmp_path / "out").glob("*"))


def test_another_models_archive_is_never_replaced(library: Path, tmp_path: Path) -> None:
    shutil.copy(DIST / "PdController.fmu", tmp_path / FMU.name)
    done = package(tmp_path, "--library", library)
    assert done.returncode == 1
    assert "of the crate controller-fmu" in done.stderr
    (tmp_path / FMU.name).rename(tmp_path / "dualarmplant.fmu")
    shutil.copy(FMU, tmp_path / "dualarmplant.fmu")
    done = package(tmp_path, "--library", library)
    assert done.returncode == 1
    assert "take both names for the same" in done.stderr


def test_archives_of_the_same_description_are_joined(library: Path, tmp_path: Path) -> None:
    # What another machine would make: the same, for a platform that the standard names; here its library is not run.
    elsewhere = tmp_path / "elsewhere.fmu"
    done = package(tmp_path, "--library", library, "--merge", FMU)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / FMU.name).read_bytes() == FMU.read_bytes()
    done = package(tmp_path, "--library", library, "--merge", DIST / "PdController.fmu")
    assert "another version of the sources" in done.stderr
    with zipfile.ZipFile(FMU) as old, zipfile.ZipFile(elsewhere, "w") as new:
        new.writestr("modelDescription.xml", old.read("modelDescription.xml"))
        new.writestr("binaries/win64/DualArmPlant.dll", b"no library")
    done = package(tmp_path, "--library", library, "--merge", elsewhere)
    assert done.returncode == 1
    assert "binaries/win64/DualArmPlant.dll: it is not a shared library" in done.stderr


def test_platforms_are_those_of_the_standard(library: Path, tmp_path: Path) -> None:
    unknown = package(tmp_path, "--platform", "linux")
    assert unknown.returncode == 2
    assert "linux64, win64" in unknown.stderr
    absent = package(tmp_path, "--library", library, "--require", "linux64,aarch64-windows")
    assert absent.returncode == 1
    assert "aarch64-windows is required" in absent.stderr
