"""The FMUs for model exchange: alone with FMPy's solver, wired into one system by a host of our own, events, the Jacobian."""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from fmpy import simulate_fmu
from fmpy.fmi1 import FMICallException

from .oracle import exchange as monolith
from .support import exponential
from .support.contract import MEASURED
from .support.exchange import Grasp, Model, integrate
from .support.harness import Fmu
from .support.paths import description, fmu_path

CONTROLLERS = ("NabfcController", "PdsController", "PdController")
# The monolithic solution has the paper's law; its gains are the FMU's defaults.
PAPER = {"NabfcController": {"law": "paper"}, "PdsController": {}, "PdController": {}}


@pytest.fixture(scope="module")
def oracle() -> dict[str, Any]:
    """The monolithic solutions."""
    return json.loads(monolith.FILE.read_text(encoding="utf-8"))


@pytest.fixture
def plant_model(plant: Fmu) -> Iterator[Model]:
    """The plant for model exchange, running."""
    with Model(plant) as model:
        model.start()
        yield model


@pytest.mark.parametrize("name", ("DualArmPlant", *CONTROLLERS))
def test_the_description_offers_both_interfaces(name: str) -> None:
    """Each state has a derivative, in the order of <Derivatives>; measured outputs of the plant follow no input at once."""
    root = description(name)
    assert [e.tag for e in root if e.tag in ("ModelExchange", "CoSimulation")] == ["ModelExchange", "CoSimulation"]
    assert root.find("ModelExchange").get("providesDirectionalDerivative") == "true"
    variables = root.findall("ModelVariables/ScalarVariable")
    derivatives = [int(unknown.get("index")) for unknown in root.findall("ModelStructure/Derivatives/Unknown")]
    states = [int(variables[index - 1].find("Real").get("derivative")) for index in derivatives]
    assert states == sorted(set(states)) and len(states) > 10
    initial = {int(unknown.get("index")) for unknown in root.findall("ModelStructure/InitialUnknowns/Unknown")}
    assert initial >= {*states, *derivatives}
    inputs = {i for i, v in enumerate(variables, 1) if v.get("causality") == "input"}
    for unknown in root.findall("ModelStructure/Outputs/Unknown"):
        variable = variables[int(unknown.get("index")) - 1].get("name")
        if name == "DualArmPlant" and variable in MEASURED:
            assert not inputs & set(map(int, unknown.get("dependencies").split())), variable


def test_fmpy_integrates_the_plant_with_cvode() -> None:
    """Against co-simulation, which is exact, over 0.2 s: what CVode is off falls with its tolerance, for forces, too.

    Each step may err by the tolerance times a state's nominal value, 0.1 sqrt(J); a tip force is about 100
    N/sqrt(J) times the bending modes, of which the first are hardly damped, so the errors of thousands of steps
    stay. In the first 2 ms, in which the forces are below 1e-4 N, a tolerance of 1e-9 leaves them 7 % off.
    """
    stop, rows = 0.2, 1000
    torque = {"tau1_cmd": 0.05, "tau2_cmd": -0.05}
    # What a tolerance of 1e-11 leaves, in parts of the largest value.
    smooth = dict.fromkeys(("theta1", "theta2", "y_object", "supplied_energy"), 1e-9)
    forces = dict.fromkeys(("tip_shear1", "tip_shear2", "contact_force1", "contact_force2"), 2e-5)
    limits = {**smooth, "energy": 1e-6, "root_moment1": 1e-6, "root_moment2": 1e-6, **forces}
    common: dict[str, Any] = dict(
        filename=str(fmu_path("DualArmPlant")),
        stop_time=stop,
        output=list(limits),
        start_values=torque,
        output_interval=stop / rows,
    )
    exact = simulate_fmu(fmi_type="CoSimulation", **common)
    assert len(exact) == rows + 1

    def errors(tolerance: float) -> dict[str, float]:
        # CVode takes at most 500 steps from one row to the next.
        found = simulate_fmu(
            fmi_type="ModelExchange", solver="CVode", relative_tolerance=tolerance, record_events=False, **common
        )
        assert np.array(found["time"]) == pytest.approx(np.array(exact["time"]), abs=1e-12)
        return {n: np.abs(np.array(found[n]) - exact[n]).max() / np.abs(np.array(exact[n])).max() for n in limits}

    coarse, fine = errors(1e-9), errors(1e-11)
    for name, limit in limits.items():
        assert fine[name] < limit, name
        # A hundredth of the tolerance, with an order of 4 or 5: at least ten times better.
        assert fine[name] < 0.1 * coarse[name] or fine[name] < 1e-12, name


@pytest.mark.parametrize("own", ({}, {"rate_source": 2}, {"law": 1, "rate_source": 2}), ids=str)
def test_fmpy_integrates_the_adaptive_laws_with_cvode(own: dict[str, int]) -> None:
    """A law alone, at inputs that stand still but for what it estimates: its samples tend to it with order 1.

    Until 18 ms: at 19.9 ms the root-strain law takes hub 1 for twice as heavy, where its slope has a kink, and the extrapolation
    would be of first order in the row that follows.
    """
    names, rows = ["tau1_cmd", "tau2_cmd", "u_cmd"], 18
    start = {"theta1": 0.01, "tip_shear1": -0.1, "root_moment1": 0.02, **own}
    common: dict[str, Any] = dict(
        filename=str(fmu_path("NabfcController")), stop_time=0.018, output=names, start_values=start
    )

    def run(interval: float, **options: Any) -> np.ndarray:
        # FMPy's communication step is the interval of its rows.
        found = simulate_fmu(output_interval=interval, **common, **options)
        return np.array([found[name] for name in names])[:, :: (len(found) - 1) // rows]

    solver = {"fmi_type": "ModelExchange", "solver": "CVode", "relative_tolerance": 1e-10, "record_events": False}
    solved = run(1e-3, **solver)
    coarse, fine = (run(step, fmi_type="CoSimulation") for step in (1e-4, 5e-5))
    # What is left after the extrapolation is of second order.
    left, scale = np.abs(2 * fine - coarse - solved).max(axis=1), np.abs(coarse - fine).max(axis=1)
    assert np.all(left < 0.05 * scale + 1e-7 * np.abs(solved).max(axis=1)), left / scale


@pytest.mark.parametrize("name", ("DualArmPlant", *CONTROLLERS))
def test_the_jacobian_is_that_of_the_derivatives_and_outputs(name: str, fmus: dict[str, Fmu]) -> None:
    """Directional derivatives by states and inputs against difference quotients, at a state that is not at rest."""
    random = np.random.default_rng(19)
    with Model(fmus[name]) as model:
        model.start()
        inputs = fmus[name].names("input", "Real")
        port, outputs = model.writer(inputs), model.reader(fmus[name].names("output", "Real"))
        nominal = np.array([fmus[name].variables[n].nominal or 1.0 for n in inputs], dtype=float)
        # Well inside all limits.
        x0, u0 = model.x + 1e-3 * model.nominals * random.uniform(-1, 1, model.size), 1e-3 * nominal

        def value(x: np.ndarray, u: np.ndarray) -> np.ndarray:
            model.x, port.values[:] = x, u
            port.write()
            return np.concatenate([model.rates(), outputs.read()])

        for _ in range(3):
            dx, du = model.nominals * random.uniform(-1, 1, model.size), nominal * random.uniform(-1, 1, len(inputs))
            # Sums of the estimates grow with the fourth power of small signals.
            h = 2e-7
            quotient = (value(x0 + h * dx, u0 + h * du) - value(x0 - h * dx, u0 - h * du)) / (2 * h)
            here = value(x0, u0)
            unknowns = [*model.derivatives, *outputs.names]
            exact = model.jacobian(unknowns, model.states) @ dx + model.jacobian(unknowns, inputs) @ du
            # Truncation h^2, and rounding of values divided by h.
            scale = np.abs(quotient) + np.abs(here) + np.abs(exact).max() * 1e-6
            assert np.abs(exact - quotient) / scale == pytest.approx(0, abs=1e-6)


@pytest.mark.parametrize("case", ("nabfc_saturated", "pds", "pds_saturated", "pd", "pd_saturated"))
def test_wired_into_one_system_the_grasp_is_the_monolithic_solution(
    case: str, fmus: dict[str, Fmu], oracle: dict[str, Any]
) -> None:
    """No communication step: both under one solver for 50 ms, events located, to 1e-9 of each output's largest value.

    PD and PDS by a solver that lives by the FMUs' Jacobian; NABFC, whose Jacobian has hundreds of rows, by an
    explicit one. It passes its limit late, at 48 ms.
    """
    solution = oracle[case]
    name, rows = solution["controller"], solution["at"]
    with Model(fmus["DualArmPlant"]) as arms, Model(fmus[name]) as controller:
        grasp = Grasp(arms, controller)
        own = {**PAPER[name], "lambda1_ref": solution["lambda1_ref"], "theta1_ref": solution["theta1_ref"]}
        for model, settings in ((arms, {}), (controller, own)):
            model.set(**{k: v for k, v in {**solution["settings"], **settings}.items() if k in model.fmu.variables})
        names, found = monolith.OUTPUTS, []
        outputs = arms.reader(names)

        def at(_t: float, z: np.ndarray) -> None:
            grasp.put(z)
            found.append(outputs.read())

        times = [row["t"] for row in rows]
        if name == "NabfcController":
            nominal = np.concatenate([arms.nominals, controller.nominals])
            options = {"rtol": 1e-11, "atol": 1e-15 * nominal}
            z = grasp.start()
            events = integrate(grasp.rates, z, times[-1], times, grasp.indicators, grasp.event, at, **options)
        else:
            events = exponential.integrate(grasp, times[-1], times, at, 1e-10)
    expected = np.array([[row[output] for output in names] for row in rows])
    scale = np.abs(expected).max(axis=0)
    error = np.array([solution["error"][output] for output in names])
    assert np.all(np.abs(np.array(found) - expected) < 1e-9 * scale + error), np.abs(np.array(found) - expected) / scale
    # Of the plant's and the law's events some are the commands' at the actuators' limits.
    for time in solution["events"]:
        assert min(abs(time - event) for event in events) < 1e-10 + solution["event_error"], time


def test_saved_states_of_model_exchange_lead_back_to_the_same_bits(fmus: dict[str, Fmu]) -> None:
    """A solver that goes back to an earlier state gets the same derivatives, also from bytes in another instance."""
    for name in ("DualArmPlant", *CONTROLLERS):
        with Model(fmus[name]) as model, Model(fmus[name]) as other:
            model.start()
            model.x = model.x + 1e-3 * model.nominals
            state = model.fmi.getFMUstate()
            x, here, blob = model.x, model.rates(), model.fmi.serializeFMUstate(state)
            model.x = model.x + 1e-2 * model.nominals
            assert not np.array_equal(model.x, x)
            model.fmi.setFMUstate(state)
            assert np.array_equal(model.x, x) and np.array_equal(model.rates(), here), name
            restored = other.fmi.deSerializeFMUstate(blob)
            other.fmi.setFMUstate(restored)
            assert np.array_equal(other.x, x) and np.array_equal(other.rates(), here), name


def test_saturation_is_located_to_a_tenth_of_a_nanosecond(plant_model: Model, plant: Fmu) -> None:
    """Commands that are ramps of the time pass the limits at times that are known; the host asks the event indicators."""
    start = {v: float(plant.variables[v].start) for v in ("k_M1", "m_r1", "k_r1", "k_m2", "m_l2", "k_l2")}
    upper = start["k_r1"] * (start["k_M1"] - start["m_r1"])
    lower = start["k_l2"] * (start["k_m2"] - start["m_l2"])
    slopes = {"tau1_cmd": 700.0 * upper / 7.0, "u_cmd": 900.0 * lower / 7.0}
    port = plant_model.writer(list(slopes))

    def rates(t: float, x: np.ndarray) -> np.ndarray:
        plant_model.set_time(t)
        port.values[:] = [slope * t for slope in slopes.values()]
        port.write()
        plant_model.x = x
        return plant_model.rates()

    # The time is a state of the host here, so that the indicators, too, know it.
    def with_time(_t: float, z: np.ndarray) -> np.ndarray:
        return np.append(rates(z[-1], z[:-1]), 1.0)

    def indicators(z: np.ndarray) -> np.ndarray:
        rates(z[-1], z[:-1])
        return plant_model.indicators()[:12]

    def event() -> np.ndarray:
        plant_model.update()
        return np.append(plant_model.x, port.values[0] / slopes["tau1_cmd"])

    z = np.append(plant_model.x, 0.0)
    found = integrate(with_time, z, 0.012, [], indicators, event, rtol=1e-9, atol=1e-12)
    expected = sorted([upper / slopes["tau1_cmd"], lower / slopes["u_cmd"]])
    assert found == pytest.approx(expected, abs=1e-10)


def test_another_order_is_for_co_simulation(plant: Fmu) -> None:
    """The number of states is fixed when an FMU is packaged, and so is the order of model exchange."""
    with Model(plant) as model:
        model.set(order=12)
        with pytest.raises(FMICallException):
            model.start()
        assert "order is 12, but for model exchange" in model.log[-1].text
        assert "dualarm package --plant-order 12" in model.log[-1].text
        model.set(order=8)
        model.start()
    with plant.instantiate() as slave:
        slave.set(order=12)
        slave.start()
        slave.step(0.0, 1e-3, 1)


def test_a_host_that_integrates_hears_of_a_grasp_that_pulls(plant: Fmu) -> None:
    """A force that draws the object from the first arm: both arms' tips are held to it. Euler's steps are good enough for a sign."""
    with Model(plant) as model:
        model.fmi.setDebugLogging(True, [])
        model.set(delta_F=0.5)
        model.start()
        for i in range(1, 31):
            model.x = model.x + 1e-6 * model.rates()
            model.set_time(1e-6 * i)
            model.step_completed()
        assert min(model.get("contact_force1", "contact_force2")) < -1e-3
        model.fmi.terminate()
        said = [message.text for message in model.log if "contact lost" in message.text]
    assert len(said) == 1 and said[0].startswith("contact lost: tip ")
