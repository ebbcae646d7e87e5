"""Plant and controller under Ecos, wired by equal names; prints a CSV table of all real outputs.

    python -m tests.judges.ecos DualArmPlant.fmu PdController.fmu 1e-4 1000 '{"plant::M": 0.4}'

A program, so that a native engine with threads does not share the process of the tests. Ecos reads the model
descriptions itself; only the names to connect come from here.

Defects of the wheel ecospy 0.7.2: its library needs `libtbb.so.12`, which the wheel does not contain (PyPI's `tbb`
does); and it needs Python 3.10, which it does not say.
"""

from __future__ import annotations

import ctypes
import importlib.metadata
import json
import sys
from contextlib import suppress
from pathlib import Path
from types import ModuleType

from fmpy import read_model_description

INSTANCES = ("plant", "controller")


def load() -> ModuleType:
    """Imports ecospy after the library it forgets to bring. Raises ImportError or OSError where there is none."""
    with suppress(importlib.metadata.PackageNotFoundError):  # the system may have it
        for file in importlib.metadata.files("tbb") or []:
            if file.name == "libtbb.so.12":
                ctypes.CDLL(str(file.locate()), mode=ctypes.RTLD_GLOBAL)
    import ecospy

    return ecospy


def simulate(paths: list[str], step: float, steps: int, parameters: dict[str, float]) -> str:
    """The table, one row per communication point."""
    ecos = load()
    ecos.EcosLib.set_log_level("off")
    descriptions = [read_model_description(path) for path in paths]
    outputs, inputs = (
        [[v.name for v in d.modelVariables if v.causality == causality and v.type == "Real"] for d in descriptions]
        for causality in ("output", "input")
    )
    with ecos.EcosSimulationStructure() as structure:
        for instance, path in zip(INSTANCES, paths):
            structure.add_model(instance, str(Path(path).resolve()))
        for source, target in ((0, 1), (1, 0)):
            for name in set(outputs[source]) & set(inputs[target]):
                structure.make_real_connection(f"{INSTANCES[source]}::{name}", f"{INSTANCES[target]}::{name}")
        structure.add_parameter_set("settings", parameters)
        simulation = ecos.EcosSimulation(step_size=step, structure=structure)
        if not simulation.init(parameter_set="settings"):
            raise RuntimeError(ecos.EcosLib.get_last_error())
        shown = [f"{instance}::{name}" for instance, names in zip(INSTANCES, outputs) for name in names]
        lines = [",".join(["time", *(name for names in outputs for name in names)])]
        time = 0.0
        for i in range(steps + 1):
            lines.append(",".join(map(repr, [time, *map(simulation.get_real, shown)])))
            if i < steps:
                time = simulation.step()
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    *paths, step, steps, parameters = sys.argv[1:]
    sys.stdout.write(simulate(paths, float(step), int(steps), json.loads(parameters)))
