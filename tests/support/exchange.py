"""FMUs for model exchange, and hosts that integrate them: one alone, and plant and controller as one system.

FMPy loads and initialises; what a solver calls goes to the library directly with buffers made once.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from fmpy.fmi2 import FMU2Model, defaultCallbacks, fmi2CallbackFunctions, fmi2CallbackLoggerTYPE

from .contract import COMMANDS, MEASURED
from .slave import Fmu, FmuError, Message, Slave

DOUBLES = ctypes.POINTER(ctypes.c_double)
DISCARD = 2


class EventInfo(ctypes.Structure):
    """fmi2EventInfo."""

    _fields_ = [(name, ctypes.c_int) for name in ("again", "terminate", "nominals", "states", "has_next_time")] + [
        ("next_time", ctypes.c_double)
    ]


class Model(Slave):
    """An instance for model exchange. Counts the evaluations of its derivatives."""

    def __init__(self, fmu: Fmu, name: str | None = None) -> None:  # pylint: disable=super-init-not-called
        self.fmu, self.name = fmu, name or fmu.name
        self.log: list[Message] = []
        self._callbacks = fmi2CallbackFunctions(
            fmi2CallbackLoggerTYPE(self._keep), defaultCallbacks.allocateMemory, defaultCallbacks.freeMemory
        )
        description = fmu.description
        self.fmi = FMU2Model(
            guid=description.guid,
            unzipDirectory=fmu.directory,
            modelIdentifier=description.modelExchange.modelIdentifier,
            instanceName=self.name,
        )
        self.fmi.instantiate(callbacks=self._callbacks)
        structure = [(unknown.variable.derivative, unknown.variable) for unknown in description.derivatives]
        self.states = [state.name for state, _ in structure]
        self.derivatives = [derivative.name for _, derivative in structure]
        self.size, self.indicator_count = len(self.states), description.numberOfEventIndicators
        self.evaluations = 0
        self._x, self._dx = np.zeros(self.size), np.zeros(self.size)
        self._z = np.zeros(self.indicator_count)
        array, count = DOUBLES, ctypes.c_size_t
        states, indicators = count(self.size), count(self.indicator_count)
        self.set_time = self._function("fmi2SetTime", ctypes.c_double)
        self._set_states = self.prepared("fmi2SetContinuousStates", _pointer(self._x), states)
        self._get_states = self.prepared("fmi2GetContinuousStates", _pointer(self._x), states)
        self._get_nominals = self._function("fmi2GetNominalsOfContinuousStates", array, count)
        self._get_derivatives = self.prepared("fmi2GetDerivatives", _pointer(self._dx), states)
        self._get_indicators = self.prepared("fmi2GetEventIndicators", _pointer(self._z), indicators)
        self._enter_event_mode = self._function("fmi2EnterEventMode")
        self._enter_continuous_time_mode = self._function("fmi2EnterContinuousTimeMode")
        self.info = EventInfo()
        self._new_discrete_states = self.prepared("fmi2NewDiscreteStates", ctypes.byref(self.info))
        self._jacobians: dict[tuple[tuple[str, ...], tuple[str, ...]], Any] = {}
        self._event, self._end = ctypes.c_int(), ctypes.c_int()
        self._completed = self.prepared(
            "fmi2CompletedIntegratorStep", ctypes.c_int(1), ctypes.byref(self._event), ctypes.byref(self._end)
        )

    def start(self, start_time: float = 0.0) -> None:
        """From instantiated to continuous-time mode."""
        super().start(start_time)
        self.update(enter=False)

    def update(self, enter: bool = True) -> EventInfo:
        """An event: into event mode, until the discrete states settle, and back."""
        if enter:
            self._enter_event_mode()
        self.info.again = 1
        while self.info.again:
            self._new_discrete_states()
        self._enter_continuous_time_mode()
        return self.info

    def step_completed(self) -> tuple[bool, bool]:
        """Tells that a step is accepted; whether event mode is wanted, and the end."""
        self._completed()
        return bool(self._event.value), bool(self._end.value)

    @property
    def x(self) -> np.ndarray:
        """The continuous states."""
        self._get_states()
        return self._x.copy()

    @x.setter
    def x(self, values: np.ndarray) -> None:
        self._x[:] = values
        self._set_states()

    @property
    def nominals(self) -> np.ndarray:
        """Their nominal values."""
        values = np.zeros(self.size)
        self._get_nominals(_pointer(values), self.size)
        return values

    def rates(self) -> np.ndarray:
        """Their time derivatives."""
        self.evaluations += 1
        self._get_derivatives()
        return self._dx.copy()

    def indicators(self) -> np.ndarray:
        """The event indicators."""
        self._get_indicators()
        return self._z.copy()

    def jacobian(self, unknowns: Sequence[str], knowns: Sequence[str]) -> np.ndarray:
        """Partial derivatives, a column for each known, by fmi2GetDirectionalDerivative."""
        key = tuple(unknowns), tuple(knowns)
        if key not in self._jacobians:
            self._jacobians[key] = self._columns(*key)
        matrix, calls = self._jacobians[key]
        for call in calls:
            call()
        return matrix.T.copy()

    def _columns(self, unknowns: tuple[str, ...], knowns: tuple[str, ...]) -> tuple[np.ndarray, list[Callable[[], None]]]:
        """A matrix, and the calls that fill its rows with the derivatives by one of the knowns each."""
        variables, count = self.fmu.variables, ctypes.c_size_t
        rows = (ctypes.c_uint * len(unknowns))(*(variables[name].valueReference for name in unknowns))
        matrix = np.zeros((len(knowns), len(unknowns)))
        calls = []
        for name, row in zip(knowns, matrix):
            known, seed = (ctypes.c_uint * 1)(variables[name].valueReference), (ctypes.c_double * 1)(1.0)
            arguments = (rows, count(len(unknowns)), known, count(1), seed, _pointer(row))
            calls.append(self.prepared("fmi2GetDirectionalDerivative", *arguments))
        return matrix, calls


def _pointer(array: np.ndarray) -> Any:
    return array.ctypes.data_as(DOUBLES)


class Grasp:
    """Plant and controller as one system of differential equations z' = f(z), z = (plant's states, controller's states)."""

    def __init__(self, plant: Model, controller: Model) -> None:
        self.plant, self.controller = plant, controller
        measured = [name for name in (*MEASURED, "root_moment1_dot", "root_moment2_dot")]
        self.measured, self.commands = measured, list(COMMANDS)
        self._measured, self._seen = plant.reader(measured), controller.writer(measured)
        self._commanded, self._received = controller.reader(self.commands), plant.writer(self.commands)
        self._seen.values, self._received.values = self._measured.values, self._commanded.values
        self.split = plant.size

    def start(self) -> np.ndarray:
        """Both initialised, with each other's outputs; the initial states."""
        for model in (self.plant, self.controller):
            model.fmi.setupExperiment(startTime=0.0)
            model.fmi.enterInitializationMode()
        self.exchange()
        for model in (self.plant, self.controller):
            model.fmi.exitInitializationMode()
            model.update(enter=False)
        self.exchange()
        return self.z

    def exchange(self) -> None:
        """Measurements to the controller, commands back: the plant's measured outputs do not follow commands at once."""
        self._measured.fetch()
        self._seen.write()
        self._commanded.fetch()
        self._received.write()

    @property
    def z(self) -> np.ndarray:
        """All states."""
        return np.concatenate([self.plant.x, self.controller.x])

    def put(self, z: np.ndarray) -> None:
        """Sets all states, and what the two tell each other then."""
        self.plant.x, self.controller.x = z[: self.split], z[self.split :]
        self.exchange()

    def rates(self, _t: float, z: np.ndarray) -> np.ndarray:
        """The right-hand side; NaN where a model discards states, so that the solver tries a shorter step."""
        try:
            self.put(z)
            return np.concatenate([self.plant.rates(), self.controller.rates()])
        except FmuError as error:
            if error.status != DISCARD:
                raise
            return np.full_like(z, np.nan)

    def jacobian(self, _t: float, z: np.ndarray) -> np.ndarray:
        """Its exact derivative, from the directional derivatives of both."""
        self.put(z)
        plant, law = self.plant, self.controller
        A, B = plant.jacobian(plant.derivatives, plant.states), plant.jacobian(plant.derivatives, self.commands)
        C = plant.jacobian(self.measured, plant.states)
        a, b = law.jacobian(law.derivatives, law.states), law.jacobian(law.derivatives, self.measured)
        c, d = law.jacobian(self.commands, law.states), law.jacobian(self.commands, self.measured)
        return np.block([[A + B @ d @ C, B @ c], [b @ C, a]])

    def indicators(self, z: np.ndarray) -> np.ndarray:
        """The event indicators of both."""
        self.put(z)
        return np.concatenate([self.plant.indicators(), self.controller.indicators()])

    def event(self) -> np.ndarray:
        """Updates the discrete states of both; the states then."""
        for model in (self.plant, self.controller):
            model.update()
        self.exchange()
        return self.z


def fixed_steps(grasp: Grasp, size: float, steps: int, at: Callable[[float], None]) -> int:
    """Classical Runge-Kutta steps of one size, events at their ends, as the Reference FMUs' `fmusim` has them.

    Calls `at` after each step; returns how many events there were.

    Hosts in other languages do the very same operations (`strict_host.c`, `judges/rust-fmi`) and get the same bits.
    """
    models, events = (grasp.plant, grasp.controller), 0
    z = grasp.start()
    sides = grasp.indicators(z) > 0

    def rates(time: float, z: np.ndarray) -> np.ndarray:
        for model in models:
            model.set_time(time)
        return grasp.rates(time, z)

    for i in range(steps):
        time = i * size
        k1 = rates(time, z)
        k2 = rates(time + size / 2, z + size / 2 * k1)
        k3 = rates(time + size / 2, z + size / 2 * k2)
        k4 = rates(time + size, z + size * k3)
        z = z + size / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
        for model in models:
            model.set_time(time + size)
        now = grasp.indicators(z) > 0
        wishes = [model.step_completed() for model in models]
        if any(end for _, end in wishes):
            raise ArithmeticError("a model wants to end the simulation")
        if np.any(now != sides) or any(event for event, _ in wishes):
            z = grasp.event()
            now = grasp.indicators(z) > 0
            events += 1
        sides = now
        at(time + size)
    return events


def integrate(
    rates: Callable[[float, np.ndarray], np.ndarray],
    z: np.ndarray,
    stop: float,
    times: Sequence[float],
    indicators: Callable[[np.ndarray], np.ndarray] | None = None,
    event: Callable[[], np.ndarray] | None = None,
    at: Callable[[float, np.ndarray], None] = lambda t, z: None,
    **options: Any,
) -> list[float]:
    """From 0 to `stop`, calling `at` at the times; when events came. What a host of the standard does, with SciPy's solvers.

    An event is where an indicator changes its side of zero. It is located on the solver's dense output, by bisection to the last
    bit.
    """
    from scipy.integrate import DOP853

    method = options.pop("method", DOP853)
    waiting, found, t = list(times), [], 0.0
    while t < stop:
        solver = method(rates, t, z, stop, **options)
        sides = indicators(z) > 0 if indicators else None
        while solver.status == "running":
            message = solver.step()
            if solver.status == "failed":
                raise ArithmeticError(message)
            before, after, dense = solver.t_old, solver.t, solver.dense_output()
            crossed = indicators is not None and np.any((indicators(solver.y) > 0) != sides)
            while crossed and before < (middle := before + 0.5 * (after - before)) < after:
                if np.array_equal(indicators(dense(middle)) > 0, sides):
                    before = middle
                else:
                    after = middle
            while waiting and waiting[0] <= after:
                at(waiting[0], dense(waiting[0]) if waiting[0] < solver.t else solver.y)
                waiting.pop(0)
            t, z = after, dense(after) if crossed and after < solver.t else solver.y
            if crossed:
                rates(t, z)
                found.append(t)
                z = event()
                break
    return found
