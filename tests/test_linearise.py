"""`dualarm certify` and `dualarm linearise`: what a reader of their results finds, also in others' tools."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from .support.paths import ROOT
from .support.tool import dualarm as run

scipy_io = pytest.importorskip("scipy.io")


def system(folder: Path, ending: str, *arguments: str) -> dict[str, np.ndarray]:
    out = folder / f"grasp.{ending}"
    done = run("linearise", "--out", str(out), *arguments)
    assert done.returncode == 0, done.stderr
    if ending == "mat":
        return {k: v for k, v in scipy_io.loadmat(out, squeeze_me=True).items() if not k.startswith("__")}
    if ending == "npz":
        return dict(np.load(out))
    return {k: np.array(v) for k, v in json.loads(out.read_text()).items()}


def test_formats_agree(tmp_path: Path) -> None:
    systems = [system(tmp_path, ending, "--step", "1e-3") for ending in ("mat", "npz", "json")]
    assert set(systems[0]) == set(systems[1]) == set(systems[2])
    for key, value in systems[0].items():
        for other in systems[1:]:
            assert np.array_equal(value, np.squeeze(other[key])), key


def test_eigenvalues_are_the_grasps(tmp_path: Path) -> None:
    """Exact eigenvalues of the plant with its uncertainties (design table); Ad = exp(A h)."""
    s = system(tmp_path, "npz", "--step", "1e-3", "--order", "12")
    found = np.linalg.eigvals(s["A"])
    for exact in (-11.81991065431 + 9.84657508534j, -17.33272611647, -15.76187235017 + 562.026862052j):
        assert np.min(np.abs(found - exact)) < 1e-6 * abs(exact)
    from scipy.linalg import expm

    assert np.allclose(s["Ad"], expm(s["A"] * 1e-3), atol=1e-10 * np.linalg.norm(s["Ad"]))
    assert list(s["outputs"][:2]) == ["theta1", "theta2"]
    assert s["C"].shape[0] == len(s["outputs"]) == len(s["output_units"])


def test_python_control(tmp_path: Path) -> None:
    control = pytest.importorskip("control")
    s = system(tmp_path, "mat")
    assert control.ss(s["A"], s["B"], s["C"], s["D"]).nstates == len(s["states"])


@pytest.mark.skipif(
    shutil.which("octave-cli") is None,
    reason="Octave is not installed: put octave-cli on PATH (package octave-control for ss) to load grasp.mat and law.mat in it",
)
def test_octave(tmp_path: Path) -> None:
    s = system(tmp_path, "mat")
    script = f"load('{tmp_path / 'grasp.mat'}'); printf('%d %s', rows(A), outputs{{1}})"
    done = subprocess.run(["octave-cli", "--eval", script], capture_output=True, text=True, timeout=120)
    assert done.stdout == f"{len(s['A'])} theta1"


CONTROLLERS = ("pd", "pid", "pds", "nabfc-r", "nabfc-r-certified")


def law(folder: Path, ending: str, controller: str, *arguments: str) -> dict[str, np.ndarray]:
    out = folder / f"law.{ending}"
    done = run("linearise", "--controller", controller, "--out", str(out), *arguments)
    assert done.returncode == 0, done.stderr
    if ending == "mat":
        return {k: v for k, v in scipy_io.loadmat(out).items() if not k.startswith("__")}
    if ending == "npz":
        return dict(np.load(out))
    return {k: np.array(v) for k, v in json.loads(out.read_text()).items()}


def test_laws_agree_in_all_formats(tmp_path: Path) -> None:
    laws = [law(tmp_path, ending, "pid", "--step", "1e-3") for ending in ("mat", "npz", "json")]
    for key in ("Ad", "Bd", "C", "D"):
        for other in laws[1:]:
            assert np.array_equal(laws[0][key], other[key]), key
    # An integral adds its gain times the error times the step, to rounding of differences.
    assert laws[1]["states"].shape == (3,)
    assert laws[1]["Ad"] == pytest.approx(np.eye(3), abs=1e-8)
    assert np.max(np.abs(laws[1]["Bd"])) == pytest.approx(14_980 * 1e-3, rel=1e-6)


def sampled_radius(plant: dict[str, np.ndarray], law_: dict[str, np.ndarray], late: bool) -> float:
    """The coupled step, put together here: the law gets the signals of the instant, the plant its commands."""
    A, B, C = plant["Ad"], plant["Bd"], plant["C"]
    a, b, c, d = (np.atleast_2d(law_[key]) for key in ("Ad", "Bd", "C", "D"))
    b, d = b[:, :14], d[:, :14]
    n, k = len(A), a.shape[0] if a.size else 0
    if k == 0:
        a, b, c = np.zeros((0, 0)), np.zeros((0, 14)), np.zeros((3, 0))
    command = np.hstack([d @ C, c])
    held = np.zeros((3, 0)) if not late else np.eye(3)
    acting = np.hstack([command if not late else np.zeros((3, n + k)), held])
    plant_row = np.hstack([A, np.zeros((n, k + held.shape[1]))]) + B @ acting
    law_row = b @ C @ plant_row
    law_row[:, n : n + k] += a
    rows = [plant_row, law_row] + ([np.hstack([command, np.zeros((3, 3))])] if late else [])
    return float(np.max(np.abs(np.linalg.eigvals(np.vstack(rows)))))


@pytest.mark.parametrize("late", [False, True])
@pytest.mark.parametrize("controller", ["pd", "pds"])
def test_longest_steps_from_the_exported_matrices(controller: str, late: bool, tmp_path: Path) -> None:
    """numpy, with what `linearise` wrote, finds the step that `certify --map steps` names."""
    said = json.loads(run("certify", "--map", "steps", "--controller", controller, "--json").stdout)
    limit = said["rows"][0]["first_unstable"][int(late)]
    for factor, stable in ((0.995, True), (1.005, False)):
        step = f"{factor * limit:.9e}"
        radius = sampled_radius(system(tmp_path, "npz", "--step", step), law(tmp_path, "npz", controller, "--step", step), late)
        assert (radius < 1) == stable, (factor, radius)


def test_readme_has_the_longest_steps_of_the_map() -> None:
    """The table of README is the map's, cut to the digits that it has."""
    from .test_steps import limits

    said = json.loads(run("certify", "--map", "steps", "--controller", "pd", "--controller", "pds", "--json").stdout)
    for row in said["rows"]:
        for index, coupling in enumerate(("gauss_seidel", "jacobi")):
            written = limits()[f"{row['controller'].capitalize()}Controller", coupling]
            assert 0.97 * row["first_unstable"][index] < written <= 1.003 * row["first_unstable"][index]


@pytest.mark.parametrize("controller", CONTROLLERS)
def test_python_control_takes_laws(controller: str, tmp_path: Path) -> None:
    control = pytest.importorskip("control")
    s = law(tmp_path, "mat", controller, "--step", "1e-3")
    states = s["Ad"].shape[0] if s["Ad"].size else 0
    if states == 0:
        gain = control.ss([], [], [], s["D"], float(s["h"].item()))
        assert gain.noutputs == 3
        return
    system_ = control.ss(s["Ad"], s["Bd"], s["C"], s["D"], float(s["h"].item()))
    assert (system_.nstates, system_.ninputs, system_.noutputs) == (states, 16, 3)


def test_laws_are_those_of_the_fmus(tmp_path: Path) -> None:
    """The default law of NabfcController is the one that `linearise` takes for it."""
    text = (ROOT / "modelDescription" / "NabfcController.xml").read_text(encoding="utf-8")
    start = re.search(r'name="law".*?<Enumeration[^>]*start="(\d)"', text, re.DOTALL)
    assert start is not None
    assert start[1] == "2"  # root_strain, whose name for the tool is nabfc-r
    paper, default = (" ".join(law(tmp_path, "json", name)["states"]) for name in ("nabfc", "nabfc-r"))
    assert "estimator" in paper and "estimator" not in default
    wrong = run("linearise", "--controller", "pd", "--at", "nonsense=1")
    assert wrong.returncode == 2
    assert "theta1" in wrong.stderr


def monitored(folder: Path, *arguments: str) -> tuple[dict[str, np.ndarray], str]:
    out = folder / "run.csv"
    done = run("simulate", *arguments, "--monitor", "lyapunov", "-o", str(out))
    assert done.returncode == 0, done.stderr
    assert (folder / "run.lyapunov.svg").read_text(encoding="utf-8").startswith("<svg")
    table = np.genfromtxt(out, delimiter=",", names=True, deletechars="")
    return {name: table[name] for name in table.dtype.names}, done.stdout


def test_the_certified_bound_holds_along_a_run(tmp_path: Path) -> None:
    run_, said = monitored(tmp_path, "nabfc-r-certified", "--stop", "0.5")
    H, bound = run_["lyapunov_H"], run_["lyapunov_bound"]
    assert np.all(H > 0)
    assert np.all(H <= bound * (1 + 1e-6))
    parts = sum(run_[f"lyapunov_{part}"] for part in ("E", "C", "V_o", "V_I1", "V_I2"))
    assert parts == pytest.approx(H, rel=1e-12)
    assert "bound holds" in said


def test_the_papers_bound_claims_nothing_for_the_papers_speed(tmp_path: Path) -> None:
    run_, said = monitored(tmp_path, "nabfc", "--stop", "0.3", "--set", "law=paper")
    assert np.all(np.isinf(run_["lyapunov_bound"]))
    assert "claims nothing" in said


def test_the_certified_preset_beside_others(tmp_path: Path) -> None:
    """Column by column, the table of certificates.md is what the matrix finds."""
    page = (ROOT / "docs" / "certificates.md").read_text(encoding="utf-8")
    rows = re.findall(r"^\| (.+?) \| (.+?) \| (.+?) \| (.+?) \|$", page.split("<!-- certified")[1].split("<!-- end")[0], re.M)
    controllers = "--controllers=nabfc-r-certified,nabfc-r,pds-tuned"
    done = run("compare", "--matrix", "--no-package", controllers, "-o", str(tmp_path))
    assert done.returncode == 0, done.stderr
    # A table too wide for a terminal goes on below, with its first column again.
    found: dict[str, list[str]] = {}
    for line in done.stdout.splitlines():
        case, *cells = re.split(r"  +", line.strip())
        found.setdefault(case, []).extend(cells)
    cells = [(case, *cells) for case, *cells in rows if case not in ("case", ":--")]
    assert len(cells) > 5
    for case, *written in cells:
        assert written == [re.sub(r"never .*", "never", cell) for cell in found[case][:3]], case


def test_a_monitor_without_its_grasp_says_what_it_lacks(tmp_path: Path) -> None:
    done = run("simulate", "pd", "--monitor", "lyapunov", "-o", str(tmp_path / "x.csv"))
    assert done.returncode == 2
    assert "NabfcController" in done.stderr


def test_certify() -> None:
    certified = json.loads(run("certify", "--json").stdout)
    assert certified["certificate"]["phi"] > 7.5  # 7.84: what these gains have
    # A proof can't promise more than the exact spectrum: W decays like the square of the slowest mode.
    assert certified["certificate"]["phi"] <= -2 * certified["abscissa"]
    refused = json.loads(run("certify", "--mode", "printed", "--json").stdout)
    assert refused["verdict"] == "infeasible"
    assert refused["conflicts"]
    gains = {"mu_bar": 0.015, "c1": 0.015, "k": 1e5, "b1": 1, "gamma1": 1, "a1": 1}
    for i in (1, 2):
        gains |= {f"mu{i}": 0.04, f"c3{i}": 0.04, f"k{i}": 1e5, f"g1{i}": 1, f"zeta1{i}": 1, f"a3{i}": 1}
    feasible = json.loads(
        run("certify", "--mode=printed", "--json", *(f"--set={k}={v}" for k, v in gains.items())).stdout
    )
    assert feasible["verdict"] == "feasible"
    assert feasible["bounds"]["position"] >= feasible["bounds"]["least_position"] > 1000 * feasible["start_position"]
    corrected = json.loads(run("certify", "--mode", "corrected", "--json").stdout)
    assert corrected["form"]["value"] > 0
    assert corrected["undamped"][0] == pytest.approx(562.504349, rel=1e-8)
    wrong = run("certify", "--set", "nonsense=1")
    assert wrong.returncode == 2
    assert "nonsense" in wrong.stderr
