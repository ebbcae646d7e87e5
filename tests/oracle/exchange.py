"""The monolithic loops again, at the order and with the events that model exchange has: what the FMUs are compared with.

Every time a command passes a limit of its actuator the integration stops there and begins anew, so no step has a kink inside.

    python -m tests.oracle.exchange      writes tests/oracle/model_exchange.json (needs SciPy; some minutes)
"""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from .monolith import CASES, OUTPUTS, Case, right_hand_side

FILE = Path(__file__).with_name("model_exchange.json")
# Long enough for the bending waves of the start to come and go, and for most of the saturations.
EXCHANGE = {name: replace(case, stop=0.05, order=8) for name, case in CASES.items()}


def solve(case: Case, tolerance: float) -> tuple[list[dict[str, float]], list[float]]:
    """Outputs at equidistant times, and when commands passed their limits."""
    from scipy.integrate import solve_ivp

    loop = right_hand_side(case)
    waiting = list(np.linspace(0, case.stop, case.times + 1)[1:])
    count = len(loop.margins(loop.start))

    def margin(i: int) -> Any:
        def event(_t: float, z: np.ndarray) -> float:
            return loop.margins(z)[i]

        event.terminal = True
        return event

    t, z, rows, events = 0.0, loop.start, [], []
    while t < case.stop:
        sides = loop.margins(z) > 0
        found = solve_ivp(
            loop.f,
            (t, case.stop),
            z,
            method="DOP853",
            rtol=tolerance,
            atol=tolerance * 1e-5,
            events=[margin(i) for i in range(count)],
            dense_output=True,
        )
        if found.status < 0:
            raise ArithmeticError(found.message)
        end = float(found.t[-1])
        while waiting and waiting[0] <= end:
            values = loop.outputs(found.sol(waiting[0]))
            rows.append({"t": float(waiting.pop(0)), **{name: values[name] for name in OUTPUTS}})
        if found.status == 1:
            # Past the limit by as little as there is, where the next stretch begins.
            trifle = np.spacing(end)
            while np.array_equal(loop.margins(found.sol(end + trifle)) > 0, sides):
                trifle *= 2
            events.append(end)
            t, z = end + float(trifle), found.sol(end + trifle)
        else:
            t = end
    return rows, events


def main() -> None:
    """Solves every case at two tolerances; the file keeps the finer one and how far they are apart."""
    document: dict[str, Any] = {}
    for name, case in EXCHANGE.items():
        (coarse, early), (rows, events) = solve(case, 1e-11), solve(case, 1e-13)
        error = {
            output: float(f"{max(abs(a[output] - b[output]) for a, b in zip(coarse, rows)):.1e}") for output in OUTPUTS
        }
        apart = max((abs(a - b) for a, b in zip(early, events)), default=0.0)
        document[name] = {
            "controller": case.controller,
            "lambda1_ref": case.lambda1,
            "theta1_ref": case.theta1,
            "settings": dict(case.settings),
            "error": error,
            "at": rows,
            "events": events,
            "event_error": float(f"{apart:.1e}"),
        }
        print(name, error, len(events), len(early), apart, flush=True)
    FILE.write_text(json.dumps(document, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
