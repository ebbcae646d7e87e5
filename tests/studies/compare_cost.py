"""What a user would do otherwise: the plant by scipy's `solve_ivp`, the loop through FMPy, the loop under Ecos.

    cargo run --release -- package && cargo build --release -p benchmarks --example step_cost
    pip install -r tests/requirements.txt scipy
    python tests/studies/compare_cost.py            # run by hand: nothing in the tests depends on wall times

Everything is measured in one run on the same FMUs (`dist/`, or the folder named as the first argument; the program
`step_cost` is the second), in turns, so that a busy machine disturbs all of them alike. Printed are microseconds per
communication step of 0.1 ms, the best of several repetitions, and ratios to ours.

Before anything is measured, the finite elements that stand for the user's own model are compared with our plant: a
comparison of costs means nothing between models that do not agree.
"""

from __future__ import annotations

import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from fmpy import extract, read_model_description
from fmpy.fmi2 import FMU2Slave
from scipy.integrate import solve_ivp

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))
STEP = 1e-4
PLANT, CONTROLLER = "DualArmPlant.fmu", "NabfcController.fmu"

# What acts in all runs of the plant alone: torques on the hubs, force on the object.
COMMANDS = {"tau1_cmd": 0.05, "tau2_cmd": 0.0, "u_cmd": 0.1}

# Rounds of the measurements that are taken in turns.
ROUNDS = 3

# How far the hub angles of the elements may be from ours, relative to the largest of each over 20 ms. Four cubic elements
# per arm put the first pair of bending modes 6e-4 too high (563.1 instead of 562.8 1/s), which have a tenth of the motion.
AGREEMENT = 2e-4


def best(task: Callable[[], None], repetitions: int = 5) -> float:
    """Seconds of the fastest repetition."""
    times = []
    for _ in range(repetitions):
        begin = time.perf_counter()
        task()
        times.append(time.perf_counter() - begin)
    return min(times)


def linear_plant(modes: int = 8) -> tuple[np.ndarray, np.ndarray, list[int]]:
    """A, B of the plant as one would write it in Python, and where the hub angles are among its states.

    Cubic finite elements in absolute coordinates with the paper's parameters and without its uncertainties. Four elements
    per arm give 2 + 1 + 2*7 = 17 degrees of freedom, 34 states: the size of our plant at order 8 (33).
    """
    ei, rho, length, hub, tip_mass, mass, elements = 0.115, 0.054, 0.2, 0.0073, 0.1, 0.3, modes // 2
    size = length / elements
    stiff = ei / size**3 * np.array(
        [[12, 6 * size, -12, 6 * size], [6 * size, 4 * size**2, -6 * size, 2 * size**2],
         [-12, -6 * size, 12, -6 * size], [6 * size, 2 * size**2, -6 * size, 4 * size**2]])
    inertia = rho * size / 420 * np.array(
        [[156, 22 * size, 54, -13 * size], [22 * size, 4 * size**2, 13 * size, -3 * size**2],
         [54, 13 * size, 156, -22 * size], [-13 * size, -3 * size**2, -22 * size, 4 * size**2]])
    # Per arm: displacement (0 at the hub), rotation at each node. Both tips share the object's displacement.
    per_arm = 2 * (elements + 1)
    total = 2 * per_arm
    k, m = np.zeros((total, total)), np.zeros((total, total))
    for arm in range(2):
        for element in range(elements):
            at = slice(arm * per_arm + 2 * element, arm * per_arm + 2 * element + 4)
            k[at, at] += stiff
            m[at, at] += inertia
        m[arm * per_arm + 1, arm * per_arm + 1] += hub
        m[arm * per_arm + per_arm - 2, arm * per_arm + per_arm - 2] += tip_mass
    reduce = np.delete(np.eye(total), [0, per_arm, total - 2], axis=1)
    first_tip = per_arm - 2
    reduce[total - 2] = reduce[first_tip]
    k, m = reduce.T @ k @ reduce, reduce.T @ m @ reduce
    object_dof = int(np.argmax(reduce[first_tip]))
    hubs = [int(np.argmax(reduce[1])), int(np.argmax(reduce[per_arm + 1]))]
    m[object_dof, object_dof] += mass
    n = len(m)
    inputs = np.zeros((n, 3))
    inputs[[*hubs, object_dof], [0, 1, 2]] = 1
    a = np.block([[np.zeros((n, n)), np.eye(n)], [-np.linalg.solve(m, k), np.zeros((n, n))]])
    return a, np.vstack([np.zeros((n, 3)), np.linalg.solve(m, inputs)]), hubs


def disagreement(folder: Path, steps: int = 200) -> float:
    """Largest difference of the elements' hub angles from those of our plant, relative to the largest angle of each hub.

    Both without uncertainties and with ideal actuators, from rest.
    """
    ours = Wired(folder / PLANT, list(COMMANDS), ["theta1", "theta2"],
                 {"root_uncertainty": 0.0, "tip_uncertainty": 0.0, "actuator_model": 1})
    angles = np.array([ours.step(i * STEP, list(COMMANDS.values())) for i in range(steps)])
    a, b, hubs = linear_plant()
    force = b @ np.array(list(COMMANDS.values()))
    times = STEP * np.arange(1, steps + 1)
    solution = solve_ivp(lambda t, x: a @ x + force, (0, times[-1]), np.zeros(len(a)), method="DOP853", rtol=1e-10,
                         atol=1e-13, t_eval=times)
    difference = np.abs(solution.y[hubs].T - angles).max(axis=0)
    return float((difference / np.abs(angles).max(axis=0)).max())


def by_solve_ivp(method: str, steps: int) -> float:
    """Seconds per communication step with held inputs, relative tolerance 1e-6."""
    a, b, _ = linear_plant()
    force = b @ np.array(list(COMMANDS.values()))

    def run() -> None:
        x = np.zeros(len(a))
        for i in range(steps):
            solution = solve_ivp(
                lambda t, x: a @ x + force, (i * STEP, (i + 1) * STEP), x, method=method, rtol=1e-6, atol=1e-9,
                **({} if method == "DOP853" else {"jac": a}))
            x = solution.y[:, -1]

    return best(run, 3) / steps


def by_one_solve_ivp(seconds: float) -> float:
    """The same over one long span, for a user who needs no controller in between."""
    a, b, _ = linear_plant()
    force = b @ np.array(list(COMMANDS.values()))
    task = lambda: solve_ivp(lambda t, x: a @ x + force, (0, seconds), np.zeros(len(a)), method="DOP853", rtol=1e-6,
                             atol=1e-9)
    return best(task, 2) / (seconds / STEP)


class Wired:
    """An FMU in FMPy with its wired variables; integers among the parameters are enumerations."""

    def __init__(self, path: Path, inputs: list[str], outputs: list[str],
                 parameters: dict[str, float | int] | None = None) -> None:
        description = read_model_description(str(path))
        references = {v.name: v.valueReference for v in description.modelVariables}
        self.inputs, self.outputs = [references[n] for n in inputs], [references[n] for n in outputs]
        self.slave = FMU2Slave(
            guid=description.guid, unzipDirectory=extract(str(path)),
            modelIdentifier=description.coSimulation.modelIdentifier, instanceName="compared")
        self.slave.instantiate()
        for name, value in (parameters or {}).items():
            set_value = self.slave.setInteger if isinstance(value, int) else self.slave.setReal
            set_value([references[name]], [value])
        self.slave.setupExperiment(startTime=0.0)
        self.slave.enterInitializationMode()
        self.slave.exitInitializationMode()

    def step(self, time: float, values: list[float]) -> list[float]:
        self.slave.setReal(self.inputs, values)
        self.slave.doStep(time, STEP)
        return self.slave.getReal(self.outputs)


def by_fmpy(folder: Path, steps: int) -> float:
    descriptions = [read_model_description(str(folder / file)) for file in (PLANT, CONTROLLER)]
    names = [[{v.name for v in d.modelVariables if v.causality == c} for c in ("input", "output")] for d in descriptions]
    measured, commands = sorted(names[1][0] & names[0][1]), sorted(names[0][0] & names[1][1])
    plant = Wired(folder / PLANT, commands, measured)
    controller = Wired(folder / CONTROLLER, measured, commands)
    clock = {"step": 0, "commands": [0.0] * len(commands)}

    def run() -> None:
        for _ in range(steps):
            now = clock["step"] * STEP
            signals = plant.step(now, clock["commands"])
            clock["commands"] = controller.step(now, signals)
            clock["step"] += 1

    return best(run) / steps


def by_ecos(folder: Path, steps: int) -> float | None:
    """Seconds per step of Ecos' own loop (`step(n)`), without start-up; None where there is no Ecos."""
    try:
        from tests.judges.ecos import load

        ecos = load()
    except (ImportError, OSError) as error:
        print(f"Ecos: not measured ({error})")
        return None
    ecos.EcosLib.set_log_level("off")
    files = [folder / PLANT, folder / CONTROLLER]
    descriptions = [read_model_description(str(file)) for file in files]
    sides = [[{v.name for v in d.modelVariables if v.causality == c and v.type == "Real"} for c in ("input", "output")]
             for d in descriptions]
    with ecos.EcosSimulationStructure() as structure:
        for name, file in zip(("plant", "controller"), files):
            structure.add_model(name, str(file.resolve()))
        for source, target, of, to in (("plant", "controller", 0, 1), ("controller", "plant", 1, 0)):
            for name in sides[of][1] & sides[to][0]:
                structure.make_real_connection(f"{source}::{name}", f"{target}::{name}")
        simulation = ecos.EcosSimulation(step_size=STEP, structure=structure)
        if not simulation.init():
            raise RuntimeError(ecos.EcosLib.get_last_error())
        return best(lambda: simulation.step(steps)) / steps


def ours(folder: Path, program: Path) -> dict[str, float]:
    """Seconds per step: the cases that `step_cost` measures."""
    table = subprocess.run([program, "time", folder], check=True, capture_output=True, text=True).stdout
    lines = [line.removeprefix("step, ").split() for line in table.splitlines() if line.startswith("step, ")]
    return {words[0]: float(words[1]) * 1e-9 for words in lines}


def main() -> None:
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else ROOT / "dist"
    program = Path(sys.argv[2]) if len(sys.argv) > 2 else ROOT / "target/release/examples/step_cost"
    if (found := disagreement(folder)) > AGREEMENT:
        raise SystemExit(f"the elements' hub angles differ from ours by {found:.1e} of the largest: nothing to compare")
    print(f"the elements' hub angles agree with ours to {found:.1e} of the largest, over 20 ms\n")
    rounds = []
    for _ in range(ROUNDS):
        own = ours(folder, program)
        rounds.append({
            "plant": own["plant"], "coupled": own["coupled"], "master": own["master"], "fmpy": by_fmpy(folder, 2000),
            "ecos": by_ecos(folder, 20000) or float("nan")})
    best_of = {name: min(found[name] for found in rounds) for name in rounds[0]}
    rows = [
        ("plant through the C interface (ours)", best_of["plant"], "plant"),
        ("plant, solve_ivp DOP853 per step", by_solve_ivp("DOP853", 50), "plant"),
        ("plant, solve_ivp Radau per step", by_solve_ivp("Radau", 50), "plant"),
        ("plant, solve_ivp DOP853 over 20 ms at once", by_one_solve_ivp(0.02), "plant"),
        ("loop, native master (ours)", best_of["master"], "master"),
        ("loop, the FMUs' calls alone", best_of["coupled"], "master"),
        ("loop through FMPy", best_of["fmpy"], "master"),
        ("loop under Ecos", best_of["ecos"], "master"),
    ]
    print(f"{'':<46}{'us per step':>12}{'ratio':>10}")
    for name, seconds, standard in rows:
        print(f"{name:<46}{seconds * 1e6:>12.3f}{seconds / best_of[standard]:>10.2f}")


if __name__ == "__main__":
    main()
