"""Fixtures: the packaged FMUs, unpacked once, and closed-loop runs that several tests look at."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from .support.browser import browser  # noqa: F401 (a fixture)
from .support.report import comparison, report  # noqa: F401 (fixtures)
from .support.scenario import run  # noqa: F401 (a fixture)
from .support.harness import CoSimulation, Fmu, Result
from .support.paths import ROOT, fmu_path
from .support.tool import verification  # noqa: F401 (a fixture)


# Cargo sets it for what it starts, and the tool takes it for the place of the sources. Users start the tool themselves.
os.environ.pop("CARGO_MANIFEST_DIR", None)


class Fmus(dict[str, Fmu]):
    """The FMUs by name, each unpacked when it is first asked for."""

    def __missing__(self, name: str) -> Fmu:
        self[name] = Fmu(fmu_path(name))
        return self[name]


@pytest.fixture(scope="session")
def fmus() -> Iterator[dict[str, Fmu]]:
    """The FMUs by name, each unpacked once."""
    opened = Fmus()
    yield opened
    for fmu in opened.values():
        fmu.close()


@pytest.fixture(scope="session")
def plant(fmus: dict[str, Fmu]) -> Fmu:
    """The plant."""
    return fmus["DualArmPlant"]


@pytest.fixture(scope="session")
def oracle() -> dict[str, Any]:
    """The exact values, see `tests/oracle`."""
    return json.loads((ROOT / "dualarm" / "data" / "verify" / "values.json").read_text(encoding="utf-8"))


ClosedLoop = Callable[..., Result]


@pytest.fixture(scope="session")
def closed_loop(fmus: dict[str, Fmu]) -> ClosedLoop:
    """Runs plant and controller; equal requests are run once. Settings are start values by name."""
    done: dict[tuple[Any, ...], Result] = {}

    def run(
        controller: str,
        stop: float,
        *,
        step: float = 1e-4,
        coupling: str = "gauss_seidel",
        record: tuple[str, ...],
        every: int = 1,
        **settings: float | str,
    ) -> Result:
        key = (controller, stop, step, coupling, record, every, tuple(sorted(settings.items())))
        if key not in done:
            with CoSimulation([fmus["DualArmPlant"], fmus[controller]], coupling) as grasp:
                grasp.set(**settings)
                done[key] = grasp.run(stop, step, record, every)
        return done[key]

    return run
