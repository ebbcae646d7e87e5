"""Parameters while the model runs: fixed ones are refused, gains act at once and exactly, bad values change nothing."""

from __future__ import annotations

import pytest

from .support.capabilities import restore, saved_state
from .support.continuation import SETTINGS, advance, running
from .support.contract import COMMANDS, FMUS, PLANT
from .support.harness import Fmu, FmuError, Slave

each_fmu = pytest.mark.parametrize("name", FMUS)

Rows = list[list[float]]


def by_variability(fmu: Fmu, variability: str) -> list[str]:
    return [v.name for v in fmu.variables.values() if v.causality == "parameter" and v.variability == variability]


@each_fmu
def test_fixed_parameters_are_refused_while_running(name: str, fmus: dict[str, Fmu]) -> None:
    with running(fmus[name], 20) as slave, saved_state(slave) as state:
        expected = advance(slave, 20, 20)
        restore(slave, state)
        fixed = by_variability(fmus[name], "fixed")
        assert fixed
        for parameter in fixed:
            (value,) = slave.get(parameter)
            slave.log.clear()
            with pytest.raises(FmuError, match="status 3"):
                slave.set(**{parameter: value})
            assert parameter in slave.log[-1].text
            assert "fixed" in slave.log[-1].text
        assert advance(slave, 20, 20) == expected


PD_GAINS = ["kp", "kv", "ki", "kp1", "kv1", "ki1", "kp2", "kv2", "ki2"]
# Limits and observers: without integrals and with measured rates nothing looks at them.
ACTUATION = ["tau_limit", "u_limit", "observer_inertia1", "observer_inertia2", "observer_mass", "observer_bandwidth"]


def test_everything_of_the_plant_is_fixed_and_gains_are_tunable(fmus: dict[str, Fmu]) -> None:
    assert by_variability(fmus[PLANT], "tunable") == []
    assert by_variability(fmus["PdController"], "tunable") == [*PD_GAINS, *ACTUATION]
    assert {"ks1", "ks2"} < set(by_variability(fmus["PdsController"], "tunable"))
    assert {"eta", "k", "c31", "g22", "sat_limit"} < set(by_variability(fmus["NabfcController"], "tunable"))


@pytest.mark.parametrize("name", ["PdController", "PdsController"])
def test_tuned_gains_act_at_once(name: str, fmus: dict[str, Fmu]) -> None:
    """A law without integrals has no state, and is from then on that of an instance that always had the new gains."""
    tunable = by_variability(fmus[name], "tunable")
    gains = {parameter: 1.5 + i for i, parameter in enumerate(tunable) if not parameter.startswith("ki")}
    with running(fmus[name], 20) as tuned, fmus[name].instantiate() as other:
        other.set(**SETTINGS[name])
        other.set(**gains)
        other.start()
        before = tuned.get(*COMMANDS)
        tuned.set(**gains)
        other.set(**dict(zip(tuned.fmu.names("input"), tuned.get(*tuned.fmu.names("input")))))
        assert tuned.get(*COMMANDS) == other.get(*COMMANDS) != before
        assert advance(tuned, 20, 20)[-1] == advance_from_start(other, 20)[-1]


def advance_from_start(slave: Slave, steps: int) -> Rows:
    """What `advance(slave, steps, steps)` does to a law without state, from a clock at zero."""
    advance(slave, 0, steps)
    return advance(slave, steps, steps)


@pytest.mark.parametrize("law", ["paper", "root_strain"])
def test_tuned_gains_of_the_adaptive_law(law: str, fmus: dict[str, Fmu]) -> None:
    """Every tunable parameter one after the other: estimates do not jump, and what follows is another run."""
    fmu = fmus["NabfcController"]
    estimates = ("m_hat", "J1_hat", "J2_hat", "epsilon_hat", "pi1_hat", "pi2_hat", "W_norm", "U1_norm", "U2_norm")
    unused = set()
    with fmu.instantiate() as slave:
        slave.set(**SETTINGS["NabfcController"], law=law)
        slave.start()
        advance(slave, 0, 20)
        with saved_state(slave) as state:
            expected = advance(slave, 20, 20)
            for parameter in by_variability(fmu, "tunable"):
                restore(slave, state)
                before = slave.get(*estimates)
                (value,) = slave.get(parameter)
                slave.set(**{parameter: min(1.25 * value + 1e-3, float(fmu.variables[parameter].max))})
                if not bounds(parameter):
                    assert slave.get(*estimates) == before, parameter
                if advance(slave, 20, 20) == expected:
                    unused.add(parameter)
            # Back to the old value: as if it had never been touched.
            restore(slave, state)
            gain = "k" if law == "paper" else "r_reach"
            slave.set(**{gain: 7.0})
            slave.set(**{gain: float(fmu.variables[gain].start)})
            assert advance(slave, 20, 20) == expected
    # What belongs to the other law, and bounds that are not reached.
    other = {name for name in by_variability(fmu, "tunable") if name.startswith("r_") == (law == "paper")}
    assert {name for name in unused - other - set(ACTUATION) if not bounds(name)} == set()
    assert other - set(ACTUATION) <= unused


def bounds(parameter: str) -> bool:
    """Whether a parameter is a bound of an estimate, or a measure of the inertia that one is in."""
    return parameter.endswith(("_max", "_min")) or parameter in ACTUATION or parameter.startswith(("r_mass", "r_inertia"))


@pytest.mark.parametrize(
    ("name", "parameter", "value"),
    [
        ("PdController", "kp", -1.0),
        ("PdController", "kv1", float("nan")),
        ("PdsController", "ks2", float("inf")),
        ("NabfcController", "epsilon1", 0.0),
        ("NabfcController", "sat_limit", -0.1),
        ("NabfcController", "shear_rate_bandwidth", -1.0),
    ],
)
def test_bad_values_for_tunable_parameters(name: str, parameter: str, value: float, fmus: dict[str, Fmu]) -> None:
    """Refused with the parameter's name; the old value stays in force."""
    with running(fmus[name], 20) as slave, saved_state(slave) as state:
        expected = advance(slave, 20, 20)
        restore(slave, state)
        old = slave.get(parameter)
        with pytest.raises(FmuError, match=f"status 3.*{parameter}"):
            slave.set(**{parameter: value})
        assert slave.get(parameter) == old
        assert advance(slave, 20, 20) == expected
