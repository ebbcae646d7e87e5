"""rust-fmi's `fmi` crate as an independent importer: it reads the descriptions, loads the FMUs and steps them.

The program (`tests/judges/rust-fmi`) makes the calls that our harness makes, in the same order, so the trajectories are equal
to the bit; and half way through it serialises both states, gives the bytes to two new instances and goes on with them,
which must not show.

What fmi 0.8 cannot read, and the descriptions therefore leave out although it is legal: `canHandleMultipleSet...`,
`<Annotations>` in a ScalarVariable, `xmlns:xsi` on the root. It knows no units, ranges and enumeration items: others
judge those.
"""

from __future__ import annotations

import subprocess
import zipfile
from pathlib import Path

import numpy as np
import pytest

from .judges import different, read_table
from .judges.rust_fmi import UnavailableError, program
from .support.contract import CONTROLLERS, FMUS
from .support.exchange import Grasp, Model, fixed_steps
from .support.harness import CoSimulation, Fmu

STEP, STEPS = 1e-4, 1000


@pytest.fixture(scope="module")
def judge() -> Path:
    try:
        return program()
    except UnavailableError as reason:
        pytest.skip(f"{reason}: not checked that rust-fmi reads the FMUs and gives the same trajectories")


@pytest.mark.parametrize("coupling", CoSimulation.COUPLINGS)
@pytest.mark.parametrize("controller", CONTROLLERS)
def test_rust_fmi_gives_the_same_bits(controller: str, coupling: str, judge: Path, fmus: dict[str, Fmu]) -> None:
    pair = (fmus["DualArmPlant"], fmus[controller])
    paths = [str(fmu.path) for fmu in pair]
    done = subprocess.run(
        [judge, *paths, coupling.replace("_", "-"), repr(STEP), str(STEPS)],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    theirs = read_table(done.stdout)
    with CoSimulation(pair, coupling) as grasp:
        ours = grasp.run(STEPS * STEP, STEP, [name for fmu in pair for name in fmu.names("output", "Real")])
    assert set(theirs.signals) == set(ours.signals)
    assert np.array_equal(theirs.time, ours.time)
    assert np.ptp(ours["theta1"]) > 1e-3  # something happened
    assert different(theirs, ours) == []


@pytest.mark.parametrize("controller", CONTROLLERS)
def test_rust_fmi_integrates_with_the_same_bits(controller: str, judge: Path, fmus: dict[str, Fmu]) -> None:
    """By model exchange as one system: the states, rates and events of our own host."""
    pair, size, steps = (fmus["DualArmPlant"], fmus[controller]), 5e-6, 400
    command = [judge, *(str(fmu.path) for fmu in pair), "exchange", repr(size), str(steps)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    theirs = read_table(done.stdout)
    with Model(pair[0]) as plant, Model(pair[1]) as law:
        outputs = [model.reader(model.fmu.names("output", "Real")) for model in (plant, law)]
        rows: list[list[float]] = []
        fixed_steps(
            Grasp(plant, law), size, steps, lambda t: rows.append([t, *(v for port in outputs for v in port.read())])
        )
    names = ["time", *(name for port in outputs for name in port.names)]
    assert ["time", *theirs.signals] == names
    ours = np.array(rows)
    assert np.ptp(ours[:, names.index("theta1")]) > 1e-6  # something happened
    assert np.array_equal(theirs.time, ours[:, 0])
    for i, name in enumerate(names[1:], 1):
        assert np.array_equal(theirs[name], ours[:, i]), name


@pytest.mark.parametrize("name", FMUS)
def test_descriptions_leave_out_what_rust_fmi_refuses(name: str, fmus: dict[str, Fmu]) -> None:
    with zipfile.ZipFile(fmus[name].path) as archive:
        text = archive.read("modelDescription.xml").decode()
    for legal in ("canHandleMultipleSet", "<Annotations", "xmlns:xsi"):
        assert legal not in text
