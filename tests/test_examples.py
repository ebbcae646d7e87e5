"""The examples run as they stand, without a display, and what they show is true."""

from __future__ import annotations

import csv
import os
import re
import runpy
import subprocess
import sys
from pathlib import Path

import nbclient
import nbformat
import numpy as np
import pytest
from fmpy import simulate_fmu
from fmpy.validation import validate_fmu

from .support.paths import DIST, ROOT, helper
from .support.tool import dualarm

EXAMPLES = ROOT / "examples"
WITHOUT_DISPLAY = {**os.environ, "MPLBACKEND": "Agg"}
# nbclient gives a kernel a minute to start and four seconds to hand its output over. A busy machine may take longer;
# half an hour is there for a kernel that hangs.
WITHOUT_HURRY = {"startup_timeout": 1800, "iopub_timeout": 1800}
GOAL = 0.5  # wanted contact force of the paper's case, in N
PNG = b"\x89PNG"


def example(name: str, picture: Path, *arguments: str) -> str:
    """What the example prints; its plot is in `picture`."""
    command = [sys.executable, str(EXAMPLES / name), "--save", str(picture), *arguments]
    # Elsewhere than in the repository: a person's working directory is anywhere.
    run = subprocess.run(command, cwd=picture.parent, env=WITHOUT_DISPLAY, capture_output=True, text=True)
    assert run.returncode == 0, run.stderr
    assert picture.read_bytes().startswith(PNG)
    return run.stdout


def numbers(pattern: str, text: str) -> list[float]:
    """The numbers that the groups of `pattern` match, in order."""
    found = re.findall(pattern, text)
    return [float(value) for match in found for value in (match if isinstance(match, tuple) else (match,))]


def test_simulate_plant(tmp_path: Path) -> None:
    """The torque gives back the momentum it gave, so the motion ends where a rigid body would: τT²/I."""
    angles = numbers(r"hub angles at 1 s: (\S+) and (\S+) rad", example("simulate_plant.py", tmp_path / "plot.png"))
    hubs, arms, object_ = 2 * 0.0073, 2 * 0.054 * 0.2**3 / 3, 0.5 * 0.2**2
    rigid = 0.05 * 0.1**2 / (hubs + arms + object_)
    # The slowest mode decays with 11.8 1/s: at 1 s, 0.8 s after the torque, e^-9.4 of the motion is left.
    assert angles == pytest.approx([rigid, rigid], abs=np.exp(-9.4) * rigid * 4)


@pytest.mark.parametrize("name", ["grasp.py", "own_controller.py", "simulate_plant.py"])
def test_copied_elsewhere_they_run(name: str, tmp_path: Path) -> None:
    """A copy has no repository around it: the folder of the FMUs is named, or the script says how to name it."""
    for file in {name, "grasp.py"}:
        (tmp_path / file).write_bytes((EXAMPLES / file).read_bytes())
    option = ["--plant", str(DIST / "DualArmPlant.fmu")] if name == "simulate_plant.py" else ["--dist", str(DIST)]
    command = [sys.executable, str(tmp_path / name), "--save", str(tmp_path / "plot.png")]
    run = subprocess.run([*command, *option], cwd=tmp_path, env=WITHOUT_DISPLAY, capture_output=True, text=True)
    assert run.returncode == 0, run.stderr
    if name != "simulate_plant.py":
        run = subprocess.run(command, cwd=tmp_path, env=WITHOUT_DISPLAY, capture_output=True, text=True)
        assert run.returncode == 1
        assert "name the folder of the FMUs with --dist" in run.stderr


def test_grasp(tmp_path: Path) -> None:
    """The wanted force follows the reference; settling is that of the paper's claim."""
    final, settled = r"force \d: (\S+) N", r"within 2 % from (\S+) s"
    printed = example("grasp.py", tmp_path / "plot.png")
    assert numbers(final, printed) == pytest.approx([GOAL, GOAL], rel=1e-3)
    assert max(numbers(settled, printed)) < 0.5
    printed = example("grasp.py", tmp_path / "other.png", "--set", "lambda1_ref=-0.3", "--set", "preset=2")
    assert numbers(final, printed) == pytest.approx([0.3, 0.3], rel=1e-3)


@pytest.mark.parametrize(
    ("arguments", "named"),
    [
        (("--controller", "Foo"), "PdController"),
        (("--set", "M=abc"), "NAME=NUMBER"),
        (("--set", "M"), "NAME=NUMBER"),
    ],
)
def test_grasp_says_what_a_wrong_option_should_be(
    arguments: tuple[str, ...], named: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    # As a program of its own, it would import matplotlib anew each time.
    monkeypatch.setattr(sys, "argv", ["grasp.py", *arguments])
    with pytest.raises(SystemExit) as stopped:
        runpy.run_path(str(EXAMPLES / "grasp.py"), run_name="__main__")
    assert stopped.value.code == 2
    assert named in capsys.readouterr().err


def test_grasp_names_an_unknown_parameter(tmp_path: Path) -> None:
    command = [sys.executable, str(EXAMPLES / "grasp.py"), "--set", "mass=1"]
    run = subprocess.run(command, cwd=tmp_path, env=WITHOUT_DISPLAY, capture_output=True, text=True)
    assert run.returncode == 1
    assert "mass" in run.stderr
    assert "Traceback" not in run.stderr


def assert_ranking(printed: str) -> None:
    """NABFC before PDS before PD, and each as the paper says: less than 0.5 s, almost 2 s, much longer."""
    times = numbers(r"(?m)^\w+ .*?(\d\.\d+) s.*?(\d\.\d+) s", printed)
    nabfc, pds, pd = (max(times[i : i + 2]) for i in (0, 2, 4))
    assert nabfc < 0.5 < pds < 2 < pd


def test_swap_controller(tmp_path: Path) -> None:
    assert_ranking(example("swap_controller.py", tmp_path / "plot.png"))


def test_own_controller(tmp_path: Path) -> None:
    """It really grasps. Double poles at 30 1/s settle in 5.8/30 s; damping the law does not know adds to it."""
    printed = example("own_controller.py", tmp_path / "plot.png")
    assert numbers(r"force \d: (\S+) N", printed) == pytest.approx([GOAL, GOAL], rel=1e-3)
    assert min(numbers(r"within 2 % from (\S+) s", printed)) > 5.8 / 30
    assert max(numbers(r"within 2 % from (\S+) s", printed)) < 0.5


def test_state_rollback(tmp_path: Path) -> None:
    """Stiffness helps against a push until it makes the object swing; the restored twin is the same to the bit."""
    printed = example("state_rollback.py", tmp_path / "plot.png")
    errors = numbers(r"is (\S+) mN off", printed)
    assert len(errors) == 5
    assert errors[0] > errors[1] > errors[2] > errors[3] < errors[4]
    assert "best: kp = 5000 N/m" in printed
    assert "gives the same bits" in printed


@pytest.fixture(scope="module")
def notebook() -> nbformat.NotebookNode:
    """The notebook, executed."""
    content = nbformat.read(EXAMPLES / "paper_comparison.ipynb", as_version=4)
    where = {"metadata": {"path": str(EXAMPLES)}}
    return nbclient.NotebookClient(content, resources=where, **WITHOUT_HURRY).execute()


def test_notebook_shows_the_comparison(notebook: nbformat.NotebookNode) -> None:
    outputs = [output for cell in notebook.cells for output in cell.get("outputs", [])]
    printed = "".join(output.text for output in outputs if output.output_type == "stream" and output.name == "stdout")
    assert_ranking(printed)
    # EI w = F l³/3: the deflection of a clamped beam that presses with the wanted force.
    deflection = 1e3 * GOAL * 0.2**3 / (3 * 0.115)
    assert numbers(r"w\(l\) at the end: (\S+) mm and (\S+) mm", printed) == pytest.approx(
        [deflection, -deflection], rel=2e-3
    )
    assert sum("image/png" in output.get("data", {}) for output in outputs) == 4


def test_notebook_is_stored_without_outputs() -> None:
    """Stored outputs would be big, and wrong after the next change."""
    stored = nbformat.read(EXAMPLES / "paper_comparison.ipynb", as_version=4)
    assert not any(cell.get("outputs") or cell.get("execution_count") for cell in stored.cells)


@pytest.fixture(scope="module")
def hub_friction() -> Path:
    """The FMU of the Rust example, packaged by its program before the tests."""
    return helper("HubFriction.fmu")


def test_rust_example_is_a_valid_fmu_with_exact_steps(hub_friction: Path) -> None:
    """At constant speed Dahl's friction grows as C (1 − e^(−σ|v|t/C)); hub 2 turns the other way."""
    assert validate_fmu(str(hub_friction)) == []
    coulomb, stiffness, speed = 0.03, 30.0, 0.02
    held = np.array(
        [(0.0, speed, -speed), (1.0, speed, -speed)],
        dtype=[("time", float), ("theta1_dot", float), ("theta2_dot", float)],
    )
    result = simulate_fmu(str(hub_friction), stop_time=0.2, output_interval=0.01, input=held)
    friction = coulomb * (1 - np.exp(-stiffness * speed * result["time"] / coulomb))
    assert result["delta_f1"] == pytest.approx(-friction, abs=1e-14)
    assert result["delta_f2"] == pytest.approx(friction, abs=1e-14)


@pytest.mark.parametrize(("controller", "reached"), [("Nabfc", True), ("Pds", False)])
def test_rust_example_joins_the_loop(hub_friction: Path, tmp_path: Path, controller: str, reached: bool) -> None:
    """Wired by equal names. The networks of NABFC make up for the friction, PDS stays off its target."""
    table = tmp_path / "friction.csv"
    fmus = (str(DIST / "DualArmPlant.fmu"), str(DIST / f"{controller}Controller.fmu"), str(hub_friction))
    done = dualarm("simulate", *fmus, "--stop", "3", "--quiet", "-o", str(table))
    assert done.returncode == 0, done.stderr
    with table.open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    # All of it while the hub turns; at rest as much as it is pushed with.
    assert max(abs(float(row["delta_f1"])) for row in rows) == pytest.approx(0.03, rel=0.05)
    last = rows[-1]
    assert (abs(float(last["contact_force1"]) - GOAL) < 1e-3) == reached
