"""A grasp that can open, for model exchange: which tips touch changes in event mode alone, where event indicators say, and what the host
integrates is the motion that co-simulation steps exactly from switch to switch."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from fmpy import simulate_fmu

from .support import exponential
from .support.contact_exchange import CASES, COMPLIANT, COUNTS, FREE, SHOWN, UNILATERAL, Alone, in_a_mode, touches
from .support.exchange import Model
from .support.harness import Fmu
from .support.paths import fmu_path

# Over this time (s). Later rigid faces chatter, and a bit in a force decides about an impact more.
STOP = {"plastic": 0.0095, "bouncing": 0.02, "jerked out": 0.01}
# Forces follow a bending wave's last bit, and the losses in faces are the one integral that this solver has no error control for.
SCALES = dict.fromkeys(SHOWN, 1e-9) | {"contact_force1": 1e-7, "contact_force2": 1e-7, "root_moment1": 1e-8, "energy": 1e-8, "impact_loss": 1e-6}
# No step is longer (s): bending waves open and close rigid contacts for some microseconds, and lost energy is an integral of squares.
LONGEST = {"plastic": 1e-5, "bouncing": 1e-5, "soft": 1e-5}


@pytest.fixture(name="model")
def fixture_model(plant: Fmu) -> Iterator[Model]:
    """The plant for model exchange, instantiated."""
    with Model(plant) as model:
        yield model


@pytest.mark.parametrize("case", CASES)
def test_switches_and_motion_are_those_of_co_simulation(case: str, model: Model, plant: Fmu) -> None:
    """An exact solver and located events against exact steps: outputs at points in time, and each impact within a nanosecond.

    At every event what is lost is what is booked, and at no time is there a force across a gap.
    """
    stop = STOP.get(case, 0.035)
    grasp, times, rows = Alone(model), list(np.linspace(stop / 20, stop, 20)), []
    model.set(**CASES[case])

    def at(_t: float, z: np.ndarray) -> None:
        grasp.put(z)
        rows.append(grasp.shown.read())

    events = exponential.integrate(grasp, stop, times, at, 1e-10, LONGEST.get(case, 4e-5))
    with plant.instantiate() as slave:
        slave.set(**CASES[case])
        slave.start()
        shown, now, expected = slave.reader(SHOWN), 0.0, []
        for time in times:
            slave.fmi.doStep(now, time - now)
            now = time
            expected.append(shown.read())
        assert slave.get(*COUNTS) == model.get(*COUNTS)
    found, expected = np.array(rows), np.array(expected)
    scale = np.abs(expected).max(axis=0) + np.array([float(plant.variables[n].nominal or 1.0) for n in SHOWN])
    for name, error in zip(SHOWN, np.abs(found - expected).max(axis=0) / scale):
        assert error < SCALES[name], (name, error)
    for row in (dict(zip(SHOWN, row)) for row in rows):
        for tip in (1, 2):
            gap, force = row[f"gap{tip}"], row[f"contact_force{tip}"]
            assert gap >= 0.0 and force >= 0.0 and gap * force == 0.0
    assert len(grasp.seen) == len(events) and (events or case == "jerked out")
    with plant.instantiate() as slave:
        slave.set(**CASES[case])
        slave.start()
        now = 0.0
        for time, (before, after, earlier, later) in zip(events, grasp.seen):
            lost, booked = before["energy"] - after["energy"], after["impact_loss"] - before["impact_loss"]
            assert lost == pytest.approx(booked, abs=1e-15) and booked >= 0.0
            if earlier == later or time - 1e-9 <= now:
                continue
            slave.fmi.doStep(now, time - 1e-9 - now)
            assert slave.get(*COUNTS) == earlier, time
            slave.fmi.doStep(time - 1e-9, 2e-9)
            now = time + 1e-9
            assert slave.get(*COUNTS) == later, time


@pytest.mark.parametrize("case", ("plastic", "bouncing", "soft"))
def test_fmpy_finds_the_switches_with_cvode(case: str) -> None:
    """A solver that knows nothing of contacts: its own steps, its own search for roots. What it is off is its tolerance's."""
    stop, names = STOP.get(case, 0.035), [*SHOWN, *COUNTS, "in_contact1", "in_contact2", "supplied_energy"]
    common: dict[str, Any] = dict(
        filename=str(fmu_path("DualArmPlant")), stop_time=stop, output=names, output_interval=stop / 200
    )
    start = {**CASES[case], **FREE}
    exact = simulate_fmu(fmi_type="CoSimulation", start_values=start, **common)
    found = simulate_fmu(
        fmi_type="ModelExchange", solver="CVode", relative_tolerance=1e-10, start_values=start, record_events=False, **common
    )
    assert exact["impacts1"][-1] > 0
    if case != "plastic":
        # There tips open and close by less than the solver's tolerance.
        assert all(np.array_equal(found[name], exact[name]) for name in COUNTS)
    limits = dict.fromkeys(SHOWN, 1e-6) | {"theta1_dot": 1e-5, "y_object_dot": 1e-5, "root_moment1": 1e-4}
    limits |= {"contact_force1": 1e-3, "contact_force2": 1e-3}
    for name, limit in limits.items():
        scale = np.abs(np.array(exact[name])).max() or 1.0
        assert np.abs(np.array(found[name]) - exact[name]).max() < limit * scale, name
    books = found["energy"] - found["supplied_energy"] + found["impact_loss"]
    assert np.ptp(books) < 1e-7 * found["energy"].max()
    for tip in (1, 2):
        assert np.all(found[f"gap{tip}"] * found[f"contact_force{tip}"] == 0.0)


@pytest.mark.parametrize("kind", (UNILATERAL, COMPLIANT))
@pytest.mark.parametrize("touching", ((False, False), (True, False), (False, True), (True, True)))
def test_the_jacobian_in_each_mode(touching: tuple[bool, bool], kind: int, model: Model, plant: Fmu) -> None:
    """Directional derivatives by states and inputs are difference quotients; the mode stays as it is, whatever a solver tries."""
    in_a_mode(model, touching, kind)
    random = np.random.default_rng(7)
    inputs = plant.names("input", "Real")
    port, outputs = model.writer(inputs), model.reader(plant.names("output", "Real"))
    x0, u0 = model.x, np.array(model.get(*inputs))
    assert np.all((touches(model.indicators()) > 0) | ~np.array(touching))

    def value(x: np.ndarray, u: np.ndarray) -> np.ndarray:
        model.x, port.values[:] = x, u
        port.write()
        return np.concatenate([model.rates(), outputs.read()])

    unknowns = [*model.derivatives, *outputs.names]
    here = value(x0, u0)
    by_states, by_inputs = model.jacobian(unknowns, model.states), model.jacobian(unknowns, inputs)
    for _ in range(3):
        dx, du = 1e-2 * model.nominals * random.uniform(-1, 1, model.size), 1e-2 * random.uniform(-1, 1, len(inputs))
        h = 1e-3
        quotient = (value(x0 + h * dx, u0 + h * du) - value(x0 - h * dx, u0 - h * du)) / (2 * h)
        exact = by_states @ dx + by_inputs @ du
        scale = np.abs(quotient) + np.abs(exact).max() * 1e-6 + np.abs(here) * 1e-6 + 1e-9
        assert np.abs(exact - quotient) / scale == pytest.approx(0, abs=1e-6)


def test_what_a_held_tip_does_not_have_stands_still(model: Model) -> None:
    """Clearance, its rate and deformation of a rigid face: zero, with derivatives of zero, also if a solver tries others."""
    in_a_mode(model, (True, True), UNILATERAL)
    idle = [i for i, name in enumerate(model.states) if name.startswith(("clearance", "indentation"))]
    assert len(idle) == 6
    x, rates = model.x, model.rates()
    assert np.all(x[idle] == 0.0) and np.all(rates[idle] == 0.0)
    for i in idle:
        trial = x.copy()
        trial[i] = 0.1
        model.x = trial
        assert np.array_equal(model.x[idle], x[idle])
        assert model.rates() == pytest.approx(rates, rel=1e-12, abs=1e-12)


@pytest.mark.parametrize("case", ("bouncing", "soft", "pulled off"))
def test_saved_in_one_mode_and_restored_in_another(case: str, model: Model, plant: Fmu) -> None:
    """Which tips touch is part of the state, also from bytes in another instance, and in the middle of an event."""
    grasp, saved = Alone(model), []
    model.set(**CASES[case])

    def seen() -> tuple[Any, ...]:
        return model.x, model.rates(), model.indicators(), model.get(*SHOWN), model.get(*COUNTS)

    def at(_t: float, z: np.ndarray) -> None:
        grasp.put(z)
        state = model.fmi.getFMUstate()
        saved[:] = [state, model.fmi.serializeFMUstate(state), seen()]

    exponential.integrate(grasp, 0.03, [1e-3], at, 1e-8)
    first, blob, expected = saved
    assert len(grasp.seen) > 0 and not np.array_equal(model.x, expected[0])
    with Model(plant) as other:
        copy = other.fmi.deSerializeFMUstate(blob)
        for one, state in ((model, first), (other, copy)):
            one.fmi.setFMUstate(state)
            again = (one.x, one.rates(), one.indicators(), one.get(*SHOWN), one.get(*COUNTS))
            assert all(np.array_equal(a, b) for a, b in zip(again, expected))
    if case == "pulled off":
        return
    # Deep inside, in event mode: before the update, after it, and before it again.
    inside = model.x
    inside[[model.states.index(f"clearance{tip}") for tip in (1, 2)]] = -1e-6
    model.x = inside
    assert model.step_completed() == (True, False)
    model._enter_event_mode()  # pylint: disable=protected-access
    state = model.fmi.getFMUstate()
    model.update(enter=False)
    after = (model.x, model.get(*COUNTS))
    assert sum(after[1]) >= 1 and model.step_completed() == (False, False)
    model.fmi.setFMUstate(state)
    model.update(enter=False)
    assert np.array_equal(model.x, after[0]) and model.get(*COUNTS) == after[1]
