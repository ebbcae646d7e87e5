"""A plant whose states in model exchange are those of another order: `dualarm package --plant-order`.

It compiles the plant twice, there and back, so it runs only where it is asked for:

    PLANT_ORDER=12 cargo xtask test --python -- tests/test_plant_order.py
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from fmpy import read_model_description, simulate_fmu
from fmpy.fmi1 import FMICallException
from fmpy.validation import validate_fmu

from .support.exchange import Model
from .support.slave import Fmu
from .support.tool import dualarm

ORDER = os.environ.get("PLANT_ORDER", "")
pytestmark = pytest.mark.skipif(not ORDER, reason="compiles the plant twice: set PLANT_ORDER, to 12 say")
PLANT = "DualArmPlant.fmu"


def package(out: Path, *options: str) -> None:
    """All FMUs of this machine's platform, to a folder."""
    done = dualarm("package", "--out", str(out), "--platform", "linux64", *options)
    assert done.returncode == 0, done.stderr


def test_model_exchange_at_another_order(plant: Fmu, tmp_path: Path) -> None:
    """Its states are those of the order, its solution is that of co-simulation, and co-simulation is free as ever."""
    package(tmp_path / "other", "--plant-order", ORDER)
    # The packaging program that is left behind is the usual one again.
    package(tmp_path / "usual")
    path = str(tmp_path / "other" / PLANT)
    assert validate_fmu(path) == []
    common: dict[str, Any] = dict(
        stop_time=0.02, output_interval=1e-4, output=["theta1", "root_moment1"], start_values={"tau1_cmd": 0.05}
    )
    stepped = simulate_fmu(path, fmi_type="CoSimulation", **common)
    solved = simulate_fmu(path, fmi_type="ModelExchange", relative_tolerance=1e-10, record_events=False, **common)
    for name in common["output"]:
        error = np.abs(np.array(solved[name]) - stepped[name]).max() / np.abs(np.array(stepped[name])).max()
        assert error < 1e-4, name
    other = Fmu(path)
    assert other.description.numberOfContinuousStates == 4 * int(ORDER) + 10
    assert other.variables["order"].start == ORDER
    for order in (8, int(ORDER)):
        with other.instantiate() as slave:
            slave.set(order=order)
            slave.start()
            slave.step(0.0, 1e-3, 1)
    with Model(other) as model:
        model.set(order=5 if ORDER != "5" else 6)
        with pytest.raises(FMICallException):
            model.start()
    other.close()
    assert read_model_description(str(tmp_path / "usual" / PLANT)).guid == plant.description.guid
