"""What `dualarm simulate` and `dualarm compare` take: the table of docs/performance.md, "The tool".

    cargo run --release -- package
    python -m tests.studies.tool_cost
    python -m tests.studies.tool_cost --before FOLDER       # beside the program and FMUs of an earlier version in that folder, in turns

Half a minute; the machine should have nothing else to do. Not for Windows.
"""

from __future__ import annotations

import argparse
import os
import platform
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass, field
from pathlib import Path
from statistics import median

from tests.studies.performance import ROOT, processor, table, write

#: Runs in turns of each version.
RUNS = 40
#: Task, its arguments, and what is wanted: wall time for a command somebody waits for, processor time for one that uses all processors [s].
TASKS = [
    ("`simulate nabfc-r --stop 8`, wall time", "wall", 0.040, ["simulate", "nabfc-r", "--stop", "8"]),
    ("`simulate nabfc --stop 8`, wall time", "wall", 0.040, ["simulate", "nabfc", "--stop", "8"]),
    ("`compare --no-package --no-matrix`, processor time", "processor", 0.4, ["compare", "--no-package", "--no-matrix"]),
]


@dataclass
class Version:
    """A program, its FMUs, and what it took."""

    program: Path
    fmus: Path
    wall: list[float] = field(default_factory=list)
    processor: list[float] = field(default_factory=list)
    memory: int = 0

    def run(self, arguments: list[str], results: Path) -> None:
        out = ["--out", str(results)] if arguments[0] == "compare" else []
        begin = time.perf_counter()
        child = subprocess.Popen([self.program, *arguments, "--fmus", self.fmus, *out], cwd=results, stdout=subprocess.DEVNULL,
                                 stderr=subprocess.PIPE, text=True)
        _, status, used = os.wait4(child.pid, 0)
        self.wall.append(time.perf_counter() - begin)
        said = child.stderr.read()
        child.returncode = os.waitstatus_to_exitcode(status)
        if child.returncode:
            sys.exit(f"error: {self.program} {' '.join(arguments)} ended with {child.returncode}:\n{said}")
        self.processor.append(used.ru_utime + used.ru_stime)
        # Linux counts KiB, macOS bytes.
        self.memory = max(self.memory, used.ru_maxrss // (1024 if platform.system() == "Darwin" else 1))


def programs(before: Path | None) -> list[tuple[Path, Path]]:
    name = "dualarm"
    subprocess.run(["cargo", "build", "--quiet", "--release", "-p", name], check=True, cwd=ROOT)
    target = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")) / "release"
    versions = [(target / name, ROOT / "dist")]
    return versions + ([] if before is None else [(before / name, before)])


def rows(before: Path | None) -> list[list[object]]:
    result: list[list[object]] = []
    paths = programs(before)
    for what, kind, target, arguments in TASKS:
        versions = [Version(program, fmus) for program, fmus in paths]
        # All into one folder: results replace those of the run before, as they do where people work.
        with tempfile.TemporaryDirectory() as results:
            for version in versions * RUNS:
                version.run(arguments, Path(results))
        seconds = [getattr(version, kind) for version in versions]
        result.append([what, *(f"{min(each):.3f} s ({median(each):.3f} s)" for each in seconds), *[""] * (2 - len(seconds)),
                       f"{target} s", "met" if min(seconds[0]) <= target else "missed"])
        if kind == "processor":
            memory = [f"{version.memory / 1024:.0f} MiB" for version in versions]
            limit = 80e6 / 2**20
            result.append(["the same, most memory of any run", *memory, *[""] * (2 - len(memory)), "80 MB",
                           "met" if versions[0].memory / 1024 <= limit else "missed"])
    return result


def main() -> None:
    parser = argparse.ArgumentParser(description='Measures the tool and writes the table of docs/performance.md, "The tool".')
    parser.add_argument("--before", type=Path, metavar="FOLDER", help="folder with an earlier `dualarm` and its FMUs, to run in turns")
    before = parser.parse_args().before
    lines = [f"Measured on {processor()}, {os.cpu_count()} of its processors; the lowest of {RUNS} runs in turns, in brackets the median.", "",
             *table(["", "now", "before", "target", ""], rows(None if before is None else before.resolve(strict=True)))]
    write("<!-- measured: python -m tests.studies.tool_cost -->", "<!-- end of the tool -->", lines)


if __name__ == "__main__":
    main()
