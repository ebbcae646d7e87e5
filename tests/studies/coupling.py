"""Plant and controller coupled with held or ramped signals, sequentially or in parallel: the algorithms under study.

At a communication point every signal has a value and, with `foh` (first-order hold), a slope:

* `jacobi`: all outputs are read, all inputs set, both step. The controller's outputs are read before it gets the latest
  measurements: with `zoh` (zero-order hold) they belong to those of a step ago, with `foh` to ones extrapolated from
  there.
* `gauss_seidel`: the plant steps first; the controller then gets the new measurements, with `foh` as a ramp that leads
  to them, and its commands belong to them.

Slopes of the measurements and of the commands come from fmi2GetRealOutputDerivatives and go to
fmi2SetRealInputDerivatives; commands have direct feedthrough, so theirs are read after the controller got its own.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from ..support.capabilities import input_slopes, output_slopes
from ..support.contract import COMMANDS, MEASURED
from ..support.harness import CoSimulation, Fmu, Result
from ..support.slave import Port

HOLDS = ("zoh", "foh")


class _Signals:
    """Signals from one instance to another: values and slopes, which both sides see in the same memory."""

    def __init__(self, source: Sequence[Port], target: Sequence[Port]) -> None:
        self._fetch, self._fetch_slopes = source
        self._hand_over, self._hand_over_slopes = target
        self._hand_over.values, self._hand_over_slopes.values = self._fetch.values, self._fetch_slopes.values
        self.values = np.frombuffer(self._fetch.values)
        self.slopes = np.frombuffer(self._fetch_slopes.values)
        self.fetch, self.hand_over = self._fetch.fetch, self._hand_over.write
        self.fetch_slopes, self.hand_over_slopes = self._fetch_slopes.fetch, self._hand_over_slopes.write


def simulate(
    plant: Fmu,
    controller: Fmu,
    *,
    hold: str,
    coupling: str,
    step: float,
    stop: float,
    grid: float,
    record: Sequence[str],
    settings: Mapping[str, float | str] | None = None,
) -> Result:
    """Runs from consistent initial signals; plant outputs are recorded at multiples of `grid`, itself one of `step`."""
    every, steps = round(grid / step), round(stop / step)
    if abs(every * step - grid) > 1e-9 * grid or abs(steps * step - stop) > 1e-9 * stop:
        raise ValueError(f"{grid} s and {stop} s must be multiples of {step} s")
    ramped, parallel = hold == "foh", coupling == "jacobi"
    with CoSimulation([plant, controller]) as grasp:
        grasp.set(**(settings or {}))
        grasp.initialize(stop + step)
        body, law = grasp.slaves
        y = _Signals(
            (body.reader(tuple(MEASURED)), output_slopes(body, tuple(MEASURED))),
            (law.writer(tuple(MEASURED)), input_slopes(law, tuple(MEASURED))),
        )
        u = _Signals(
            (law.reader(tuple(COMMANDS)), output_slopes(law, tuple(COMMANDS))),
            (body.writer(tuple(COMMANDS)), input_slopes(body, tuple(COMMANDS))),
        )
        recorder = body.reader(record)
        before = np.empty_like(y.values)
        times, rows = [], []
        y.fetch()
        y.hand_over()
        u.fetch()
        for i in range(steps + 1):
            # All signals at time t: y is the plant's, u the controller's (for Jacobi, its outputs before it got y).
            time = i * step
            if parallel:
                u.fetch()
                y.fetch()
                y.hand_over()
            u.hand_over()
            if i % every == 0:
                times.append(time)
                rows.append(recorder.read())
            if i == steps:
                break
            if ramped:
                y.fetch_slopes()
                y.hand_over_slopes()
                u.fetch_slopes()
                u.hand_over_slopes()
            if parallel:
                body.step(time, step, 1)
                law.step(time, step, 1)
                continue
            before[:] = y.values
            body.step(time, step, 1)
            y.fetch()
            if ramped:
                # The controller's inputs still stand at the beginning of the step.
                y.slopes[:] = (y.values - before) / step
                y.hand_over_slopes()
                law.step(time, step, 1)
                y.hand_over()
            else:
                y.hand_over()
                law.step(time, step, 1)
            u.fetch()
    values = np.array(rows)
    return Result(np.array(times), {name: values[:, i] for i, name in enumerate(record)})
