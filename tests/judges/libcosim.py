"""Plant and controller under libcosim, wired by equal names; prints a CSV table of the plant's real outputs.

    python -m tests.judges.libcosim DualArmPlant.fmu PdController.fmu 1e-4 1000 '{"M": 0.4}'

A program, so that a native engine does not share the process of the tests. libcosim reads the model descriptions itself
and checks every connection and value.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path

from libcosimpy.CosimEnums import CosimVariableCausality, CosimVariableType
from libcosimpy.CosimExecution import CosimExecution
from libcosimpy.CosimLogging import CosimLogLevel, log_output_level
from libcosimpy.CosimObserver import CosimObserver
from libcosimpy.CosimSlave import CosimLocalSlave


def check(code: int) -> None:
    """The wrapper hands on what the C functions return: zero, or an error."""
    if code != 0:
        raise RuntimeError(f"libcosim refused a connection ({code})")


def simulate(paths: list[str], step: float, steps: int, parameters: dict[str, float]) -> str:
    """The table, one row per communication point after a step."""
    log_output_level(CosimLogLevel.ERROR)
    execution = CosimExecution.from_step_size(step_size=round(step * 1e9))  # in ns
    slaves = [
        execution.add_local_slave(CosimLocalSlave(fmu_path=str(Path(path).resolve()), instance_name=Path(path).stem))
        for path in paths
    ]
    reals = [
        {v.name.decode(): v for v in execution.slave_variables(slave) if v.type == CosimVariableType.REAL.value}
        for slave in slaves
    ]
    for source, target in ((0, 1), (1, 0)):
        for name, output in reals[source].items():
            other = reals[target].get(name)
            if (
                other is not None
                and output.causality == CosimVariableCausality.OUTPUT.value
                and other.causality == CosimVariableCausality.INPUT.value
            ):
                check(
                    execution.connect_real_variables(slaves[source], output.reference, slaves[target], other.reference)
                )
    for slave, variables in zip(slaves, reals):
        for name, value in parameters.items():
            if name in variables and not execution.real_initial_value(slave, variables[name].reference, value):
                raise RuntimeError(f"libcosim did not set {name}")
    observer = CosimObserver.create_last_value()
    if not execution.add_observer(observer):
        raise RuntimeError("libcosim did not add the observer")
    shown = {name: v for name, v in reals[0].items() if v.causality == CosimVariableCausality.OUTPUT.value}
    references = [v.reference for v in shown.values()]
    lines = [",".join(["time", *shown])]
    for i in range(1, steps + 1):
        if not execution.step():
            raise RuntimeError(f"libcosim did not make step {i}")
        lines.append(",".join(map(repr, [i * step, *observer.last_real_values(slaves[0], references)])))
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    *paths, step, steps, parameters = sys.argv[1:]
    sys.stdout.write(simulate(paths, float(step), int(steps), json.loads(parameters)))
