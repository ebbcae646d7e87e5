"""What each scenario claims, and the physics behind it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from .support.paths import ROOT
from .support.scenario import Run
from .support.tool import dualarm


def test_every_scenario_has_a_test_here() -> None:
    listed = {line.split()[0] for line in dualarm("simulate", "--list").stdout.splitlines()}
    source = Path(__file__).read_text(encoding="utf-8")
    assert {name for name in listed if f'run("{name}"' not in source} == set()
    assert listed == {path.stem for path in (ROOT / "scenarios").glob("*.toml")}


def test_root_strain_and_gains_from_a_search(run: Any) -> None:
    """0.12 and 0.11 s, as their files say of the forces; PDS in between, PD and PID a little later."""
    strain, fast = run("nabfc-r"), run("nabfc-r-fast")
    assert fast.settling() < 1 / 9 and fast.settling() < strain.settling() < 1 / 6
    pds, pd, pid = run("pds-tuned"), run("pd-tuned"), run("pid")
    assert fast.settling() < min(pds.settling(), pd.settling(), pid.settling())
    assert max(pds.settling(), pd.settling(), pid.settling()) < 0.2


def test_certified_gains_grasp(run: Any) -> None:
    """Slower than the default, as its file says, and within a second."""
    certified = run("nabfc-r-certified")
    assert run("nabfc-r").settling() < certified.settling() < 1.0


def test_the_papers_three(run: Any) -> None:
    """Section IV: "less than 0.5 s", "almost 2 s", "much longer"; and PD needs the 8 s its file gives it."""
    nabfc, pds, pd = run("nabfc"), run("pds"), run("pd")
    assert nabfc.settling() < 0.5 < pds.settling() < 2.0 < pd.settling() < 0.6 * pd.time[-1]
    for grasp in (nabfc, pds, pd):
        assert np.abs(grasp.forces[:, -1] - 0.5).max() < 0.02 * 0.5


def test_fast_preset_needs_half_the_time(run: Any) -> None:
    fast, default = run("nabfc-fast"), run("nabfc")
    assert fast.settling() < 0.6 * default.settling()
    assert np.abs(fast["tau1"]).max() > np.abs(default["tau1"]).max()


def test_preload_keeps_contact(run: Any) -> None:
    preloaded = run("preload")
    # What the arms press with is static; the tips' masses follow the object's actuator from the first instant.
    assert np.array([-preloaded["tip_shear1"][0], preloaded["tip_shear2"][0]]) == pytest.approx(0.1, rel=1e-9)
    assert preloaded.forces[:, 0].mean() == pytest.approx(0.1, rel=1e-9)
    assert preloaded["in_contact"].all()
    assert not run("nabfc")["in_contact"].all()


def test_unknown_mass_is_found_and_does_not_matter(run: Any) -> None:
    """1.5 kg and the tips' 0.2; the paper's law gets there without finding it."""
    heavy = run("unknown-mass")
    assert heavy.settling() < 0.2
    assert max(heavy.document["metrics"][f"contact_force{arm}"]["overshoot"] for arm in (1, 2)) < 2.5
    assert heavy["m_hat"][-1] == pytest.approx(1.7, rel=0.2)
    paper = run("unknown-mass", "--controller", "nabfc")
    assert 2 * heavy.settling() < paper.settling() < 0.45
    assert np.abs(paper["m_hat"] - 0.015).max() < 1e-3


def test_friction_costs_pd_its_accuracy(run: Any) -> None:
    """Static friction of 0.02 N.m: NABFC ends at the target, PD 3 mN short of it."""
    assert np.abs(run("friction").forces[:, -1] - 0.5).max() < 1e-4
    short = 0.5 - run("friction", "--controller", "pd", "--stop", "12").forces[:, -1]
    assert np.all((short > 2e-3) & (short < 4e-3))


def ringing(grasp: Run, begin: float) -> float:
    """Amplitude of the antisymmetric vibration: the sum of the forces without its slow part over a tenth of a second."""
    window = (grasp.time >= begin) & (grasp.time < begin + 0.1)
    time, force = grasp.time[window], grasp.forces.sum(axis=0)[window]
    slow = np.polynomial.Polynomial.fit(time, force, 3)
    return float(np.abs(force - slow(time)).max())


def test_viscous_damping_ends_the_ringing(run: Any) -> None:
    damped, undamped = run("viscous-damping"), run("viscous-damping", "--set", "kelvin_voigt=0")
    assert ringing(damped, 0.5) < 1e-5
    # The undamped pole of the linear loop: it would lose half its amplitude in 8 s.
    assert 4e-3 < ringing(undamped, 7.0) < ringing(undamped, 0.5)


def test_saturation_limits_and_does_not_slow(run: Any) -> None:
    weak, strong = run("saturation"), run("nabfc-r")
    metrics = weak.document["metrics"]
    for name, limit in (("tau1", 0.15), ("tau2", 0.15), ("u", 0.03)):
        assert np.abs(weak[name]).max() == pytest.approx(limit, rel=1e-12)
        assert 0.05 < metrics[name]["saturated"] < 0.15
    # A quarter more than the 0.141 s with strong ones that the default took before it learnt hub inertias.
    assert weak.settling() < 1.25 * 0.141
    assert strong.settling() < 0.141


def test_raw_dead_zone_is_found_by_adaptation_only(run: Any) -> None:
    # 0.5 mN is what lasting disturbances may leave at most; here it is the size of a limit cycle in the dead zone.
    assert np.abs(run("raw-dead-zone").forces[:, -1] - 0.5).max() < 5e-4
    short = 0.5 - run("raw-dead-zone", "--controller", "pd", "--stop", "12").forces[:, -1]
    assert np.all((short > 0.012) & (short < 0.017))


def test_noise_makes_the_force_rough_and_not_wrong(run: Any) -> None:
    """Some 6 mN rms, which double with the noise; the mean force is right, but for the mean of correlated noise."""
    noisy, noisier = run("noise"), run("noise", "--set", "noise_scale=2")
    rough, rougher = (grasp.between(1.0, 2.0).std(axis=1) for grasp in (noisy, noisier))
    assert np.all((rough > 2e-3) & (rough < 10e-3))
    assert np.all((rougher > 1.5 * rough) & (rougher < 2.5 * rough))
    assert np.abs(noisy.between(1.0, 2.0).mean(axis=1) - 0.5).max() < 5e-3


def test_delay_of_two_milliseconds_costs_nothing(run: Any) -> None:
    late = run("delay")
    assert np.array_equal(late["tau1_cmd_sent"][20::10], late["tau1_cmd"][:-20:10])
    # Within 5 % of 0.141 s, which is what the default took before it learnt hub inertias; at once it is now quicker than that.
    assert late.settling() < 1.05 * 0.141
    assert run("nabfc-r").settling() < 0.141


def test_encoders_are_enough(run: Any) -> None:
    """No rate is measured: within a few percent of the target, as its file says; the requirement is 10 mN rms."""
    coarse = run("encoders")
    assert np.sqrt(np.mean((coarse.between(1.0, 4.0) - 0.5) ** 2)) < 0.01
    assert np.abs(coarse.between(0.6, 4.0) - 0.5).max() < 0.05


def test_disturbance_pulse_is_survived(run: Any) -> None:
    pushed = run("disturbance-pulse")
    assert pushed["in_contact"].all()
    assert np.abs(pushed.between(0.9, 1.0) - 0.5).max() < 0.01
    # At the instant of the push the tips' masses take their share: m_i / (m_1 + m_2 + M) of it, in opposite senses.
    at = np.searchsorted(pushed.time, 1.0)
    jump = pushed.forces[:, at] - pushed.forces[:, at - 1]
    assert np.abs(jump) == pytest.approx(0.5 * 0.1 / 0.5, rel=0.01)
    assert jump[0] * jump[1] < 0
    assert np.abs(pushed.between(1.14, 2.0) - 0.5).max() < 0.02 * 0.5


def test_loss_of_contact_is_seen(run: Any) -> None:
    """The jerk opens the grasp: tip 1 is left behind, no force is ever tensile, and the object comes back."""
    jerked = run("loss-of-contact")
    lost = jerked.time[~jerked["in_contact"].astype(bool)]
    assert len(lost) > 0
    assert 1.0 <= lost.min()
    assert jerked.forces.min() == 0.0
    assert jerked["gap1"].max() > 1e-5
    warnings = [warning for warning in jerked.document["warnings"] if "contact lost" in warning]
    assert len(warnings) == 1
    assert "tip 1" in warnings[0]
    assert jerked["in_contact"][-1]


def test_arms_that_come_and_grasp(run: Any) -> None:
    """4 mm away: the object rests until the first tip comes, is hit, and held with the target's force in the end."""
    grasp = run("approach")
    assert (grasp["gap1"][0], grasp["gap2"][0]) == pytest.approx((4e-3, 4e-3), rel=1e-9)
    first = int(np.argmax((grasp["impacts1"] > 0) | (grasp["impacts2"] > 0)))
    assert first > 0
    # u acts on the object from the start; with nothing touching it is all that does, for a step of held commands.
    free = grasp["u"][: first - 1] / 0.3 * 1e-4
    assert np.diff(grasp["y_object_dot"][:first]) == pytest.approx(free, abs=1e-15)
    assert grasp.forces.min() == 0.0
    assert np.abs(grasp.forces[:, -1] - 0.5).max() < 5e-3
    assert np.all(grasp.forces[:, grasp["gap1"] > 0][0] == 0.0)


def test_a_soft_fruit_is_hit_once_on_each_side(run: Any) -> None:
    """Faces of 500 N/m: one soft impact each, as deep as the force says, and short of the target by what the faces give way:
    the target pose (16) is that of a rigid object, and the arms have 3 EI / l^3 = 43 N/m."""
    fruit = run("soft-fruit")
    assert (fruit["impacts1"][-1], fruit["impacts2"][-1]) == (1, 1)
    at_rest = fruit["indentation1"][-1] * 500.0
    assert at_rest == pytest.approx(fruit["contact_force1"][-1], abs=2e-3)
    assert 0.4 < fruit["contact_force1"][-1] < 0.5
    lost = fruit["impact_loss"]
    assert np.diff(lost).min() > -1e-15
    assert lost[-1] > 0


def test_a_hard_object_bounces_between_the_tips(run: Any) -> None:
    snatched = run("snatch")
    assert min(snatched["impacts1"][-1], snatched["impacts2"][-1]) >= 2
    assert max(snatched["gap1"].max(), snatched["gap2"].max()) >= 4e-3
    assert snatched["in_contact"][-1]
    # From the last gap on no impact comes.
    open_ = (snatched["gap1"] > 0) | (snatched["gap2"] > 0)
    assert snatched.time[open_][-1] < 1.0


def test_a_grasp_that_is_torn_open_is_found_again(run: Any) -> None:
    dropped = run("drop")
    open_ = dropped.time[dropped["gap2"] > 0]
    assert len(open_) > 0
    assert 1.0 <= open_[0] < 1.03
    assert dropped["gap2"].max() > 1e-3
    assert np.all(dropped["contact_force2"][dropped["gap2"] > 0] == 0.0)
    assert dropped["in_contact"][-1]
    assert np.abs(dropped.forces[:, -1] - 0.5).max() < 0.01


@pytest.mark.parametrize("controller", ["nabfc-r", "pd-tuned", "pds-tuned"])
def test_small_preload_is_enough(controller: str, run: Any) -> None:
    led = run("small-preload", "--controller", controller)
    assert led.forces.min() > 0.0
    assert led["in_contact"].all()
    assert (led["impacts1"][-1], led["impacts2"][-1]) == (0, 0)
    assert led.forces.max() < 0.51
    assert not led.document["warnings"]
    assert led.settling() < 0.3


def test_change_of_reference_is_followed(run: Any) -> None:
    changed = run("change-of-reference")
    ramp = (changed.time >= 1.0) & (changed.time <= 1.5)
    # The reference is a straight line, exact at every step, and jumps at 2.5 s and not one step later.
    assert changed["lambda2_d"][ramp] == pytest.approx(0.5 + 0.6 * (changed.time[ramp] - 1.0), abs=1e-12)
    at = np.searchsorted(changed.time, 2.5)
    assert (changed["lambda2_d"][at - 1], changed["lambda2_d"][at]) == pytest.approx((0.8, 0.4), abs=1e-12)
    assert np.abs(changed.between(2.3, 2.5) - 0.8).max() < 1e-3
    assert np.abs(changed.forces[:, -1] - 0.4).max() < 1e-3
    metrics = changed.document["metrics"]["contact_force1"]
    assert metrics["target"] == pytest.approx(0.4)
    assert metrics["settling_2"] < 1.0, "counts from the last change"


def test_stiff_arms_bend_a_quarter(run: Any) -> None:
    stiff, soft = run("stiff-arms"), run("nabfc-r")
    assert np.abs(stiff.forces[:, -1] - 0.5).max() < 1e-3
    assert stiff["tip_deflection1"][-1] == pytest.approx(soft["tip_deflection1"][-1] / 4, rel=2e-3)
    assert 5 < stiff.document["metrics"]["contact_force1"]["overshoot"] < 20


def test_wrong_stiffness_gives_a_wrong_force(run: Any) -> None:
    """The paper's law: pose reached, so force and stiffness are proportional, 0.138 / 0.115 of the target. The default law
    weighs the root moment, which shows the force, against the pose."""
    assert run("wrong-stiffness").forces[:, -1] == pytest.approx(0.51, abs=5e-3)
    wrong = run("wrong-stiffness", "--controller", "nabfc")
    assert np.abs(wrong["e1"][-1]) < 1e-5
    assert wrong.forces[:, -1] == pytest.approx(0.5 * 0.138 / 0.115, rel=1e-3)
