"""The Python wheel and the archive of a release: installed and unpacked as their users do, without a compiler."""

from __future__ import annotations

import hashlib
import importlib.util
import os
import platform as machine
import subprocess
import sys
import venv
import zipfile
from importlib.metadata import version
from pathlib import Path
from types import ModuleType

import pytest

from .support.contract import FMUS
from .support.paths import DIST, ROOT, TARGET

PLATFORM = {
    ("linux", "x86_64"): "linux64",
    ("linux", "aarch64"): "aarch64-linux",
    ("win32", "AMD64"): "win64",
    ("darwin", "x86_64"): "darwin64",
    ("darwin", "arm64"): "aarch64-darwin",
}.get((sys.platform, machine.machine()))
SUFFIX = ".exe" if sys.platform == "win32" else ""
TOOL = TARGET / "release" / f"dualarm{SUFFIX}"

pytestmark = pytest.mark.skipif(PLATFORM is None, reason="no wheels are made for this platform")


@pytest.fixture(scope="module")
def downloads() -> ModuleType:
    """`python/downloads.py`."""
    spec = importlib.util.spec_from_file_location("downloads", ROOT / "python" / "downloads.py")
    assert spec
    assert spec.loader
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(scope="module")
def installed(downloads: ModuleType, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of programs of a clean environment that has the wheel."""
    folder = tmp_path_factory.mktemp("clean environment")
    # `cargo xtask release` has one to look at.
    given = os.environ.get("DUALARM_WHEEL")
    wheel = Path(given) if given else downloads.wheel(DIST, TOOL, PLATFORM, folder)
    # A pip of its own takes longer to install than all the rest; from 22.3 on another one's can do it.
    has_own = tuple(int(part) for part in version("pip").split(".")[:2]) < (22, 3)
    venv.create(folder / "venv", with_pip=has_own)
    programs = folder / "venv" / ("Scripts" if SUFFIX else "bin")
    python = programs / f"python{SUFFIX}"
    pip = [python, "-m", "pip"] if has_own else [sys.executable, "-m", "pip", "--python", python]
    subprocess.run([*pip, "--disable-pip-version-check", "install", "--quiet", "--no-index", wheel], check=True)
    return programs


def clean() -> dict[str, str]:
    """An environment in which no cargo is found."""
    hidden = ("CARGO", "RUST", "PYTHON")
    kept = {name: value for name, value in os.environ.items() if not name.startswith(hidden)}
    return {**kept, "PATH": "" if not SUFFIX else os.environ["SYSTEMROOT"]}


def run(*command: object, cwd: Path) -> str:
    done = subprocess.run(list(map(str, command)), capture_output=True, check=False, cwd=cwd, env=clean())
    assert done.returncode == 0, done.stderr.decode(errors="replace")
    return done.stdout.decode("utf-8")


def test_command_runs_the_main_job_from_the_wheel(installed: Path, tmp_path: Path) -> None:
    """In an empty folder, without cargo: the FMUs are those of the wheel, and nothing is built.

    The matrix, which takes twenty times as long, would not show more of this.
    """
    text = run(installed / f"dualarm{SUFFIX}", "compare", "--no-matrix", cwd=tmp_path)
    assert "NABFC" in text
    assert (tmp_path / "results" / "report.html").is_file()
    assert {path.name for path in tmp_path.iterdir()} == {"results"}


def test_module_names_its_fmus(installed: Path, tmp_path: Path) -> None:
    program = (
        "import dualarm\n"
        "assert open(dualarm.fmu('NabfcController'), 'rb').read(2) == b'PK'\n"
        "assert open(dualarm.system('DualArmGrasp-PD'), 'rb').read(2) == b'PK'\n"
        "try:\n    dualarm.fmu('Nabfc')\n"
        "except ValueError as error:\n    assert 'NabfcController' in str(error)\n"
        "print(*dualarm.fmus())\n"
    )
    python = installed / f"python{SUFFIX}"
    assert run(python, "-c", program, cwd=tmp_path).split() == sorted(FMUS)
    assert "Usage" in run(python, "-m", "dualarm", "--help", cwd=tmp_path)


def test_wheel_says_where_it_runs(downloads: ModuleType, tmp_path: Path) -> None:
    """The same files give the same bytes, and the tag names no older system than the tool needs."""
    one, other = (downloads.wheel(DIST, TOOL, PLATFORM, tmp_path / part) for part in ("a", "b"))
    assert one.name == other.name
    assert one.read_bytes() == other.read_bytes()
    if PLATFORM == "linux64":
        assert f"manylinux_2_{max(downloads.glibc(TOOL), 17)}_x86_64" in one.name


def test_archive_is_unpacked_and_started(downloads: ModuleType, tmp_path: Path) -> None:
    packed = downloads.archive(DIST, TOOL, PLATFORM, tmp_path)
    with zipfile.ZipFile(packed) as archive:
        archive.extractall(tmp_path)
    tool = tmp_path / packed.stem / f"dualarm{SUFFIX}"
    tool.chmod(0o755)
    empty = tmp_path / "somewhere else"
    empty.mkdir()
    run(tool, "simulate", "--controller", "pd", "--stop", "0.01", "-o", "out.csv", cwd=empty)
    assert (empty / "out.csv").stat().st_size > 1000
    downloads.checksums(tmp_path)
    sums = dict(line.split("  ")[::-1] for line in (tmp_path / "SHA256SUMS").read_text("utf-8").splitlines())
    assert sums[packed.name] == hashlib.sha256(packed.read_bytes()).hexdigest()


def test_notes_say_what_was_run(downloads: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What has passed its tests is known by its bytes: a library built anew, or another platform's, has not."""
    monkeypatch.setattr(downloads, "ROOT", tmp_path)
    monkeypatch.setattr(downloads, "version", lambda: "1.0.0")
    (tmp_path / "CHANGELOG.md").write_text("# Changelog\n\n## [Unreleased]\n\n- new\n\n## [1.0.0]\n\n- old\n")
    (tmp_path / "fmus").mkdir()
    fmu = tmp_path / "fmus" / "Model.fmu"
    records = [tmp_path / "win64.sha256", tmp_path / "linux64.sha256"]

    def packed(**libraries: str) -> None:
        with zipfile.ZipFile(fmu, "w") as archive:
            for platform, content in libraries.items():
                archive.writestr(f"binaries/{platform}/Model", content)

    def said() -> str:
        downloads.notes(tmp_path, records)
        return (tmp_path / "NOTES.md").read_text("utf-8")

    packed(win64="a", linux64="b")
    assert said().count("**unverified**") == 2
    downloads.tested(records[0], [fmu])
    text = said()
    assert text.startswith("- new\n\n### Platforms\n")
    assert "old" not in text
    assert "| `win64` | libraries in the FMUs | tested under wine |" in text
    assert "| `linux64` | libraries in the FMUs | built, run by nobody: **unverified** |" in text
    packed(win64="another", linux64="b")
    assert said().count("**unverified**") == 2
