"""Saved states and reset: what follows must be the same to the bit, or be refused with a reason."""

from __future__ import annotations

import random
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from .support.capabilities import (
    directional_derivative,
    from_bytes,
    input_slopes,
    output_slopes,
    restore,
    saved_state,
    to_bytes,
)
from .support.continuation import SETTINGS, STEP, advance, inputs_at, running
from .support.contract import COMMANDS, CONTROLLERS, FMUS, PLANT
from .support.harness import Fmu, FmuError, Slave
from .support.paths import ROOT

each_fmu = pytest.mark.parametrize("name", FMUS)

Rows = list[list[float]]


# --- Continuation ----------------------------------------------------------------------------------------------------


@each_fmu
def test_the_scenario_uses_everything(name: str, fmus: dict[str, Fmu]) -> None:
    """Saturated and dead actuators, networks that have learned: what the other tests continue from is no rest."""
    with running(fmus[name], 50) as slave:
        if name == PLANT:
            hold = [(slave.set(**inputs_at(slave.fmu, i)), *slave.get("tau1", "tau2", "u"))[1:] for i in range(50, 90)]
            delivered = [abs(value) for row in hold for value in row]
            assert 2.0 in [round(value, 12) for value in delivered]
            assert 0.0 in delivered
        if name == "NabfcController":
            assert all(norm > 0.0 for norm in slave.get("W_norm", "U1_norm", "U2_norm"))


@each_fmu
def test_continues_after_going_back(name: str, fmus: dict[str, Fmu]) -> None:
    """The same instance, twice from one state; values, directional and output derivatives are those of then, too."""
    with running(fmus[name], 50) as slave, saved_state(slave) as state:
        inputs, outputs = slave.fmu.names("input", "Real"), slave.fmu.names("output", "Real")

        def now() -> Rows:
            shown = [*slave.fmu.names("parameter", "Real"), *inputs, *outputs]
            slopes = output_slopes(slave, [*COMMANDS][:2] if name in CONTROLLERS else outputs).read()
            return [slave.get(*shown), slopes, directional_derivative(slave, outputs, dict.fromkeys(inputs, 1.0))]

        before, after = now(), advance(slave, 50, 40)
        for _ in range(2):
            restore(slave, state)
            assert now() == before
            assert advance(slave, 50, 40) == after


@each_fmu
def test_continues_in_another_instance(name: str, fmus: dict[str, Fmu]) -> None:
    """By way of bytes, in a fresh instance, and in one in the middle of something else; saving changes nothing."""
    with running(fmus[name], 50) as slave, running(fmus[name], 7) as busy, fmus[name].instantiate() as fresh:
        blob = to_bytes(slave)
        assert to_bytes(slave) == blob
        after = advance(slave, 50, 40)
        for other in (fresh, busy):
            from_bytes(other, blob)
            assert advance(other, 50, 40) == after


@each_fmu
def test_continues_in_another_process(name: str, fmus: dict[str, Fmu], tmp_path: Path) -> None:
    with running(fmus[name], 51) as slave:
        blob = tmp_path / "state.bin"
        blob.write_bytes(to_bytes(slave))
        after = advance(slave, 51, 40)
    arguments = [str(fmus[name].path), str(blob), "51", "40"]
    done = subprocess.run(
        [sys.executable, "-m", "tests.support.continuation", *arguments],
        cwd=ROOT,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert [[float.fromhex(value) for value in line.split()] for line in done.stdout.splitlines()] == after


@each_fmu
def test_pending_ramps_are_part_of_the_state(name: str, fmus: dict[str, Fmu]) -> None:
    """A slope set before saving acts on the step after loading."""
    with running(fmus[name], 50) as slave, fmus[name].instantiate() as other:
        slopes = input_slopes(slave, slave.fmu.names("input", "Real"))
        slopes.values[:] = [1.0 + k for k in range(len(slopes.names))]
        slopes.write()
        from_bytes(other, to_bytes(slave))
        ends = []
        for instance in (slave, other):
            instance.step(50 * STEP, STEP, 1)
            ends.append(instance.get(*slave.fmu.names("output", "Real"), *slopes.names))
        assert ends[0] == ends[1]


# --- In every phase --------------------------------------------------------------------------------------------------


def as_instantiated(slave: Slave) -> None:
    slave.set(**SETTINGS[slave.fmu.name])


def as_initializing(slave: Slave) -> None:
    as_instantiated(slave)
    slave.fmi.setupExperiment(startTime=0.0)
    slave.fmi.enterInitializationMode()
    slave.set(**({"EI1": 0.1} if "EI1" in slave.fmu.variables else {"sample_time": 2e-4}))


def as_stepping(slave: Slave) -> None:
    as_instantiated(slave)
    slave.start()
    advance(slave, 0, 20)


def as_terminated(slave: Slave) -> None:
    as_stepping(slave)
    slave.fmi.terminate()


def go_on_from_instantiated(slave: Slave) -> Rows:
    slave.start()
    return advance(slave, 0, 20)


def go_on_from_initializing(slave: Slave) -> Rows:
    slave.fmi.exitInitializationMode()
    return advance(slave, 0, 20)


def go_on_from_stepping(slave: Slave) -> Rows:
    return advance(slave, 20, 20)


def go_on_from_terminated(slave: Slave) -> Rows:
    rows = [slave.get(*slave.fmu.names("output", "Real"))]
    with pytest.raises(FmuError, match="after termination"):
        slave.step(20 * STEP, STEP, 1)
    return rows


PHASES: list[tuple[Callable[[Slave], None], Callable[[Slave], Rows]]] = [
    (as_instantiated, go_on_from_instantiated),
    (as_initializing, go_on_from_initializing),
    (as_stepping, go_on_from_stepping),
    (as_terminated, go_on_from_terminated),
]


@pytest.mark.parametrize(("enter", "go_on"), PHASES, ids=lambda step: step.__name__ if callable(step) else None)
@each_fmu
def test_states_of_every_phase(
    name: str, enter: Callable[[Slave], None], go_on: Callable[[Slave], Rows], fmus: dict[str, Fmu]
) -> None:
    """A state brings its phase with it, whatever phase the receiving instance is in."""
    with fmus[name].instantiate(logging=True) as slave:
        enter(slave)
        with saved_state(slave) as state:
            blob = to_bytes(slave)
            expected = go_on(slave)
            for enter_another, _ in PHASES:
                with fmus[name].instantiate(logging=True) as other:
                    enter_another(other)
                    from_bytes(other, blob)
                    assert go_on(other) == expected
            restore(slave, state)
            assert go_on(slave) == expected


def test_state_from_before_a_discarded_step(plant: Fmu) -> None:
    """The standard's way on after fmi2Discard: back to before the step, and a smaller one."""
    with running(plant, 20) as slave, saved_state(slave) as state:
        expected = advance(slave, 20, 20)
        restore(slave, state)
        with pytest.raises(FmuError, match=r"status 2.*longest"):
            slave.step(20 * STEP, 1e12, 0)
        with pytest.raises(FmuError, match="after a discarded step"):
            slave.step(20 * STEP, STEP, 0)
        blob = to_bytes(slave)
        restore(slave, state)
        assert advance(slave, 20, 20) == expected
        # The phase after a discarded step is a state as well.
        from_bytes(slave, blob)
        with pytest.raises(FmuError, match="after a discarded step"):
            slave.step(20 * STEP, STEP, 0)
        restore(slave, state)
        assert advance(slave, 20, 20) == expected


# --- Refusals --------------------------------------------------------------------------------------------------------


def refuse(slave: Slave, blob: bytes) -> str:
    """Asserts that the blob is refused, and gives what was logged."""
    slave.log.clear()
    with pytest.raises(FmuError, match="fmi2DeSerializeFMUstate returned status 3"):
        from_bytes(slave, blob)
    categories = {category.name for category in slave.fmu.description.logCategories}
    assert slave.log
    assert slave.log[-1].status == 3
    assert slave.log[-1].category in categories
    return slave.log[-1].text


@each_fmu
def test_bad_blobs_are_refused(name: str, fmus: dict[str, Fmu]) -> None:
    """Each with a reason; the instance then goes on as if nothing had happened."""
    with running(fmus[name], 20) as slave, saved_state(slave) as state:
        blob = to_bytes(slave)
        expected = advance(slave, 20, 20)
        restore(slave, state)
        assert "not a saved FMU state" in refuse(slave, b"PK\x03\x04 something else altogether" * 10)
        assert "not a saved FMU state" in refuse(slave, blob[:5])
        for length in (8, 20, 50, 57, 58, 61, len(blob) // 2, len(blob) - 1):
            assert "truncated" in refuse(slave, blob[:length])
        assert "truncated or extended" in refuse(slave, blob + b"\0")
        assert "truncated or extended" in refuse(slave, blob + blob)
        newer = bytearray(blob)
        newer[8] += 1
        assert "version" in refuse(slave, bytes(newer))
        random_bits = random.Random(7).sample(range(58 * 8, len(blob) * 8), 200)
        for bit in [*range(58 * 8), *random_bits]:
            flipped = bytearray(blob)
            flipped[bit // 8] ^= 1 << (bit % 8)
            reason = refuse(slave, bytes(flipped))
            if bit >= 58 * 8:
                assert "checksum" in reason
        assert advance(slave, 20, 20) == expected


@pytest.mark.parametrize(("giver", "taker"), [(a, b) for a in FMUS for b in FMUS if a != b])
def test_states_of_other_fmus_are_refused(giver: str, taker: str, fmus: dict[str, Fmu]) -> None:
    """By GUID: the controllers share a library, and PD and PDS nearly a layout."""
    with running(fmus[giver], 3) as one, running(fmus[taker], 3) as two:
        text = refuse(two, to_bytes(one))
        assert fmus[giver].description.guid in text
        assert fmus[taker].description.guid in text


# --- Reset -----------------------------------------------------------------------------------------------------------


@each_fmu
@pytest.mark.parametrize("enter", [enter for enter, _ in PHASES], ids=lambda enter: enter.__name__)
def test_reset_is_a_fresh_instance(name: str, enter: Callable[[Slave], None], fmus: dict[str, Fmu]) -> None:
    """Parameters, inputs, state, clock: from every phase back to the start values, to the bit of the saved state."""
    with fmus[name].instantiate() as fresh, fmus[name].instantiate() as used:
        enter(used)
        used.fmi.reset()
        assert to_bytes(used) == to_bytes(fresh)
        rows = []
        for slave in (fresh, used):
            slave.start()
            rows.append(advance(slave, 0, 40))
        assert rows[0] == rows[1]
        assert to_bytes(used) == to_bytes(fresh)
