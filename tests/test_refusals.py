"""Every refusal is heard: what returns fmi2Discard, fmi2Error or fmi2Fatal says why through the logger, also when logging is
off, as FMPy and most tools have it (FMI 2.0.4, section 2.1.3, and what the Reference-FMUs do).
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Iterator
from ctypes import byref, c_double, c_int, c_size_t, c_uint, c_void_p

import pytest

from .support.contract import FMUS
from .support.harness import Fmu, Slave
from .support.paths import fmu_path

WARNING, PENDING = 1, 5
NOWHERE = 999_999


@pytest.fixture(params=FMUS)
def fmu(request: pytest.FixtureRequest) -> Iterator[Fmu]:
    fmu = Fmu(fmu_path(request.param))
    yield fmu
    fmu.close()


def references(*values: int) -> ctypes.Array:
    return (c_uint * len(values))(*values)


def doubles(*values: float) -> ctypes.Array:
    return (c_double * len(values))(*values)


def calls_before_a_step(slave: Slave) -> dict[str, tuple]:
    """Arguments of calls that no slave can answer, by what is wrong with them."""
    output = slave.fmu.variables[slave.fmu.names("output", "Real")[0]].valueReference
    inputs = slave.fmu.names("input", "Real")
    real = slave.fmu.variables[inputs[0]].valueReference
    state, blob = c_void_p(), ctypes.create_string_buffer(b"no state at all", 15)
    return {
        "a step before initialization": ("fmi2DoStep", c_double(0), c_double(1e-3), c_int(1)),
        "the end of what has not begun": ("fmi2ExitInitializationMode",),
        "termination before the start": ("fmi2Terminate",),
        "no such variable, set": ("fmi2SetReal", references(NOWHERE), c_size_t(1), doubles(0)),
        "no such variable, read": ("fmi2GetReal", references(NOWHERE), c_size_t(1), doubles(0)),
        "an output, set": ("fmi2SetReal", references(output), c_size_t(1), doubles(0)),
        "no number": ("fmi2SetReal", references(real), c_size_t(1), doubles(float("nan"))),
        "no references": ("fmi2SetReal", None, c_size_t(1), doubles(0)),
        "no place for a state": ("fmi2GetFMUstate", None),
        "bytes that are no state": ("fmi2DeSerializeFMUstate", blob, c_size_t(15), byref(state)),
        "an order that nobody has": ("fmi2SetRealInputDerivatives", references(real), c_size_t(1), (c_int * 1)(99), doubles(0)),
        "derivatives of nothing": (
            "fmi2GetDirectionalDerivative", references(NOWHERE), c_size_t(1), references(real), c_size_t(1), doubles(1), doubles(0),
        ),
    }  # fmt: skip


def calls_while_it_runs(_slave: Slave) -> dict[str, tuple]:
    return {
        "a step back": ("fmi2DoStep", c_double(0), c_double(-1e-3), c_int(1)),
        "a step of no length that is a number": ("fmi2DoStep", c_double(0), c_double(float("nan")), c_int(1)),
        "a step from another time": ("fmi2DoStep", c_double(7), c_double(1e-3), c_int(1)),
        "an experiment that has begun": ("fmi2SetupExperiment", c_int(0), c_double(0), c_double(0), c_int(0), c_double(0)),
        "a second start": ("fmi2EnterInitializationMode",),
        "an order that nobody has": ("fmi2GetRealOutputDerivatives", references(0), c_size_t(1), (c_int * 1)(99), doubles(0)),
        "a status that nobody has": ("fmi2GetRealStatus", c_int(99), byref(c_double())),
    }


@pytest.mark.parametrize("calls", [calls_before_a_step, calls_while_it_runs])
def test_a_refusal_says_why_with_logging_off(fmu: Fmu, calls: Callable[[Slave], dict[str, tuple]]) -> None:
    for what in calls(fmu.instantiate()):
        # An error may be the last thing that an instance does: each gets one of its own.
        slave = fmu.instantiate()
        if calls is calls_while_it_runs:
            slave.fmi.setupExperiment()
            slave.fmi.enterInitializationMode()
            slave.fmi.exitInitializationMode()
        function, *arguments = calls(slave)[what]
        before = len(slave.log)
        status = slave.fmi.dll[function](c_void_p(slave.fmi.component), *arguments)
        assert WARNING < status < PENDING, f"{what} was accepted"
        said = slave.log[before:]
        assert said, f"{function} returned {status} for {what}, and nobody heard why"
        assert said[-1].status == status, what
        assert len(said[-1].text) > 15, f"{what}: {said[-1].text!r}"


def test_no_instance_for_another_description_says_why(fmu: Fmu) -> None:
    heard = []
    callbacks = type(fmu.instantiate()._callbacks)  # noqa: SLF001 (fmpy's structure)
    logger = callbacks._fields_[0][1](lambda _e, _i, status, _c, text: heard.append((status, text)))  # noqa: SLF001
    good = fmu.instantiate()._callbacks  # noqa: SLF001
    functions = callbacks(logger, good.allocateMemory, good.freeMemory)
    dll = fmu.instantiate().fmi.dll
    dll.fmi2Instantiate.restype = c_void_p
    component = dll.fmi2Instantiate(b"x", c_int(1), b"{no guid}", b"file:///", byref(functions), c_int(0), c_int(0))
    assert not component
    assert [status for status, _ in heard] == [3]
    assert b"GUID" in heard[0][1] or b"guid" in heard[0][1]
