"""Error of the co-simulation against the step size, for held and ramped signals, in parallel and in sequence.

    python -m tests.studies.cosimulation_error [--fmus dist] [-o docs/figures/cosimulation-error.svg]

Draws a figure (with matplotlib, which the tests do not need) and prints a table. The reference is the limit of small
steps of the same FMUs, which is the monolithic closed loop since the plant's step is exact for ramped inputs: ramps in
sequence converge with the second order, so two runs extrapolate to it. `tests/test_cosimulation_error.py` checks the
orders and, independently, the limit against the exact solution of the closed loop.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ..support.harness import CoSimulation, Fmu, FmuError, Result
from .coupling import HOLDS, simulate

SIGNALS = ("theta1", "theta2", "y_object", "contact_force1", "contact_force2")
METHODS = [(hold, coupling) for hold in HOLDS for coupling in CoSimulation.COUPLINGS]
GRID = 1e-3

# An error above this share of a signal's range is no inaccuracy but an unstable loop, or a limit cycle.
UNSTABLE = 0.05


@dataclass(frozen=True)
class Loop:
    """A controller with a target."""

    controller: str
    settings: Mapping[str, float | str]
    title: str


# A hundredth of the paper's target for the linear laws, so that no actuator saturates: the error of a linear loop does
# not depend on its size. The neuro-adaptive law gets the paper's target, at which nothing saturates either.
_SMALL = {"lambda1_ref": -0.005, "theta1_ref": math.radians(0.03)}
LOOPS = {
    "PD": Loop("PdController", _SMALL, "PD (97)(98)"),
    "PDS": Loop("PdsController", _SMALL, "PDS (95)(96)"),
    "NABFC": Loop("NabfcController", {"law": "paper"}, "NABFC, the paper's law"),
}


def run(plant: Fmu, controller: Fmu, loop: Loop, method: tuple[str, str], step: float, stop: float) -> Result:
    """One co-simulation."""
    hold, coupling = method
    return simulate(
        plant,
        controller,
        hold=hold,
        coupling=coupling,
        step=step,
        stop=stop,
        grid=GRID,
        record=SIGNALS,
        settings=loop.settings,
    )


def reference(plant: Fmu, controller: Fmu, loop: Loop, stop: float, step: float = 1e-5) -> Result:
    """The limit of small steps, extrapolated from `step` and half of it."""
    coarse, fine = (run(plant, controller, loop, ("foh", "gauss_seidel"), h, stop) for h in (step, step / 2))
    return Result(fine.time, {name: (4 * fine[name] - coarse[name]) / 3 for name in SIGNALS})


def error(result: Result, exact: Result, signals: Sequence[str] = SIGNALS) -> float:
    """Root mean square over time and signals, each in units of the range it moves through."""
    squares = [np.mean((result[name] - exact[name]) ** 2) / np.ptp(exact[name]) ** 2 for name in signals]
    return float(np.sqrt(np.mean(squares)))


def errors(
    plant: Fmu, controller: Fmu, loop: Loop, exact: Result, steps: Sequence[float], signals: Sequence[str] = SIGNALS
) -> dict[tuple[str, str], list[float]]:
    """For each method, the error at each step size; NaN where the co-simulation blows up."""
    stop = float(exact.time[-1])

    def at(method: tuple[str, str], step: float) -> float:
        try:
            return error(run(plant, controller, loop, method, step, stop), exact, signals)
        except FmuError:
            return math.nan

    return {method: [at(method, step) for step in steps] for method in METHODS}


def draw(table: Mapping[str, Mapping[tuple[str, str], Sequence[float]]], steps: Sequence[float], output: Path) -> None:
    """A panel for each loop."""
    import matplotlib as mpl

    mpl.use("svg")
    mpl.rcParams |= {"svg.hashsalt": "cosimulation-error", "svg.fonttype": "none", "font.size": 9}
    from matplotlib import pyplot as plt

    names = {
        ("zoh", "jacobi"): ("held, Jacobi", "C3", "o--"),
        ("zoh", "gauss_seidel"): ("held, Gauss-Seidel", "C3", "o-"),
        ("foh", "jacobi"): ("ramped, Jacobi", "C0", "s--"),
        ("foh", "gauss_seidel"): ("ramped, Gauss-Seidel", "C0", "s-"),
    }
    figure, axes = plt.subplots(1, len(table), figsize=(10, 3.8), sharex=True, sharey=True, layout="constrained")
    milliseconds = 1e3 * np.array(steps)
    for axis, (key, curves) in zip(axes, table.items()):
        for method, (label, color, style) in names.items():
            values = np.array(curves[method])
            shown = values < UNSTABLE
            axis.loglog(
                milliseconds[shown], values[shown], style, color=color, label=label, markersize=4, linewidth=1.2
            )
        for label, order, start, end in (("h", 1, 4e-3, 0.2), ("h²", 2, 1e-7, 0.2)):
            guide = np.array([milliseconds[-1], end])
            line = start * (guide / guide[0]) ** order
            axis.loglog(guide, line, ":", color="0.5", linewidth=1)
            axis.annotate(label, (guide[1], line[1]), color="0.4")
        axis.set_title(LOOPS[key].title)
        axis.set_xlabel("communication step h (ms)")
        axis.set_xticks([0.01, 0.1, 1.0], ["0.01", "0.1", "1"])
        axis.minorticks_off()
        axis.grid(linewidth=0.3)
    axes[0].set_ylabel("error / range of the signal")
    axes[-1].legend(frameon=False, fontsize=8, loc="lower right")
    figure.savefig(output, metadata={"Date": None})


def main() -> None:
    """Runs the study."""
    root = Path(__file__).resolve().parents[2]
    parser = argparse.ArgumentParser(prog="python -m tests.studies.cosimulation_error", description=__doc__)
    parser.add_argument("--fmus", type=Path, default=root / "dist", help="folder of the packaged FMUs")
    parser.add_argument("-o", "--output", type=Path, default=root / "docs" / "figures" / "cosimulation-error.svg")
    options = parser.parse_args()
    steps = (1e-3, 5e-4, 2.5e-4, 2e-4, 1e-4, 5e-5, 2.5e-5, 1.25e-5)
    stop = 0.2
    plant = Fmu(options.fmus / "DualArmPlant.fmu")
    table = {}
    for key, loop in LOOPS.items():
        controller = Fmu(options.fmus / f"{loop.controller}.fmu")
        exact = reference(plant, controller, loop, stop, step=5e-6)
        table[key] = errors(plant, controller, loop, exact, steps)
        controller.close()
        print(
            f"\n{loop.title}, 0 to {stop} s: error / range\n{'h (ms)':>24}" + "".join(f"{1e3 * h:>10g}" for h in steps)
        )
        for (hold, coupling), values in table[key].items():
            print(f"{hold} {coupling:<20}" + "".join(f"{value:>10.1e}" for value in values))
    plant.close()
    options.output.parent.mkdir(parents=True, exist_ok=True)
    draw(table, steps, options.output)


if __name__ == "__main__":
    main()
