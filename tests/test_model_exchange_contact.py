"""A grasp that can open, for model exchange: which tips touch changes in event mode alone, where event indicators say, and what the host
integrates is the motion that co-simulation steps exactly from switch to switch."""

from __future__ import annotations

import ctypes
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from fmpy import simulate_fmu

from .support import exponential
from .support.exchange import Grasp, Model, fixed_steps, integrate
from .support.harness import Fmu
from .support.paths import fmu_path
from .support.slave import FmuError

UNILATERAL, COMPLIANT = 2, 3
FREE: dict[str, Any] = {"root_uncertainty": 0.0, "tip_uncertainty": 0.0}
# 0.8 and 1.2 mm away, both coming.
AWAY: dict[str, Any] = {"theta1_0": -0.004, "theta2_0": 0.006, "theta1_dot_0": 0.5, "theta2_dot_0": -0.6}
# What 0.1 N.m on both hubs hold.
HELD: dict[str, Any] = {"theta1_0": 0.1 * 0.2 / (3 * 0.115), "theta2_0": -0.1 * 0.2 / (3 * 0.115)}
SQUEEZE: dict[str, Any] = {"tau1_cmd": 0.1, "tau2_cmd": -0.12}
CASES: dict[str, dict[str, Any]] = {
    "plastic": {"contact_model": UNILATERAL, **AWAY, **SQUEEZE},
    "bouncing": {"contact_model": UNILATERAL, "restitution": 0.5, **AWAY, **SQUEEZE},
    "soft": {"contact_model": COMPLIANT, "contact_stiffness1": 5000.0, "contact_damping2": 2.0, **AWAY, **SQUEEZE},
    "undamped": {"contact_model": COMPLIANT, "contact_damping1": 0.0, "contact_damping2": 0.0, **AWAY, **SQUEEZE},
    "pulled off": {"contact_model": UNILATERAL, **HELD, "tau1_cmd": -1.5, "tau2_cmd": 1.2},
    "pulled off soft faces": {"contact_model": COMPLIANT, **HELD, "tau1_cmd": -1.5, "tau2_cmd": 1.2},
    "jerked out": {"contact_model": UNILATERAL, **HELD, "tau1_cmd": 0.1, "tau2_cmd": -0.1, "delta_F": 3.0},
}
# Over this time (s). Later rigid faces chatter, and a bit in a force decides about an impact more.
STOP = {"plastic": 0.0095, "bouncing": 0.02, "jerked out": 0.01}
SHOWN = (
    *("theta1", "theta2", "y_object", "theta1_dot", "y_object_dot", "root_moment1", "contact_force1", "contact_force2"),
    *("gap1", "gap2", "indentation1", "indentation2", "impact_loss", "energy"),
)
# Forces follow a bending wave's last bit, and the losses in faces are the one integral that this solver has no error control for.
SCALES = dict.fromkeys(SHOWN, 1e-9) | {"contact_force1": 1e-7, "contact_force2": 1e-7, "root_moment1": 1e-8, "energy": 1e-8, "impact_loss": 1e-6}
# No step is longer (s): bending waves open and close rigid contacts for some microseconds, and lost energy is an integral of squares.
LONGEST = {"plastic": 1e-5, "bouncing": 1e-5, "soft": 1e-5}
COUNTS = ("impacts1", "impacts2")


class Nothing:
    """No controller."""

    size, nominals, states, derivatives = 0, np.zeros(0), (), ()

    def set_time(self, _t: float) -> None:
        """Nothing."""

    def step_completed(self) -> tuple[bool, bool]:
        """No wish."""
        return False, False


class Alone(Grasp):
    """The plant with inputs that stand still, as one system; keeps what was seen at its events."""

    def __init__(self, plant: Model) -> None:  # pylint: disable=super-init-not-called
        self.plant, self.controller, self.split = plant, Nothing(), plant.size
        self.shown, self.seen = plant.reader(SHOWN), []

    def start(self) -> np.ndarray:
        """From instantiated to continuous-time mode."""
        self.plant.start()
        return self.plant.x

    def put(self, z: np.ndarray) -> None:
        """Sets the states."""
        self.plant.x = z

    def rates(self, _t: float, z: np.ndarray) -> np.ndarray:
        """The derivatives."""
        self.put(z)
        return self.plant.rates()

    def jacobian(self, _t: float, z: np.ndarray) -> np.ndarray:
        """Their derivatives by the states."""
        self.put(z)
        return self.plant.jacobian(self.plant.derivatives, self.plant.states)

    def indicators(self, z: np.ndarray) -> np.ndarray:
        """The event indicators."""
        self.put(z)
        return self.plant.indicators()

    def event(self) -> np.ndarray:
        """Updates the discrete states; what was there before and after."""
        before, counts = dict(zip(SHOWN, self.shown.read())), self.plant.get(*COUNTS)
        x = self.plant.x
        info = self.plant.update()
        after = dict(zip(SHOWN, self.shown.read()))
        self.seen.append((before, after, counts, self.plant.get(*COUNTS)))
        assert bool(info.nominals) is False and bool(info.has_next_time) is False
        changed = [name for name, old, new in zip(self.plant.states, x, self.plant.x) if abs(old - new) > 1e-12]
        assert all(name.startswith(("clearance", "impact_loss")) for name in changed), changed
        return self.plant.x


@pytest.fixture(name="model")
def fixture_model(plant: Fmu) -> Iterator[Model]:
    """The plant for model exchange, instantiated."""
    with Model(plant) as model:
        yield model


def touches(z: np.ndarray) -> np.ndarray:
    """The indicators of both contacts."""
    return z[12:]


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


def in_a_mode(model: Model, touching: tuple[bool, bool], kind: int) -> None:
    """Starts the plant with these tips on the object, and moves it away from rest."""
    angles = [(0.01 if touches else -0.02) for touches in touching]
    model.set(contact_model=kind, theta1_0=angles[0], theta2_0=-angles[1], theta1_dot_0=0.1, **SQUEEZE)
    model.start()
    x = model.x + 1e-3 * model.nominals * np.sin(np.arange(model.size))
    model.x = x


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


@pytest.mark.parametrize("obeys", (True, False), ids=("obeys", "ignores"))
@pytest.mark.parametrize("case", ("plastic", "bouncing", "soft", "pulled off", "undamped"))
def test_hosts_that_locate_no_events(case: str, obeys: bool, model: Model, plant: Fmu) -> None:
    """Fixed steps, events at their ends: a tip comes in by at most a step's way. A host that does not take over the states which an event has
    changed gets another motion, but never one that blows up, and every call is answered."""
    size, steps = 2e-6, 14_000 if case == "pulled off" else 6000
    grasp = Alone(model)
    model.set(**CASES[case])
    if not obeys:
        keep = grasp.event
        held: list[np.ndarray] = []
        put = grasp.put

        def remember(z: np.ndarray) -> None:
            held[:] = [z]
            put(z)

        def ignore() -> np.ndarray:
            z = held[0].copy()
            keep()
            return z

        grasp.put, grasp.event = remember, ignore  # type: ignore[method-assign]
    clearances = [model.states.index(f"clearance{tip}") for tip in (1, 2)]
    depth: list[float] = []
    events = fixed_steps(grasp, size, steps, lambda _t: depth.append(min(model.x[clearances])))
    assert events > 0 and np.all(np.isfinite(model.x))
    if obeys:
        limit = 1e-2 if case in ("soft", "undamped") else 0.3 * size
        assert min(depth) > -limit
        with plant.instantiate() as slave:
            slave.set(**CASES[case])
            slave.start()
            slave.fmi.doStep(0.0, size * steps)
            found, exact = model.get("theta1", "y_object"), slave.get("theta1", "y_object")
        # Plastic tips open and close within a step, too.
        assert found == pytest.approx(exact, abs=1e-4 if case == "plastic" else 2e-6)
    assert not [m for m in model.log if m.status > 1]


def test_an_event_tells_of_its_jumps_until_it_ends(model: Model) -> None:
    """Rates jump, commands may follow: the host shall call once more, and may look at the last answer alone."""
    in_a_mode(model, (False, False), UNILATERAL)
    x = model.x
    x[[model.states.index(f"clearance{tip}") for tip in (1, 2)]] = -1e-9
    x[[model.states.index(f"clearance{tip}_dot") for tip in (1, 2)]] = -0.1
    model.x = x
    model._enter_event_mode()  # pylint: disable=protected-access
    model._new_discrete_states(ctypes.byref(model.info))  # pylint: disable=protected-access
    assert (model.info.again, model.info.states, model.info.nominals) == (1, 1, 0)
    model._new_discrete_states(ctypes.byref(model.info))  # pylint: disable=protected-access
    assert (model.info.again, model.info.states, model.info.nominals) == (0, 1, 0)
    model.update(enter=False)
    # Nothing has happened since.
    assert model.update().states == 0


def test_both_tips_at_once(model: Model) -> None:
    """Two arms that do the same hit the object in one event, as co-simulation has it: it stays where it is."""
    model.set(contact_model=UNILATERAL, restitution=0.5, theta1_0=-0.004, theta2_0=0.004, tau1_cmd=0.1, tau2_cmd=-0.1)
    model.set(theta1_dot_0=0.8, theta2_dot_0=-0.8)
    grasp = Alone(model)
    z = grasp.start()
    nominal = model.nominals
    from scipy.integrate import DOP853

    options: dict[str, Any] = {"method": DOP853, "rtol": 1e-9, "atol": 1e-11 * nominal}
    integrate(grasp.rates, z, 0.006, [], grasp.indicators, grasp.event, **options)
    assert [counts for *_, counts in grasp.seen if counts != [0, 0]][:1] == [[1, 1]]
    assert abs(model.get("y_object_dot")[0]) < 1e-9


def test_bounces_come_to_rest(model: Model) -> None:
    """An object that falls onto a tip with next to no arm bounces at times that arithmetic knows, and comes to rest where their sum
    ends: after a finite number of events."""
    bounce, gap, force, mass = 0.5, 1e-3, 0.3, 0.3
    light: dict[str, float] = {f"{name}{arm}": 1e-9 for name in ("EI", "rho", "J") for arm in (1, 2)}
    model.set(contact_model=UNILATERAL, restitution=bounce, theta1_0=-gap / 0.2, theta2_0=0.5, **FREE, **light)
    model.set(delta_F=-force)
    grasp, impacts = Alone(model), []
    first = np.sqrt(2 * gap * mass / force)
    end = first * (1 + bounce) / (1 - bounce)
    events = exponential.integrate(grasp, 1.1 * end, [], lambda _t, _z: None, 1e-10, 1e-3)
    impacts = [time for time, (_, _, before, after) in zip(events, grasp.seen) if before != after]
    expected = [first * (1 + 2 * bounce * (1 - bounce**n) / (1 - bounce)) for n in range(12)]
    # The hub's inertia is a quarter of a millionth of the tip's mass.
    assert impacts[:12] == pytest.approx(expected, rel=2e-6)
    assert 12 < len(impacts) < 40 and max(impacts) < end * (1 + 2e-6)
    assert model.get("gap1", "contact_force1") == pytest.approx([0.0, force * 0.1 / (mass + 0.1)], rel=1e-5)


@pytest.mark.parametrize("bad", (np.nan, np.inf, 1e200))
def test_states_that_are_no_numbers_are_discarded(bad: float, model: Model) -> None:
    """With fmi2Discard, and nothing has changed."""
    in_a_mode(model, (False, True), UNILATERAL)
    x, rates = model.x, model.rates()
    for name in ("x[3]", "clearance1", "clearance1_dot", "indentation1", "impact_loss"):
        trial = x.copy()
        trial[model.states.index(name)] = bad
        with pytest.raises(FmuError) as refused:
            model.x = trial
        assert refused.value.status == 2
        assert np.array_equal(model.x, x) and np.array_equal(model.rates(), rates)


def test_the_default_grasp_has_idle_states(model: Model) -> None:
    """Seven states for what opens, which with a bilateral contact are zero, stay zero and are felt by nothing."""
    model.set(**SQUEEZE)
    model.start()
    assert model.size == 42 and model.states[35:] == [
        *("indentation1", "indentation2", "impact_loss", "clearance1", "clearance2", "clearance1_dot", "clearance2_dot")
    ]
    x, rates = model.x, model.rates()
    assert np.all(x[35:] == 0.0) and np.all(rates[35:] == 0.0)
    x[35:] = 0.1
    model.x = x
    assert np.all(model.x[35:] == 0.0) and np.array_equal(model.rates(), rates)
