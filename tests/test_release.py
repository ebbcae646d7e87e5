"""The release layout of `dualarm package --cross-check`, as the FMI cross-check rules 4.1 want it (section 9.1, appendix B).

fmpy has the validator that the cross-check repository runs over a vendor's FMUs, and is the other tool that computes the
reference solutions again.
"""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import numpy as np
import pytest
from fmpy import simulate_fmu
from fmpy.cross_check.validate_vendor_repo import read_csv, validate_repo
from fmpy.util import read_ref_opt_file

from .support.capabilities import input_slopes
from .support.contract import FMUS
from .support.harness import Fmu
from .support.paths import DIST, fmu_path

RELEASE = DIST / "release"


def released(name: str) -> Path:
    """Folder of a released FMU, which must be the packaged one."""
    folders = sorted(RELEASE.glob(f"fmus/2.0/cs/*/*/*/{name}"))
    if not folders or (folders[-1] / f"{name}.fmu").read_bytes() != fmu_path(name).read_bytes():
        pytest.fail(f"{name} is not released: run `cargo run --release -- package --cross-check`", pytrace=False)
    return folders[-1]


def test_vendor_validator_accepts_it(tmp_path: Path) -> None:
    """And it does look: a missing option, a foreign variable and time going back are found."""
    for name in FMUS:
        released(name)
    fmus, results, problems = validate_repo(str(RELEASE))
    assert (fmus, results, problems) == (len(FMUS), 0, [])

    copy = tmp_path / "copy"
    shutil.copytree(RELEASE, copy)
    plant, *controllers = (copy / released(name).relative_to(RELEASE) for name in FMUS)
    options = plant / f"{plant.name}_ref.opt"
    options.write_text(options.read_text().replace("RelTol", "Tolerance"))
    for folder, old, new in ((controllers[0], '"u_cmd"', '"x"'), (controllers[1], "\n0.002,", "\n0.0005,")):
        reference = folder / f"{folder.name}_ref.csv"
        reference.write_text(reference.read_text().replace(old, new, 1))
    assert len(validate_repo(str(copy))[2]) == 3


@pytest.mark.parametrize("name", FMUS)
def test_files_keep_to_the_rules(name: str, fmus: dict[str, Fmu]) -> None:
    folder, fmu = released(name), fmus[name]
    platform, tool, version = folder.parts[-4:-1]
    assert platform in ("linux64", "linux32", "win64", "win32", "darwin64", "aarch64-linux", "aarch64-darwin")
    assert f"{tool} {version}" == fmu.description.generationTool
    files = {f"{name}.fmu", f"{name}_in.csv", f"{name}_ref.csv", f"{name}_ref.opt", "README.md"}
    assert {path.name for path in folder.iterdir()} == files
    options = read_ref_opt_file(folder / f"{name}_ref.opt")
    for suffix, causality in (("in", "input"), ("ref", "output")):
        path = folder / f"{name}_{suffix}.csv"
        assert path.stat().st_size < 1e6
        header, *rows = path.read_text().splitlines()
        assert re.fullmatch(r'"time"(,"[^"]+")+', header), "names in double quotes"
        number = r"-?\d+(\.\d+)?(e-?\d+)?"
        assert all(re.fullmatch(f"{number}(,{number})+", row) for row in rows), "numbers of C, no comma at the end"
        table = read_csv(path, fmu.names(causality))
        assert table["time"][0] == options["StartTime"]
        assert table["time"][-1] == options["StopTime"]
        if suffix == "in":
            assert list(table.dtype.names[1:]) == fmu.names("input", "Real"), "the file matches the description"
        else:
            assert all(np.ptp(table[column]) > 0 for column in table.dtype.names), "nothing is told by a constant"
    assert len(header.split(",")) <= 11, "at most ten variables are recommended"
    page = (folder / "README.md").read_text(encoding="utf-8")
    assert all(f"`{column.strip(chr(34))}`" in page for column in header.split(",")[1:])


def deviations(reference: np.ndarray, times: np.ndarray, signals: dict[str, np.ndarray]) -> dict[str, float]:
    """Largest deviation of each signal."""
    rows = np.searchsorted(times, reference["time"] - 1e-9)
    assert np.max(np.abs(times[rows] - reference["time"])) < 1e-9
    return {name: np.max(np.abs(signals[name][rows] - reference[name])) for name in reference.dtype.names[1:]}


@pytest.mark.parametrize("name", FMUS)
def test_fmpy_computes_the_reference_again(name: str) -> None:
    """From the input file and the options. fmpy holds the inputs over each step, and reads outputs before it hands over
    the inputs of the same instant: half a step late in one case, a whole one in the other. So it may be off by what the
    signal moves in two steps where it is fastest.
    """
    folder = released(name)
    options = read_ref_opt_file(folder / f"{name}_ref.opt")
    reference = read_csv(folder / f"{name}_ref.csv")
    result = simulate_fmu(
        str(folder / f"{name}.fmu"),
        start_time=options["StartTime"],
        stop_time=options["StopTime"],
        step_size=options["StepSize"],
        output_interval=options["StepSize"],
        input=read_csv(folder / f"{name}_in.csv"),
        output=list(reference.dtype.names[1:]),
    )
    steps_per_row = options["OutputIntervalLength"] / options["StepSize"]
    for column, error in deviations(reference, result["time"], {k: result[k] for k in result.dtype.names}).items():
        assert error < 2 / steps_per_row * np.max(np.abs(np.diff(reference[column]))), column


@pytest.mark.parametrize("name", FMUS)
def test_reference_is_exact_with_interpolated_inputs(name: str, fmus: dict[str, Fmu]) -> None:
    """With the slopes of the inputs, as the README says, the same solution but for the rounding of slopes and times.
    (`simulate_fmu` takes the slope before a corner for the step after it, so this is a loop of its own.)
    """
    folder, fmu = released(name), fmus[name]
    options = read_ref_opt_file(folder / f"{name}_ref.opt")
    reference, table = (read_csv(folder / f"{name}_{suffix}.csv") for suffix in ("ref", "in"))
    inputs, outputs = table.dtype.names[1:], reference.dtype.names[1:]
    step, count = options["StepSize"], round(options["StopTime"] / options["StepSize"])
    times = np.arange(count + 1) * step
    values = np.array([np.interp(times, table["time"], table[column]) for column in inputs]).T
    slopes = np.diff(values, axis=0) / step
    rows = np.empty((count + 1, len(outputs)))
    with fmu.instantiate() as slave:
        put, get, tilt = slave.writer(inputs), slave.reader(outputs), input_slopes(slave, inputs)
        put.values[:] = values[0]
        put.write()
        slave.start()
        for k in range(count + 1):
            put.values[:] = values[k]
            put.write()
            rows[k] = get.read()
            if k < count:
                tilt.values[:] = slopes[k]
                tilt.write()
                slave.step(times[k], step, 1)
    for column, error in deviations(reference, times, dict(zip(outputs, rows.T))).items():
        assert error < 1e-8 * np.max(np.abs(reference[column])), column


def test_references_tell_their_story(fmus: dict[str, Fmu]) -> None:
    """Static balance of the plant under hub torques of 0.1 N.m and no force: 0.5 N = 0.1 N.m / 0.2 m at both tips. The
    controller's errors: the target moves with the reference, eq. (16), and the grasp follows.
    """
    assert fmus  # the FMUs are there
    plant = read_csv(released("DualArmPlant") / "DualArmPlant_ref.csv")
    before = np.searchsorted(plant["time"], 0.6)
    for i in (1, 2):
        assert plant[f"contact_force{i}"][before] == pytest.approx(0.5, rel=0.02)
    pushed = np.searchsorted(plant["time"], 0.65)
    change = [plant[f"contact_force{i}"][pushed] - plant[f"contact_force{i}"][before] for i in (1, 2)]
    assert change[0] * change[1] < 0

    nabfc = read_csv(released("NabfcController") / "NabfcController_ref.csv")
    at = {time: np.searchsorted(nabfc["time"], time) for time in (0.55, 0.7, 1.0)}
    target_step = 0.1 * 0.2**2 / 3 * 2 / 0.115  # of theta2_d, eq. (16)
    assert abs(nabfc["e2"][at[0.55]]) < 0.02 * target_step
    assert abs(nabfc["e2"][at[0.7]]) > 0.05 * target_step
    assert abs(nabfc["e2"][at[1.0]]) < 0.05 * target_step
