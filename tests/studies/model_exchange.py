"""What each interface costs: evaluations of right-hand sides and time, the numbers of docs/importing.md.

python -m tests.studies.model_exchange      three minutes
"""

from __future__ import annotations

import time
from typing import Any

import numpy as np
from fmpy import simulate_fmu

from ..support.exchange import Grasp, Model, integrate
from ..support.harness import CoSimulation, Fmu
from ..support.paths import fmu_path

CONTROLLERS = ("NabfcController", "PdsController", "PdController")
# The first 0.1 s, in which commands pass their limits and all modes ring; afterwards a solver's steps are longer.
STOP = 0.1
# Taken from 4 mm, and held, which PDS has done by then.
CONTACTS = {"soft": "compliant", "rigid": "unilateral"}
AWAY, TAKEN = {"theta1_0": -0.02, "theta2_0": 0.02}, 0.2


def cost_of_a_call(fmu: Fmu) -> dict[str, float]:
    """Microseconds that a solver's evaluation takes, and a column of the Jacobian, through ctypes; and an empty call."""
    with Model(fmu) as model:
        model.start()
        x = model.x

        def best(call: Any, count: int = 2000) -> float:
            laps = []
            for _ in range(7):
                begin = time.process_time()
                for _ in range(count):
                    call()
                laps.append((time.process_time() - begin) / count * 1e6)
            return min(laps)

        def evaluate() -> None:
            model.set_time(0.0)
            model.x = x
            model.rates()

        column = [model.states[0]]
        empty = best(lambda: model.set_time(0.0))
        return {
            "states": model.size,
            "evaluation": best(evaluate) - 2 * empty,
            "column": best(lambda: model.jacobian(model.derivatives, column), 500),
            "call": empty,
        }


class Counted(Grasp):
    """Counts its Jacobians."""

    jacobians = 0

    def jacobian(self, t: float, z: np.ndarray) -> np.ndarray:
        """The exact derivative, counted."""
        self.jacobians += 1
        return super().jacobian(t, z)


def wired(
    plant: Fmu, law: Fmu, method: type, tolerance: float, stop: float = STOP, settings: dict[str, Any] | None = None
) -> str:
    """A row: both under one solver of SciPy, with the FMUs' Jacobian if it wants one."""
    with Model(plant) as arms, Model(law) as controller:
        arms.set(**(settings or {}))
        grasp = Counted(arms, controller)
        z = grasp.start()
        nominal = np.concatenate([arms.nominals, controller.nominals])
        options: dict[str, Any] = {"method": method, "rtol": tolerance, "atol": tolerance * nominal}
        if method.__name__ != "DOP853":
            options["jac"] = grasp.jacobian
        begin = time.process_time()
        events = integrate(grasp.rates, z, stop, [], grasp.indicators, grasp.event, **options)
        spent = time.process_time() - begin
    return row(f"{method.__name__}, {tolerance:g}", arms.evaluations, grasp.jacobians, len(events), spent)


def row(*cells: Any) -> str:
    """A line of a table in Markdown."""
    return f"| {' | '.join(f'{cell:.2f}' if isinstance(cell, float) else str(cell) for cell in cells)} |"


def main() -> None:
    """Prints the tables."""
    from scipy.integrate import DOP853, Radau

    fmus = {name: Fmu(fmu_path(name)) for name in ("DualArmPlant", *CONTROLLERS)}
    for name, fmu in fmus.items():
        print(row(name, *cost_of_a_call(fmu).values()), flush=True)
    begin = time.process_time()
    start = {"tau1_cmd": 0.05, "tau2_cmd": -0.05}
    simulate_fmu(
        str(fmu_path("DualArmPlant")), fmi_type="ModelExchange", solver="CVode", stop_time=2.0, start_values=start
    )
    print("FMPy with CVode, 1e-5, the plant alone for 2 s:", round(time.process_time() - begin, 2), "s")
    for name in CONTROLLERS:
        print(name)
        with CoSimulation([fmus["DualArmPlant"], fmus[name]], "gauss_seidel") as grasp:
            begin = time.process_time()
            grasp.run(STOP, 1e-4, ("theta1",), 1)
            print(row("co-simulation, 0.1 ms", round(STOP / 1e-4), "", "", time.process_time() - begin))
        ways = [(Radau, 1e-4), (Radau, 1e-6)]
        # An explicit solver, once: what it takes is minutes.
        ways += [(DOP853, 1e-6)] if name == "PdsController" else []
        for method, tolerance in ways:
            print(wired(fmus["DualArmPlant"], fmus[name], method, tolerance), flush=True)
    for name, model in CONTACTS.items():
        print(f"PDS takes the object from 4 mm, {name} faces, {TAKEN} s")
        settings = {"contact_model": model, **AWAY}
        for tolerance in (1e-4, 1e-6):
            print(wired(fmus["DualArmPlant"], fmus["PdsController"], Radau, tolerance, TAKEN, settings), flush=True)


if __name__ == "__main__":
    main()
