"""Every scenario in a host that stops at any status but fmi2OK, as OMSimulator, PyFMI, MasterSim and others do.

The host is a C program, `strict_host.c`, made here with the system's compiler; this file turns scenarios into plans.
"""

from __future__ import annotations

import shutil
import subprocess
import sys
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from .support.contract import ACTUATORS, CONTROLLERS, INSTRUMENTS
from .support.exchange import Grasp, Model, fixed_steps
from .support.harness import Fmu
from .support.paths import ROOT

tomllib = pytest.importorskip("tomllib", reason="scenarios are TOML, which Python reads from 3.11 on")

FOLDER = ROOT / "scenarios"
SCENARIOS = sorted(path for path in FOLDER.rglob("*.toml") if path.parent.name != "studies")
READ = ("contact_force1", "contact_force2")


@pytest.fixture(scope="session")
def strict_host(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The host, compiled."""
    compiler = shutil.which("cc")
    if compiler is None or sys.platform == "win32":
        pytest.skip("needs a C compiler named cc and dlopen")
    program = tmp_path_factory.mktemp("strict") / "strict_host"
    source = Path(__file__).parent / "strict_host.c"
    # Sums of products are rounded as they are written, also where the processor could do both at once.
    options = ("-O1", "-ffp-contract=off", "-Wall", "-Werror")
    subprocess.run([compiler, *options, "-o", program, source, "-ldl"], check=True)
    return program


def library(fmu: Fmu) -> Path:
    """The FMU's shared library."""
    name = f"{fmu.name}.dylib" if sys.platform == "darwin" else f"{fmu.name}.so"
    (found,) = (path for path in (Path(fmu.directory) / "binaries").glob(f"*/{name}"))
    return found


def owners(fmus: list[Fmu], name: str) -> list[tuple[int, Any]]:
    """The slaves with a variable of this name that a host sets, and the variable: of one FMU with `FMU.name`."""
    found = []
    for slave, fmu in enumerate(fmus):
        prefix, _, rest = name.partition(".")
        variable = fmu.variables.get(rest if prefix == fmu.name else name)
        if variable is not None and variable.causality in ("parameter", "input"):
            found.append((slave, variable))
    assert found, name
    return found


def start_values(fmus: list[Fmu], parameters: Mapping[str, float | str]) -> Iterator[str]:
    """Lines that set parameters; enumerations by the names of their items."""
    for name, value in parameters.items():
        for slave, variable in owners(fmus, name):
            if variable.type == "Enumeration":
                items = [item.name for item in variable.declaredType.items]
                yield f"integer {slave} {variable.valueReference} {items.index(value) + 1}"
            else:
                yield f"real {slave} {variable.valueReference} {value!r}"


def signal(spec: Any, times: np.ndarray) -> np.ndarray:
    """Values of an input at the communication points: a constant, steps or straight lines."""
    if not isinstance(spec, Mapping):
        return np.full_like(times, spec)
    ((kind, points),) = spec.items()
    at, values = np.array(points, dtype=float).T
    if kind == "linear":
        return np.interp(times, at, values)
    assert kind == "steps"
    return values[np.searchsorted(at, times + 1e-9, side="right") - 1]


def wires(fmus: list[Fmu]) -> Iterator[tuple[int, str, int, str]]:
    """Output to input of the same name, but for what goes through sensors or actuators, in the order of the outputs."""
    through = {"_measured": INSTRUMENTS, "_sent": ACTUATORS}
    between = {fmu.name for fmu in fmus} & set(through.values())
    for source, fmu in enumerate(fmus):
        for output in fmu.names("output", "Real"):
            suffix = next((s for s, name in through.items() if name == fmu.name), "")
            signal = output.removesuffix(suffix)
            for target, other in enumerate(fmus):
                to = other.variables.get(signal)
                if target == source or to is None or to.causality != "input":
                    continue
                # Not past those that are between, and from them not back to each other.
                past = not suffix and between and other.name not in between
                if not past and not (suffix and other.name in between):
                    yield source, output, target, signal


def plan(fmus: list[Fmu], scenario: Mapping[str, Any]) -> str:
    """The scenario as the host reads it."""
    size = scenario["experiment"]["step"]
    steps = round(scenario["experiment"]["stop"] / size)
    lines = [f"slave {fmu.description.guid} {library(fmu)}" for fmu in fmus]
    lines += start_values(fmus, scenario.get("parameters", {}))
    for source, output, target, to in wires(fmus):
        references = (fmus[source].variables[output].valueReference, fmus[target].variables[to].valueReference)
        lines.append(f"wire {source} {references[0]} {target} {references[1]}")
    drives = []
    for name, spec in scenario.get("inputs", {}).items():
        values = signal(spec, np.arange(steps) * size)
        changes = np.flatnonzero(np.diff(values, prepend=np.nan) != 0)
        for slave, variable in owners(fmus, name):
            drives += [(int(i), slave, variable.valueReference, float(values[i])) for i in changes]
    lines += [f"drive {i} {slave} {reference} {value!r}" for i, slave, reference, value in sorted(drives)]
    lines += [f"read 0 {fmus[0].variables[name].valueReference}" for name in READ]
    return "\n".join([*lines, f"run {steps} {size!r}\n"])


@pytest.mark.parametrize("path", SCENARIOS, ids=lambda path: str(path.relative_to(FOLDER).with_suffix("")))
def test_scenario_runs_in_a_strict_host(path: Path, fmus: Mapping[str, Fmu], strict_host: Path) -> None:
    """It runs to its end, warnings are told nevertheless, and the forces end where they should."""
    scenario = tomllib.loads(path.read_text(encoding="utf-8"))
    used = [fmus[name.removesuffix(".fmu")] for name in scenario["fmus"]]
    done = subprocess.run([strict_host], input=plan(used, scenario), capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    *forces, warnings = (float(line) for line in done.stdout.split())
    assert np.all(np.isfinite(forces))
    # From zero preload the first milliseconds are tensile, which the plant says; some scenarios begin with a squeeze. What
    # happens where a grasp can open is up to it.
    parameters = scenario.get("parameters", {})
    if path.parent == FOLDER and "contact_model" not in parameters:
        assert (warnings == 0) == ("theta1_0" in parameters)


@pytest.mark.parametrize("controller", CONTROLLERS)
def test_model_exchange_in_a_strict_host(controller: str, fmus: Mapping[str, Fmu], strict_host: Path) -> None:
    """Plant and controller as one system in the C host: the bits of the same steps in Python, through the first events."""
    pair, size, steps, every = [fmus["DualArmPlant"], fmus[controller]], 5e-6, 400, 40
    shown = ("theta1", "root_moment1", *READ)
    lines = ["exchange", *(f"slave {fmu.description.guid} {library(fmu)}" for fmu in pair)]
    for slave, fmu in enumerate(pair):
        about = fmu.description
        lines.append(f"size {slave} {about.numberOfContinuousStates} {about.numberOfEventIndicators}")
    for source, output, target, to in wires(pair):
        references = (pair[source].variables[output].valueReference, pair[target].variables[to].valueReference)
        lines.append(f"wire {source} {references[0]} {target} {references[1]}")
    lines += [f"read 0 {pair[0].variables[name].valueReference}" for name in shown]
    text = "\n".join([*lines, f"trace {every}", f"integrate {steps} {size!r}\n"])
    done = subprocess.run([strict_host], input=text, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    *rows, events = done.stdout.split("\n")[:-1]
    theirs = np.array([[int(word, 16) for word in row.split()] for row in rows], dtype=np.uint64).view(float)

    with Model(pair[0]) as plant, Model(pair[1]) as law:
        outputs, ours = plant.reader(shown), []
        found = fixed_steps(Grasp(plant, law), size, steps, lambda _time: ours.append(outputs.read()))
    assert int(events) == found
    # The commands of PD and PDS pass their limits in the first third of a millisecond.
    assert found > 0 or controller == "NabfcController"
    assert np.array_equal(theirs, ours[every - 1 :: every])
