"""An .ssp under Ecos or libcosim, which read it themselves; prints a CSV table of the plant's contact forces.

    python -m tests.judges.ssp ecos DualArmGrasp-PD.ssp 5e-5 1000 paper
    python -m tests.judges.ssp libcosim DualArmGrasp-PD.ssp 5e-5 1000

The last word is the parameter set; without one the FMUs keep their start values (Ecos), or the first set holds
(libcosim, which also takes the step from the file). A program, so that no native engine shares the process of the tests.
"""

from __future__ import annotations

import sys

SHOWN = ("contact_force1", "contact_force2", "theta1", "tip_shear1")


def ecos(path: str, step: float, steps: int, parameter_set: str | None) -> list[list[float]]:
    """Rows of time and values at every communication point."""
    from .ecos import load

    engine = load()
    engine.EcosLib.set_log_level("warn")
    simulation = engine.EcosSimulation(step_size=step, ssp_path=path)
    if not simulation.init(parameter_set=parameter_set):
        raise RuntimeError(engine.EcosLib.get_last_error())
    values = lambda: [simulation.get_real(f"plant::{name}") for name in SHOWN]  # noqa: E731
    rows = [[0.0, *values()]]
    for _ in range(steps):
        time = simulation.step()
        rows.append([time, *values()])
    return rows


def libcosim(path: str, step: float, steps: int, _parameter_set: str | None) -> list[list[float]]:
    """Rows of time and values after every step."""
    from libcosimpy.CosimExecution import CosimExecution
    from libcosimpy.CosimLogging import CosimLogLevel, log_output_level
    from libcosimpy.CosimObserver import CosimObserver

    log_output_level(CosimLogLevel.ERROR)
    execution = CosimExecution.from_ssp_file(ssp_path=path)
    observer = CosimObserver.create_last_value()
    if not execution.add_observer(observer):
        raise RuntimeError("libcosim did not add the observer")
    plant = execution.slave_index_from_instance_name("plant")
    references = {v.name.decode(): v.reference for v in execution.slave_variables(plant)}
    rows = []
    for i in range(1, steps + 1):
        if not execution.step():
            raise RuntimeError(f"libcosim did not make step {i}")
        rows.append([i * step, *observer.last_real_values(plant, [references[name] for name in SHOWN])])
    return rows


if __name__ == "__main__":
    engine, path, step, steps, *parameter_set = sys.argv[1:]
    run = {"ecos": ecos, "libcosim": libcosim}[engine]
    rows = run(path, float(step), int(steps), parameter_set[0] if parameter_set else None)
    print(",".join(["time", *SHOWN]))
    for row in rows:
        print(",".join(map(repr, row)))
