"""A small co-simulation master on top of fmpy: connects FMUs by equal names and steps them together.

    from tests.support.harness import CoSimulation, Fmu

    plant, controller = Fmu("dist/DualArmPlant.fmu"), Fmu("dist/NabfcController.fmu")
    with CoSimulation([plant, controller]) as grasp:
        grasp.set(lambda1_ref=-0.4)
        result = grasp.run(stop=1.0, step=1e-4, record=["contact_force1", "contact_force2"], every=10)
    print(result.time[-1], result["contact_force1"][-1])

The algorithm is that of the native tool, so both give the same bits: wires carry real signals from the output of one
component to the equally named input of another; initialisation exchanges them until nothing changes; then

* `gauss_seidel`: one component after the other gets its inputs, steps, and publishes its outputs;
* `jacobi`: all outputs are read, all inputs set, everybody steps (commands reach the plant one step late).
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from decimal import Decimal
from types import TracebackType

import numpy as np

from .slave import Fmu, FmuError, Port, Slave

__all__ = ["CoSimulation", "Fmu", "FmuError", "Result", "Slave"]


@dataclass
class Wire:
    """The real signals from one component to another; both ports share one buffer."""

    source: int
    target: int
    fetch: Port
    hand_over: Port


@dataclass
class Result:
    """Recorded signals over time."""

    time: np.ndarray
    signals: dict[str, np.ndarray]

    def __getitem__(self, name: str) -> np.ndarray:
        return self.signals[name]


class CoSimulation:
    """Instances of several FMUs, wired by equal names. The order counts for `gauss_seidel`."""

    COUPLINGS = ("gauss_seidel", "jacobi")
    MAX_SWEEPS = 100

    def __init__(self, fmus: Iterable[Fmu], coupling: str = "gauss_seidel") -> None:
        if coupling not in self.COUPLINGS:
            raise ValueError(f"coupling is one of {self.COUPLINGS}, not {coupling!r}")
        self.coupling = coupling
        self.slaves = [fmu.instantiate() for fmu in fmus]
        self.wires = self._connect()

    def _connect(self) -> list[Wire]:
        wires, taken = [], set()
        for target, to in enumerate(self.slaves):
            for source, from_ in enumerate(self.slaves):
                outputs = set(from_.fmu.names("output", "Real")) if source != target else set()
                names = [name for name in to.fmu.names("input", "Real") if name in outputs]
                twice = taken.intersection((target, name) for name in names)
                if twice:
                    raise ValueError(f"two components offer {sorted(name for _, name in twice)}")
                taken.update((target, name) for name in names)
                if names:
                    fetch, hand_over = from_.reader(names), to.writer(names)
                    hand_over.values = fetch.values
                    wires.append(Wire(source, target, fetch, hand_over))
        return wires

    def set(self, **values: float | str) -> None:
        """Sets start values, in every component that has a settable variable of the name."""
        for name, value in values.items():
            owners = [
                slave
                for slave in self.slaves
                if name in slave.fmu.variables and slave.fmu.variables[name].causality in ("parameter", "input")
            ]
            if not owners:
                raise KeyError(f"no component has a parameter or input {name}")
            for slave in owners:
                slave.set(**{name: value})

    def initialize(self, stop: float) -> None:
        """Consistent initial signals: exchanged in initialisation mode until nothing changes."""
        for slave in self.slaves:
            slave.fmi.setupExperiment(startTime=0.0, stopTime=stop)
            slave.fmi.enterInitializationMode()
        self._fetch_all()
        for _ in range(self.MAX_SWEEPS):
            before = [list(wire.fetch.values) for wire in self.wires]
            for index in range(len(self.slaves)):
                self._hand_over(index)
                self._fetch(index)
            if before == [list(wire.fetch.values) for wire in self.wires]:
                break
        else:
            raise FmuError("the initial signals do not settle")
        for slave in self.slaves:
            slave.fmi.exitInitializationMode()
        self._fetch_all()

    def run(
        self,
        stop: float,
        step: float,
        record: Sequence[str] = (),
        every: int = 1,
        drive: Callable[[float], Mapping[str, float]] | None = None,
    ) -> Result:
        """Initialises and steps from 0 to `stop`, a multiple of `step`.

        `record` names outputs (one of several components' is called `Component.name`); a row is kept every `every`
        steps and at the end. `drive` gives values of unconnected inputs at every communication point, held during the
        step.
        """
        self.initialize(stop)
        steps = round(stop / step)
        # Communication points are decimal fractions: 0.0003, not 3 * 1e-4.
        numerator, denominator = Decimal(repr(step)).as_integer_ratio()
        if abs(steps * step - stop) > 1e-9 * stop:
            raise ValueError(f"{stop} s is no multiple of {step} s")
        names, recorders = self._recorders(record)
        driven = self._drivers(drive)
        now = ctypes.c_double()
        calls, exchange = self._step(now, step), self._exchange()
        times, rows = [], []
        for i in range(steps + 1):
            time = stop if i == steps else i * numerator / denominator
            if drive is not None:
                self._apply(driven, drive(time))
            recorded = i % every == 0 or i == steps
            if recorded or self.coupling == "jacobi":
                for call in exchange:
                    call()
            if recorded:
                times.append(time)
                rows.append([value for port in recorders for value in port.read()])
            if i < steps:
                now.value = time
                for call in calls:
                    call()
        values = np.array(rows, dtype=float).reshape(len(rows), -1)
        return Result(np.array(times), {name: values[:, i] for i, name in enumerate(names)})

    def _step(self, now: ctypes.c_double, step: float) -> list[Callable[[], None]]:
        """The calls of a step, in order: made once, they take a fifth of the time."""
        calls = []
        for index, slave in enumerate(self.slaves):
            do_step = slave.prepared("fmi2DoStep", now, ctypes.c_double(step), ctypes.c_int(1))
            if self.coupling == "jacobi":
                calls.append(do_step)
                continue
            calls += [wire.hand_over.write for wire in self.wires if wire.target == index]
            calls.append(do_step)
            calls += [wire.fetch.fetch for wire in self.wires if wire.source == index]
        return calls

    def _exchange(self) -> list[Callable[[], None]]:
        """The calls that bring all inputs up to the current communication point."""
        fetched = [wire.fetch.fetch for wire in self.wires] if self.coupling == "jacobi" else []
        return fetched + [wire.hand_over.write for wire in self.wires]

    def _fetch(self, source: int) -> None:
        for wire in self.wires:
            if wire.source == source:
                wire.fetch.fetch()

    def _fetch_all(self) -> None:
        for wire in self.wires:
            wire.fetch.fetch()

    def _hand_over(self, target: int) -> None:
        for wire in self.wires:
            if wire.target == target:
                wire.hand_over.write()

    def _recorders(self, record: Sequence[str]) -> tuple[list[str], list[Port]]:
        """Ports for the recorded outputs, and their names in the order of a row."""
        names, ports, missing = [], [], set(record)
        for slave in self.slaves:
            own = {name: name.removeprefix(f"{slave.name}.") for name in record}
            outputs = set(slave.fmu.names("output"))
            for kind in ("Real", "Integer", "Boolean"):
                chosen = [n for n, plain in own.items() if plain in outputs and slave.fmu.variables[plain].type == kind]
                if chosen:
                    ports.append(slave.reader([own[name] for name in chosen]))
                    names += chosen
                    missing -= set(chosen)
        if missing:
            raise KeyError(f"no component has an output {', '.join(sorted(missing))}")
        if len(set(names)) != len(names):
            raise ValueError("an output belongs to several components; name it Component.name")
        return names, ports

    def _drivers(self, drive: Callable[[float], Mapping[str, float]] | None) -> list[Port]:
        if drive is None:
            return []
        names = list(drive(0.0))
        per_slave = [[name for name in names if name in slave.fmu.names("input")] for slave in self.slaves]
        unknown = set(names) - {name for chosen in per_slave for name in chosen}
        if unknown:
            raise KeyError(f"no component has an input {', '.join(sorted(unknown))}")
        return [slave.writer(chosen) for slave, chosen in zip(self.slaves, per_slave) if chosen]

    @staticmethod
    def _apply(ports: list[Port], values: Mapping[str, float]) -> None:
        for port in ports:
            port.values[:] = [values[name] for name in port.names]
            port.write()

    def close(self) -> None:
        """Frees all instances."""
        for slave in self.slaves:
            slave.close()
        self.slaves = []

    def __enter__(self) -> CoSimulation:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()
