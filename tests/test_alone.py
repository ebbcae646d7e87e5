"""Each FMU on its own, through fmpy: life cycle, direct outputs, refusals."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from fmpy import simulate_fmu

from .support.contract import ACTUATORS, COMMANDS, CONTRACT, DIRECT, FMUS, INSTRUMENTS, MEASURED, PLANT
from .support.harness import Fmu, FmuError
from .support.paths import description

each_fmu = pytest.mark.parametrize("name", FMUS)


# --- Life cycle ------------------------------------------------------------------------------------------------------


@each_fmu
def test_simulate_fmu(name: str, fmus: dict[str, Fmu]) -> None:
    """Runs to the end, at rest where nothing drives the plant."""
    result = simulate_fmu(str(fmus[name].path), stop_time=0.01, step_size=1e-4, output_interval=1e-3)
    assert result["time"][-1] == pytest.approx(0.01)
    assert all(np.all(np.isfinite(result[column])) for column in result.dtype.names)
    if name == PLANT:
        assert np.all(result["theta1"] == 0.0)
        assert np.all(result["y_object"] == 0.05)


@each_fmu
def test_reset_and_several_instances(name: str, fmus: dict[str, Fmu]) -> None:
    """A reset instance and a second one in the same process do what the first one did, to the bit."""
    inputs = {row.name: 0.01 * (index + 1) for index, row in enumerate(CONTRACT[name]) if row.causality == "input"}
    outputs = [row.name for row in CONTRACT[name] if row.causality == "output" and row.type == "Real"]

    def trajectory(slave: Any) -> list[float]:
        slave.start()
        slave.set(**inputs)
        for i in range(5):
            slave.step(i * 1e-4, 1e-4, 1)
        return slave.get(*outputs)

    with fmus[name].instantiate("one") as one, fmus[name].instantiate("two") as two:
        first = trajectory(one)
        assert trajectory(two) == first
        one.fmi.terminate()
        one.fmi.reset()
        assert trajectory(one) == first


# --- What follows inputs at once -------------------------------------------------------------------------------------


@each_fmu
def test_outputs_follow_exactly_the_declared_inputs_at_once(name: str, fmus: dict[str, Fmu]) -> None:
    """Each input changed alone moves the outputs that declare it, and no other, without a step."""
    inputs = [row.name for row in CONTRACT[name] if row.causality == "input"]
    outputs = [row.name for row in CONTRACT[name] if row.causality == "output" and row.type == "Real"]
    with fmus[name].instantiate() as slave:
        slave.start()
        slave.set(**{variable: 0.003 * (i + 1) for i, variable in enumerate(inputs)})
        slave.step(0.0, 1e-4, 1)  # every state away from zero, so that no product hides a dependency
        before = dict(zip(outputs, slave.get(*outputs)))
        moved: dict[str, set[str]] = {output: set() for output in outputs}
        for variable in inputs:
            (value,) = slave.get(variable)
            slave.set(**{variable: value + 0.001})
            for output, new in zip(outputs, slave.get(*outputs)):
                if new != before[output]:
                    moved[output].add(variable)
            slave.set(**{variable: value})
        assert dict(zip(outputs, slave.get(*outputs))) == before
    declared = direct_dependencies(fmus[name])
    for output in outputs:
        if output in DIRECT[name] or name == PLANT:
            assert moved[output] == DIRECT[name].get(output, set()), output
        assert moved[output] <= declared[output], output
    for command in set(COMMANDS) & set(outputs):
        assert "theta1_ref" in moved[command], command
        assert moved[command] & set(MEASURED), command


def direct_dependencies(fmu: Fmu) -> dict[str, set[str]]:
    """What ModelStructure/Outputs says of inputs."""
    return {
        unknown.variable.name: {known.name for known in unknown.dependencies if known.causality == "input"}
        for unknown in fmu.description.outputs
    }


# --- Refusals --------------------------------------------------------------------------------------------------------


@each_fmu
@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_inputs_that_are_no_numbers_are_refused(name: str, value: float, fmus: dict[str, Fmu]) -> None:
    """An error, a message in a declared category, the old value kept, and the instance goes on."""
    variable = next(row.name for row in CONTRACT[name] if row.causality == "input")
    with fmus[name].instantiate(logging=True) as slave:
        slave.start()
        slave.set(**{variable: 0.25})
        with pytest.raises(FmuError, match="status 3"):
            slave.set(**{variable: value})
        categories = {category.get("name") for category in description(name).iterfind("LogCategories/Category")}
        assert slave.log
        assert slave.log[-1].category in categories
        assert variable in slave.log[-1].text
        assert slave.get(variable) == [0.25]
        slave.step(0.0, 1e-4, 1)


@pytest.mark.parametrize(
    ("name", "parameter", "value"),
    [
        (PLANT, "EI1", 0.0),
        (PLANT, "EI2", -1.0),
        (PLANT, "rho1", math.nan),
        (PLANT, "l", 0.0),
        (PLANT, "M", -0.1),
        (PLANT, "J2", 0.0),
        (PLANT, "kelvin_voigt", -1e-3),
        (PLANT, "order", 3),
        (PLANT, "order", 25),
        (PLANT, "actuator_model", 99),
        ("NabfcController", "EI1", 0.0),
        ("NabfcController", "shear_rate_bandwidth", -1.0),
        ("PdsController", "EI2", math.inf),
        ("PdController", "l", 0.0),
        (INSTRUMENTS, "theta1_noise", 1e-4),  # without a sample time
        (INSTRUMENTS, "y_object_delay", 1e-3),
        (INSTRUMENTS, "tip_shear1_sample_time", 1e-9),
        (INSTRUMENTS, "sample_time", -1.0),
        (INSTRUMENTS, "noise_scale", math.nan),
        (INSTRUMENTS, "seed", -1),
        (INSTRUMENTS, "sensor_profile", 5),
        (ACTUATORS, "u_cmd_delay", 1e-3),
        (ACTUATORS, "tau1_cmd_rate_limit", -1.0),
        (ACTUATORS, "k_r1", 0.0),
        (ACTUATORS, "m_l2", 0.1),
    ],
)
def test_bad_parameters_are_refused(name: str, parameter: str, value: float, fmus: dict[str, Fmu]) -> None:
    """When set or at the latest on leaving initialisation; the message names the parameter."""
    with fmus[name].instantiate(logging=True) as slave:
        with pytest.raises(Exception, match=r"fmi2|status"):  # noqa: PT012 (FmuError or fmpy's own, from either call)
            slave.set(**{parameter: value})
            slave.start()
        assert any(parameter in message.text for message in slave.log)


@each_fmu
@pytest.mark.parametrize("step", [0.0, -1e-4, math.nan, math.inf])
def test_bad_steps_are_refused_and_harmless(name: str, step: float, fmus: dict[str, Fmu]) -> None:
    with fmus[name].instantiate() as slave:
        slave.start()
        slave.step(0.0, 1e-4, 1)
        outputs = fmus[name].names("output", "Real")
        before = slave.get(*outputs)
        with pytest.raises(FmuError):
            slave.step(1e-4, step, 1)
        assert slave.get(*outputs) == before
        slave.step(1e-4, 1e-4, 1)


@each_fmu
def test_foreign_guid_is_refused(name: str, fmus: dict[str, Fmu]) -> None:
    with pytest.raises(Exception, match="instantiate"):
        fmus[name].instantiate(guid="{00000000-0000-0000-0000-000000000000}")


def test_guid_decides_which_controller_it_is(fmus: dict[str, Fmu]) -> None:
    """One library serves three FMUs; each answers only to its own GUID."""
    pd, pds = fmus["PdController"], fmus["PdsController"]
    with pytest.raises(Exception, match="instantiate"):
        fmus[PLANT].instantiate(guid=pd.description.guid)
    assert pd.description.guid != pds.description.guid
