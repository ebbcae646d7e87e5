"""Optional functions of FMI 2.0 by name: derivatives of inputs and outputs, directional derivatives, saved states."""

from __future__ import annotations

import ctypes
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import partial

from .slave import Port, Slave

_REAL, _REFERENCE = ctypes.POINTER(ctypes.c_double), ctypes.POINTER(ctypes.c_uint)


def output_slopes(slave: Slave, names: Sequence[str]) -> Port:
    """A port that fetches first derivatives of these outputs."""
    return _slopes(slave, "fmi2GetRealOutputDerivatives", names)


def input_slopes(slave: Slave, names: Sequence[str]) -> Port:
    """A port that hands first derivatives of these inputs over, for the next step."""
    return _slopes(slave, "fmi2SetRealInputDerivatives", names)


def _slopes(slave: Slave, function_name: str, names: Sequence[str]) -> Port:
    size = len(names)
    orders = (ctypes.c_int * size)(*[1] * size)
    references = (ctypes.c_uint * size)(*_references(slave, names))
    call = partial(slave.prepared, function_name, references, ctypes.c_size_t(size), orders)
    return Port(tuple(names), call, (ctypes.c_double * size)())


def directional_derivative(slave: Slave, outputs: Sequence[str], direction: Mapping[str, float]) -> list[float]:
    """Derivative of the outputs along a direction of the inputs."""
    size = ctypes.c_size_t
    function = slave._function("fmi2GetDirectionalDerivative", _REFERENCE, size, _REFERENCE, size, _REAL, _REAL)
    unknowns, knowns = ((ctypes.c_uint * len(n))(*_references(slave, n)) for n in (list(outputs), list(direction)))
    derivatives = (ctypes.c_double * len(unknowns))()
    seed = (ctypes.c_double * len(knowns))(*direction.values())
    function(unknowns, len(unknowns), knowns, len(knowns), seed, derivatives)
    return list(derivatives)


def _references(slave: Slave, names: Sequence[str]) -> list[int]:
    return [slave.fmu.variables[name].valueReference for name in names]


# --- Saved states: fmi2FMUstate is a pointer, handled as c_void_p. ---------------------------------------------------

_STATE, _BYTES = ctypes.c_void_p, ctypes.c_char_p


@contextmanager
def saved_state(slave: Slave) -> Iterator[ctypes.c_void_p]:
    """The state of an instance now, freed at the end; `restore` leads back to it."""
    state = ctypes.c_void_p()
    slave._function("fmi2GetFMUstate", ctypes.POINTER(_STATE))(ctypes.byref(state))
    try:
        yield state
    finally:
        free(slave, state)


def restore(slave: Slave, state: ctypes.c_void_p) -> None:
    """Back to a saved state."""
    slave._function("fmi2SetFMUstate", _STATE)(state)


def free(slave: Slave, state: ctypes.c_void_p) -> None:
    """Frees a saved state."""
    slave._function("fmi2FreeFMUstate", ctypes.POINTER(_STATE))(ctypes.byref(state))


def to_bytes(slave: Slave) -> bytes:
    """The state of an instance now, serialised."""
    with saved_state(slave) as state:
        size = ctypes.c_size_t()
        slave._function("fmi2SerializedFMUstateSize", _STATE, ctypes.POINTER(ctypes.c_size_t))(
            state, ctypes.byref(size)
        )
        buffer = ctypes.create_string_buffer(size.value)
        slave._function("fmi2SerializeFMUstate", _STATE, _BYTES, ctypes.c_size_t)(state, buffer, size)
        return buffer.raw


def from_bytes(slave: Slave, blob: bytes) -> None:
    """Puts an instance in a serialised state."""
    state = ctypes.c_void_p()
    slave._function("fmi2DeSerializeFMUstate", _BYTES, ctypes.c_size_t, ctypes.POINTER(_STATE))(
        blob, len(blob), ctypes.byref(state)
    )
    try:
        restore(slave, state)
    finally:
        free(slave, state)
