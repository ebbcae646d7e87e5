"""What each interface costs: evaluations of right-hand sides and time for two seconds of the grasp; numbers of docs/importing.md.

    python -m tests.studies.model_exchange
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
STOP = 2.0


def cost_of_a_call(fmu: Fmu) -> dict[str, float]:
    """Microseconds of what a solver does for one evaluation, and for a column of the Jacobian, in the C interface with ctypes."""
    with Model(fmu) as model:
        model.start()
        x = model.x

        def best(call: Any, count: int = 2000) -> float:
            laps = []
            for _ in range(7):
                begin = time.perf_counter()
                for _ in range(count):
                    call()
                laps.append((time.perf_counter() - begin) / count * 1e6)
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


def wired(plant: Fmu, law: Fmu, method: type, tolerance: float, with_jacobian: bool) -> dict[str, float]:
    """Both under one solver of SciPy."""
    with Model(plant) as arms, Model(law) as controller:
        grasp = Grasp(arms, controller)
        z = grasp.start()
        nominal = np.concatenate([arms.nominals, controller.nominals])
        options: dict[str, Any] = {"method": method, "rtol": tolerance, "atol": tolerance * nominal}
        if with_jacobian:
            options["jac"] = grasp.jacobian
        begin = time.perf_counter()
        events = integrate(grasp.rates, z, STOP, [], grasp.indicators, grasp.event, **options)
        return {"evaluations": arms.evaluations, "events": len(events), "seconds": time.perf_counter() - begin}


def main() -> None:
    """Prints the tables."""
    from scipy.integrate import BDF, Radau

    fmus = {name: Fmu(fmu_path(name)) for name in ("DualArmPlant", *CONTROLLERS)}
    for name, fmu in fmus.items():
        print(name, {key: round(value, 2) for key, value in cost_of_a_call(fmu).items()})
    begin = time.perf_counter()
    simulate_fmu(str(fmu_path("DualArmPlant")), fmi_type="ModelExchange", solver="CVode", stop_time=STOP, start_values={"theta1_0": 0.01})
    print("FMPy, CVode, plant alone:", round(time.perf_counter() - begin, 2), "s")
    for name in CONTROLLERS:
        with CoSimulation([fmus["DualArmPlant"], fmus[name]], "gauss_seidel") as grasp:
            begin = time.perf_counter()
            grasp.run(STOP, 1e-4, ("theta1",), 100)
            print(name, "co-simulation at 0.1 ms:", round(time.perf_counter() - begin, 3), "s")
        for method in (BDF, Radau):
            found = wired(fmus["DualArmPlant"], fmus[name], method, 1e-6, True)
            print(name, method.__name__, {key: round(value, 2) for key, value in found.items()}, flush=True)


if __name__ == "__main__":
    main()
