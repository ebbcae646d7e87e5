"""FMUs through fmpy with access by name: the one place where the tests touch the C interface.

fmpy loads, instantiates and initialises; getting, setting and stepping go to the library directly with arguments
converted once, which takes half a microsecond per call instead of 10.
"""

from __future__ import annotations

import ctypes
import shutil
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from fmpy import extract, read_model_description
from fmpy.fmi2 import (
    FMU2Slave,
    defaultCallbacks,
    fmi2CallbackFunctions,
    fmi2CallbackLoggerTYPE,
)

OK = 0
TYPES = {"Real": ctypes.c_double, "Integer": ctypes.c_int, "Enumeration": ctypes.c_int, "Boolean": ctypes.c_int}


class FmuError(Exception):
    """A call to an FMU did not return OK; the text holds what the FMU logged."""

    status = 0


class Fmu:
    """An unpacked FMU with its description; instances are made from it. Removed from disk by `close`."""

    def __init__(self, path: str | Path) -> None:
        self.path = Path(path)
        self.description = read_model_description(str(path))
        self.variables = {variable.name: variable for variable in self.description.modelVariables}
        self.directory = tempfile.mkdtemp(prefix=f"{self.name}-")
        extract(str(path), self.directory)

    @property
    def name(self) -> str:
        """The model's name."""
        return self.description.modelName

    def names(self, causality: str, kind: str | None = None) -> list[str]:
        """Names of all variables of a causality (and type)."""
        return [v.name for v in self.variables.values() if v.causality == causality and kind in (None, v.type)]

    def instantiate(self, name: str | None = None, guid: str | None = None, logging: bool = False) -> Slave:
        """A new instance."""
        return Slave(self, self.directory, name or self.name, guid, logging)

    def close(self) -> None:
        """Removes the unpacked files."""
        shutil.rmtree(self.directory, ignore_errors=True)


@dataclass
class Message:
    """What an FMU said through the logger callback."""

    status: int
    category: str
    text: str


class Slave:
    """One instance: fmpy's, with access by name and a log that is kept instead of printed."""

    def __init__(self, fmu: Fmu, directory: str, name: str, guid: str | None, logging: bool) -> None:
        self.fmu, self.name = fmu, name
        self.log: list[Message] = []
        self._callbacks = fmi2CallbackFunctions(
            fmi2CallbackLoggerTYPE(self._keep),
            defaultCallbacks.allocateMemory,
            defaultCallbacks.freeMemory,
        )
        description = fmu.description
        self.fmi = FMU2Slave(
            guid=guid or description.guid,
            unzipDirectory=directory,
            modelIdentifier=description.coSimulation.modelIdentifier,
            instanceName=name,
        )
        self.fmi.instantiate(callbacks=self._callbacks, loggingOn=logging)
        self.step = self._function("fmi2DoStep", ctypes.c_double, ctypes.c_double, ctypes.c_int)

    def _keep(self, _environment: Any, _instance: bytes, status: int, category: bytes, text: bytes) -> None:
        self.log.append(Message(status, (category or b"").decode(), (text or b"").decode()))

    def _function(self, name: str, *argument_types: Any) -> Callable[..., None]:
        """A C function with the component bound, which raises when the status is not OK."""
        prototype = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.c_void_p, *argument_types)
        function, component = prototype((name, self.fmi.dll)), self.fmi.component

        def call(*arguments: Any) -> None:
            status = function(component, *arguments)
            if status != OK:
                raise self._error(name, status)

        return call

    def prepared(self, name: str, *arguments: Any) -> Callable[[], None]:
        """A call of a C function with these ctypes objects, whose values may change: nothing is converted any more."""
        function = partial(self.fmi.dll[name], ctypes.c_void_p(self.fmi.component), *arguments)

        def call() -> None:
            status = function()
            if status != OK:
                raise self._error(name, status)

        return call

    def _error(self, function: str, status: int) -> FmuError:
        said = "; ".join(message.text for message in self.log[-3:])
        error = FmuError(f"{self.name}: {function} returned status {status}: {said}")
        error.status = status
        return error

    def reader(self, names: Sequence[str]) -> Port:
        """A port that fetches these variables (all of one type) into its buffer."""
        return self._port("fmi2Get", names)

    def writer(self, names: Sequence[str]) -> Port:
        """A port that hands its buffer to these variables (all of one type)."""
        return self._port("fmi2Set", names)

    def _port(self, verb: str, names: Sequence[str]) -> Port:
        unknown = [name for name in names if name not in self.fmu.variables]
        if unknown:
            raise KeyError(f"{self.name} has no variable {', '.join(unknown)}")
        variables = [self.fmu.variables[name] for name in names]
        kinds = {"Integer" if v.type == "Enumeration" else v.type for v in variables} or {"Real"}
        if len(kinds) != 1:
            raise ValueError(f"variables of several types in one port: {names}")
        kind = kinds.pop()
        size, c_type = len(names), TYPES[kind]
        references = (ctypes.c_uint * size)(*(v.valueReference for v in variables))
        call = partial(self.prepared, verb + kind, references, ctypes.c_size_t(size))
        return Port(tuple(names), call, (c_type * size)())

    def get(self, *names: str) -> list[float]:
        """Values by name."""
        return [self.reader([name]).read()[0] for name in names]

    def set(self, **values: float | str) -> None:
        """Sets variables by name; an enumeration also by the name of its item."""
        for name, value in values.items():
            port = self.writer([name])
            port.values[0] = self._item(name, value) if isinstance(value, str) else value
            port.write()

    def _item(self, name: str, item: str) -> int:
        items = {i.name: int(i.value) for i in self.fmu.variables[name].declaredType.items}
        if item not in items:
            raise KeyError(f"{name} is one of {', '.join(items)}, not {item}")
        return items[item]

    def start(self, start_time: float = 0.0) -> None:
        """From instantiated to stepping, for an FMU on its own."""
        self.fmi.setupExperiment(startTime=start_time)
        self.fmi.enterInitializationMode()
        self.fmi.exitInitializationMode()

    def close(self) -> None:
        """Frees the instance; the library is unloaded."""
        self.fmi.freeInstance()

    def __enter__(self) -> Slave:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


class Port:
    """Some variables of one instance and the buffer their values travel in."""

    fetch: Callable[[], None]
    """Fetches all values into the buffer."""
    write: Callable[[], None]
    """Hands the buffer to the FMU."""

    def __init__(self, names: tuple[str, ...], prepare: Callable[[Any], Callable[[], None]], values: Any) -> None:
        """`prepare` makes a call from a buffer; of a port, only its direction is meaningful."""
        self.names, self._prepare = names, prepare
        self.values = values

    @property
    def values(self) -> Any:
        """The buffer."""
        return self._values

    @values.setter
    def values(self, values: Any) -> None:
        self._values = values
        self.fetch = self.write = self._prepare(values) if self.names else lambda: None

    def read(self) -> list[float]:
        """Fetches all values and returns them as a list."""
        self.fetch()
        return self._values[:]
