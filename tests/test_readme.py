"""The README is true: its script runs, and its results are those of the tool."""

import re
import subprocess
import sys
from pathlib import Path

from .support.paths import ROOT
from .support.tool import dualarm

README = (ROOT / "README.md").read_text(encoding="utf-8")


def test_the_script_for_fmpy_reaches_the_wanted_force() -> None:
    """The first Python block, run as it stands in the repository's root."""
    match = re.search(r"```python\n(.*?)```", README, re.DOTALL)
    assert match, "the README has no Python block"
    run = subprocess.run([sys.executable, "-c", match.group(1)], cwd=ROOT, capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stderr
    forces = [float(value) for value in re.findall(r"([0-9.]+) N", run.stdout)]
    # Settled within 2 % after 0.31 s; at 1 s what is left is below 0.1 %.
    assert len(forces) == 2
    assert all(abs(force - 0.5) < 0.5e-3 for force in forces), run.stdout


def test_the_results_table_is_what_the_tool_writes(tmp_path: Path) -> None:
    """Row by row: a change of gains or model must reach the README."""
    done = dualarm("compare", "--no-package", "--no-matrix", "--quiet", "--out", str(tmp_path))
    assert done.returncode == 0, done.stderr
    shown = [line for line in README.split("<!-- results")[1].split("<!-- end")[0].splitlines() if line.startswith("|")]
    written = [line for line in (tmp_path / "metrics.md").read_text(encoding="utf-8").splitlines() if line.startswith("|")]
    assert len(shown) > 3
    assert shown == written[: len(shown)]
