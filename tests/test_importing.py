"""The guide to importing is true: the numbers to compare with, the wiring by port number."""

from __future__ import annotations

import re

import numpy as np
import pytest

from .conftest import ClosedLoop
from .support.contract import COMMANDS, CONTROLLERS, MEASURED, MOMENT_RATES, PLANT
from .support.harness import Fmu
from .support.paths import ROOT

GUIDE = (ROOT / "docs" / "importing.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("coupling", ["gauss_seidel", "jacobi"])
def test_numbers_to_compare_with(coupling: str, closed_loop: ClosedLoop) -> None:
    """With and without delay, to the digits shown."""
    table = GUIDE.split("<!-- check")[1].split("<!-- end")[0]
    rows = [[float(x) for x in re.findall(r"\d+\.\d+", line)] for line in table.splitlines() if " s |" in line]
    assert len(rows) == 3
    signals = ("contact_force1", "contact_force2", "theta1")
    run = closed_loop("NabfcController", 1.0, coupling=coupling, record=signals, every=1000)
    for time, *shown in rows:
        i = int(np.argmin(np.abs(run.time - time)))
        assert run.time[i] == pytest.approx(time, abs=1e-9)
        simulated = [run["contact_force1"][i], run["contact_force2"][i], np.degrees(run["theta1"][i])]
        assert shown == pytest.approx(simulated, abs=1e-3)


@pytest.mark.parametrize("controller", CONTROLLERS)
def test_ports_wire_by_number(controller: str, fmus: dict[str, Fmu]) -> None:
    plant, other = fmus[PLANT], fmus[controller]
    assert plant.names("output", "Real")[:12] == other.names("input", "Real")[:12] == list(MEASURED)
    assert other.names("output", "Real")[:3] == plant.names("input", "Real")[:3] == list(COMMANDS)


def test_the_moments_rates_are_the_ports_that_the_guide_says(fmus: dict[str, Fmu]) -> None:
    said = re.search(r"are outputs (\d+) and (\d+) of the plant and inputs (\d+) and (\d+) of every", GUIDE)
    assert said
    *outputs, first, second = map(int, said.groups())
    assert tuple(fmus[PLANT].names("output")[port - 1] for port in outputs) == tuple(MOMENT_RATES)
    for controller in CONTROLLERS:
        inputs = fmus[controller].names("input")
        assert (inputs[first - 1], inputs[second - 1]) == tuple(MOMENT_RATES), controller


def test_the_guide_shows_the_ports_in_their_order() -> None:
    ports = {}
    for port, kind in re.findall(r"\| (\d+) \| `(\w+)`", GUIDE.split("**Wiring.**")[1].split("**Communication")[0]):
        ports.setdefault(kind, int(port))
    assert ports == {name: i for names in (MEASURED, COMMANDS) for i, name in enumerate(names, 1)}


def test_the_modelica_text_connects_everything() -> None:
    connected = re.findall(r"connect\((\w+)\.(\w+), (\w+)\.(\w+)\);", GUIDE)
    expected = [("plant", name, "controller", name) for name in (*MEASURED, *MOMENT_RATES)]
    expected += [("controller", name, "plant", name) for name in COMMANDS]
    assert connected == expected
