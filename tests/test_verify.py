"""What `dualarm verify` rests on: laws derived again, monolithic solutions, the documentation that quotes it."""

from __future__ import annotations

import json
import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from .oracle import laws, monolith
from .support.contract import CONTROLLERS, MEASURED, PAPER
from .support.harness import CoSimulation, Fmu
from .support.paths import ROOT

ESTIMATES = ("m_hat", "epsilon_hat", "J1_hat", "J2_hat", "pi1_hat", "pi2_hat", "W_norm", "U1_norm", "U2_norm")
COMMANDS = ("tau1_cmd", "tau2_cmd", "u_cmd")
STEP = 1e-4


def start_values(fmu: Fmu, **changed: float) -> dict[str, float]:
    """All numeric parameters of an FMU as its description states them."""
    values = {
        v.name: float(v.start)
        for v in fmu.variables.values()
        if v.causality in ("parameter", "input") and v.type in ("Real", "Integer")
    }
    return {**values, **changed}


def law_of(fmu: Fmu, values: dict[str, float]) -> Any:
    kind = laws.Nabfc if fmu.name == "NabfcController" else laws.Linear
    return kind(values, values["lambda1_ref"], values["theta1_ref"])


@pytest.mark.parametrize("controller", CONTROLLERS)
@pytest.mark.parametrize("preset", ["default", "unequal"])
def test_recorded_trajectories_obey_the_laws(controller: str, preset: str, fmus: dict[str, Fmu]) -> None:
    """Commands and estimates of a co-simulation, replayed with the laws re-derived in `oracle/laws.py`: round-off.

    A controller that runs after its plant gets the new measurements, holds them over its step and solves its update
    laws exactly: with the low-pass off, that is d(state)/dt = drive - leakage * state with constant coefficients.
    """
    changed = {"shear_rate_bandwidth": 0.0} if controller == "NabfcController" else {}
    settings = {} if preset == "default" else {"EI2": 0.2, "J2": 0.004, "theta1_ref": 0.08, "lambda1_ref": -0.3}
    extra = ESTIMATES if changed else ()
    with CoSimulation([fmus["DualArmPlant"], fmus[controller]]) as grasp:
        grasp.set(**changed, **settings, **(PAPER if changed else {}))
        result = grasp.run(0.15, STEP, (*MEASURED, *COMMANDS, *extra))
    own = {k: v for k, v in settings.items() if k in fmus[controller].variables}
    law = law_of(fmus[controller], start_values(fmus[controller], **changed, **own))
    measured = np.array([result[name] for name in laws.MEASURED]).T
    state = law.start(measured[0])
    for i in range(len(measured)):
        if i and changed:
            _, drive, leak = law.parts(measured[i], state)
            state = laws.held(state, drive, leak, STEP)
        command, _ = law(measured[i], state)
        # Terms of up to 3 N.m and 10 N cancel; a thousand steps of estimates: 1e-12 of them.
        assert [result[name][i] for name in COMMANDS] == pytest.approx(list(command), abs=5e-12), i
        if changed:
            expected = law.norms(state)
            assert [result[n][i] for n in extra] == pytest.approx([expected[n] for n in extra], rel=1e-11, abs=1e-15)


def test_update_step_with_the_low_pass_solves_the_laws(fmus: dict[str, Fmu]) -> None:
    """The default controller: filtered rates move within a step. Against Runge-Kutta with steps of h/4.

    The FMU's two-point rule leaves (omega h)^4 / 4320 = 2e-10 of a step's share, RK4 (omega h / 4)^5 / 120 = 2e-13.
    """
    fmu = fmus["NabfcController"]
    with CoSimulation([fmus["DualArmPlant"], fmu]) as grasp:
        grasp.set(**PAPER)
        result = grasp.run(0.05, STEP, (*MEASURED, *COMMANDS, *ESTIMATES))
    law = law_of(fmu, start_values(fmu))
    measured = np.array([result[name] for name in laws.MEASURED]).T
    state, h = law.start(measured[0]), STEP / 4
    for i in range(1, len(measured)):
        for _ in range(4):
            slopes = [law(measured[i], state)[1]]
            for fraction in (0.5, 0.5, 1.0):
                slopes.append(law(measured[i], state + fraction * h * slopes[-1])[1])
            state = state + h / 6 * (slopes[0] + 2 * slopes[1] + 2 * slopes[2] + slopes[3])
        command, _ = law(measured[i], state)
        assert [result[name][i] for name in COMMANDS] == pytest.approx(list(command), abs=1e-9), i
        expected = law.norms(state)
        assert [result[n][i] for n in ESTIMATES] == pytest.approx([expected[n] for n in ESTIMATES], rel=1e-7, abs=1e-12)


@pytest.fixture(scope="module")
def solutions() -> dict[str, Any]:
    """The monolithic solutions, as compiled into the tool."""
    return json.loads(monolith.FILE.read_text(encoding="utf-8"))


def test_monolithic_plant_has_the_exact_eigenvalues(oracle: dict[str, Any]) -> None:
    """Own bases, own matrices: at order 12 five pairs to 1e-9, as the FMU; with the uncertainties too."""
    plant = monolith.defaults("DualArmPlant")
    conservative = {**plant, "root_uncertainty": 0.0, "tip_uncertainty": 0.0}
    for parameters, loop in ((conservative, "paper_free"), (plant, "paper_no_control")):
        found = np.linalg.eigvals(monolith.matrices(parameters, 12).A)
        for real, imaginary in oracle["eigenvalues"][loop]["values"]:
            exact = complex(real, imaginary)
            if abs(exact) < 1000:
                assert np.min(np.abs(found - exact)) < 1e-8 * abs(exact)


def test_solutions_belong_to_the_present_fmus(fmus: dict[str, Fmu], solutions: dict[str, Any]) -> None:
    """When defaults change, `python -m tests.oracle.monolith` must be run again."""
    for name, gains in solutions["gains"].items():
        # The root-strain law is not solved there; its gains may change.
        present = {key: value for key, value in start_values(fmus[name]).items() if not key.startswith("r_")}
        assert gains == present, f"{name}: run `python -m tests.oracle.monolith`"
    assert set(solutions["cases"]) == set(monolith.CASES)
    for name, case in monolith.CASES.items():
        kept = solutions["cases"][name]
        assert (kept["controller"], kept["order"], kept["settings"]) == (case.controller, case.order, case.settings)
        assert kept["at"][-1]["t"] == case.stop
        assert kept["saturates"] == name.endswith("_saturated")


@dataclass(frozen=True)
class Row:
    """A row of the tables of `dualarm verify`."""

    check: str
    exact: str
    gave: str
    bound: str
    passed: str

    @property
    def name(self) -> str:
        """What follows a colon or semicolon says which output was worst: rounding decides."""
        return re.split("[:;]", self.check)[0]

    @property
    def is_the_worst_of_several(self) -> bool:
        """Whether another of several may be the worst on another machine."""
        return "worst of" in self.check


def rows_of(markdown: str) -> list[Row]:
    """The rows of all tables."""
    cells = [line.strip("| \n").split(" | ") for line in markdown.splitlines() if line.startswith("| ")]
    return [
        Row(row[0], row[1], row[2], row[4], row[5])
        for row in cells
        if len(row) == 6 and row[0] != "what was checked"
    ]


def numbers(text: str) -> np.ndarray:
    return np.array([float(number) for number in re.findall(r"[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?", text)])


def test_documentation_quotes_the_table(verification: Path) -> None:
    """docs/verification.md holds what the tool prints: the same rows, exact values and verdicts, and what the FMUs gave.

    Digits beyond a row's bound are rounding, and so is which of several outputs is the worst.
    """
    quoted = rows_of((ROOT / "docs" / "verification.md").read_text(encoding="utf-8"))
    assert len(quoted) > 60
    made = rows_of((verification / "verification.md").read_text(encoding="utf-8"))
    assert [row.name for row in made] == [row.name for row in quoted]
    for ours, theirs in zip(quoted, made):
        assert (ours.passed, theirs.passed) == ("yes", "yes")
        if ours.is_the_worst_of_several or theirs.is_the_worst_of_several:
            continue
        assert ours.exact == theirs.exact
        assert ours.bound == theirs.bound
        (bound,) = numbers(ours.bound)
        assert numbers(ours.gave) == pytest.approx(numbers(theirs.gave), rel=bound, abs=bound), ours.check
    assert (verification / "figures" / "convergence.svg").is_file()
