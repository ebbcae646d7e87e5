"""Cases and controllers of the user's own that cannot run: `dualarm compare` and `tune` say so, and are not silent about lost cells."""

import json
from pathlib import Path

import pytest

from .support.tool import dualarm

HEAD = 'title = "Mine"\nfmus = ["DualArmPlant.fmu", "NabfcController.fmu"]\n[experiment]\nstop = 0.02\nstep = 1e-3\n'


def case(folder: Path, name: str, text: str) -> str:
    file = folder / f"{name}.toml"
    file.write_text(HEAD + text, encoding="utf-8")
    return str(file)


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("[parameters]\ntau1_cmd = 0.1\n", "tau1_cmd drives, which would replace the value; leave it out"),
        ("[inputs]\ntau1_cmd.steps = [[0, 0.1]]\n", "tau1_cmd drives, which would replace the value; leave it out"),
        ("[parameters]\ntheta1 = 0.1\n", "DualArmPlant.theta1 cannot be set: it is an output"),
        ("[parameters]\nMm = 0.1\n", "did you mean M?"),
        ("[parameters]\nM = -1\n", "DualArmPlant.M must be from 1e-9"),
        ("[parameters]\nM = 1\nM = 2\n", "duplicate key"),
        ("[inputs]\ndelta_F.steps = []\n", "at least one point"),
        ("[parameters]\ndelta_F = 1\n", "it belongs under [inputs]"),
    ],
)
def test_a_case_that_cannot_run_is_refused_before_anything_runs(text: str, reason: str, tmp_path: Path) -> None:
    file, out = case(tmp_path, "mine", text), tmp_path / "results"
    for command in (
        ["simulate", file],
        ["compare", "--no-package", "--controllers", "nabfc-r,pid", "--cases", f"undisturbed,{file}", "--out", str(out)],
        ["compare", "--no-package", "--controllers", "pid", "--cases", f"undisturbed,{file}", "--out", str(out)],
        ["tune", "-c", "pid", "--cases", f"undisturbed,{file}", "--evaluations", "1", "--out", str(out / "pid.toml")],
    ):
        done = dualarm(*command)
        assert (done.returncode, f"{file}:" in done.stderr, reason in done.stderr) == (2, True, True), (command, done.stderr)
    assert not out.exists()


def test_a_controller_that_can_run_in_no_case_is_refused(tmp_path: Path) -> None:
    law = case(tmp_path, "law", "[parameters]\nM = 0.6\n")
    done = dualarm("compare", "--no-package", "--controllers", f"pid,{law}", "--cases", "undisturbed,light", "--out", str(tmp_path / "none"))
    assert (done.returncode, "law can run in no case: there is no variable \"M\"" in done.stderr) == (2, True), done.stderr


def test_a_step_beyond_the_end_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "short.toml"
    file.write_text(HEAD.replace("step = 1e-3", "step = 0.1"), encoding="utf-8")
    done = dualarm("compare", "--no-package", "--cases", str(file), "--controllers", "pid", "--out", str(tmp_path / "none"))
    assert (done.returncode, "a step of 0.1 s is longer than the run" in done.stderr) == (2, True), done.stderr


def test_what_some_controllers_have_fails_in_the_cells_of_the_others(tmp_path: Path) -> None:
    file = case(tmp_path, "nodes", "[parameters]\nrbf_nodes_posture = 3\n")
    done = dualarm("compare", "--no-package", "--controllers", "nabfc,pid", "--cases", file, "--json", "--out", str(tmp_path / "results"))
    assert (done.returncode, "warning: pid in the case nodes" in done.stderr) == (0, True), done.stderr


def test_a_case_in_which_every_run_fails_ends_the_command_with_1_after_the_rest_is_written(tmp_path: Path) -> None:
    """That the largest mass must not be below the smallest, no description says: the FMU refuses it when it runs."""
    file = case(tmp_path, "masses", "[parameters]\nr_mass_min = 0.4\nr_mass_max = 0.3\n")
    out = tmp_path / "results"
    done = dualarm("compare", "--no-package", "--controllers", "nabfc-r", "--cases", f"light,{file}", "--json", "--out", str(out))
    assert (done.returncode, "every run failed of masses: see the warnings" in done.stderr) == (1, True), done.stderr
    cells = json.loads((out / "matrix.json").read_text(encoding="utf-8"))
    assert json.loads(done.stdout)["matrix"] == cells
    assert [cell["case"] for cell in cells if cell.get("failure") is None] == ["light"]


def test_of_two_values_for_one_variable_the_later_line_counts(tmp_path: Path) -> None:
    lines = ["M = 0.6\n", '"DualArmPlant.M" = 0.2\n']
    finals = {}
    for name, text in (("up", lines), ("down", lines[::-1]), ("light", lines[1:])):
        done = dualarm("simulate", case(tmp_path, name, "[parameters]\n" + "".join(text)), "--json")
        finals[name] = json.loads(done.stdout)["final"]
    assert finals["up"] == finals["light"] != finals["down"]
