"""Hosts that integrate a grasp that can open: ones that locate no events, events of both tips at once, bounces that come to rest, bad states."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

from .support import exponential
from .support.contact_exchange import CASES, FREE, SQUEEZE, UNILATERAL, Alone, in_a_mode
from .support.exchange import Model, fixed_steps, integrate
from .support.harness import Fmu
from .support.slave import FmuError


@pytest.fixture(name="model")
def fixture_model(plant: Fmu) -> Iterator[Model]:
    """The plant for model exchange, instantiated."""
    with Model(plant) as model:
        yield model


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
    model._new_discrete_states()  # pylint: disable=protected-access
    assert (model.info.again, model.info.states, model.info.nominals) == (1, 1, 0)
    model._new_discrete_states()  # pylint: disable=protected-access
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
