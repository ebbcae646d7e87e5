"""The FMUs of the dual-arm grasp, and the tool that runs them.

>>> import dualarm
>>> dualarm.fmu("NabfcController")  # the path of an FMU, for FMPy or any other importer
>>> dualarm.fmus()  # the names of all
>>> dualarm.run("simulate", "--controller", "nabfc", "-o", "run.csv")  # as the command `dualarm` in a shell
"""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

__all__ = ["fmu", "fmus", "main", "run", "system", "systems"]
__version__ = "@VERSION@"

#: The tool looks for its FMUs beside itself.
_FOLDER = Path(__file__).parent / "bin"
_FMUS = _FOLDER / "fmus"


def fmus() -> list[str]:
    """Names of the FMUs."""
    return sorted(path.stem for path in _FMUS.glob("*.fmu"))


def systems() -> list[str]:
    """Names of the systems: plant and controller, connected (SSP 1.0)."""
    return sorted(path.stem for path in _FMUS.glob("*.ssp"))


def fmu(name: str) -> str:
    """The path of an FMU, e.g. of `NabfcController`."""
    return _file(name, "fmu", fmus())


def system(name: str) -> str:
    """The path of a system, e.g. of `DualArmGrasp-NABFC`."""
    return _file(name, "ssp", systems())


def _file(name: str, suffix: str, known: list[str]) -> str:
    if name not in known:
        raise ValueError(f"there is no {name}.{suffix}; there are {', '.join(known)}")
    return str(_FMUS / f"{name}.{suffix}")


def run(*arguments: str) -> int:
    """Runs the tool; its exit code. `run("--help")` says what it can do."""
    program = _FOLDER / ("dualarm.exe" if sys.platform == "win32" else "dualarm")
    return subprocess.call([str(program), *map(str, arguments)])


def main() -> None:
    """The command `dualarm`."""
    sys.exit(run(*sys.argv[1:]))
