"""`dualarm certify` and `dualarm linearise`: what a reader of their results finds, also in others' tools."""

from __future__ import annotations

import json
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

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


@pytest.mark.skipif(shutil.which("octave-cli") is None, reason="Octave is not here")
def test_octave(tmp_path: Path) -> None:
    s = system(tmp_path, "mat")
    script = f"load('{tmp_path / 'grasp.mat'}'); printf('%d %s', rows(A), outputs{{1}})"
    done = subprocess.run(["octave-cli", "--eval", script], capture_output=True, text=True, timeout=120)
    assert done.stdout == f"{len(s['A'])} theta1"


def test_certify() -> None:
    certified = json.loads(run("certify", "--json").stdout)
    assert certified["certificate"]["phi"] > 8.0
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
