//! A grasp that can open: against what is known exactly.

#![allow(clippy::doc_markdown)]

use grasp_plant::{ActuatorModel, Arm, ContactModel, Face, Inputs, Parameters, Plant, Start, StateError, StepError};

fn conservative(contact_model: ContactModel) -> Parameters {
    Parameters {
        contact_model,
        root_uncertainty: 0.0,
        tip_uncertainty: 0.0,
        actuator_model: ActuatorModel::Ideal,
        ..Parameters::default()
    }
}

/// 0.1 N on both sides, at rest.
fn preload() -> Start {
    let angle = 0.1 * 0.2 * 0.2 / (3.0 * 0.115);
    Start { theta: [angle, -angle], ..Start::default() }
}

/// Σ(J θ̇ + ∫ρ x v dx + l m_i v_i(l)) + l M ẏ: what τ_1 + τ_2 + l u changes, and no contact.
fn momentum(plant: &Plant) -> f64 {
    let p = plant.parameters();
    let (k, l) = (p.order, p.length);
    let x = &plant.state().coordinates;
    let of_arm = |(i, arm): (usize, &Arm)| {
        // x is a combination of the first two Legendre polynomials.
        let b = &x[2 * k + i * (k - 1)..];
        let beam = (arm.rho * l).sqrt() * l / 2.0 * (b[0] + b[1] / 3f64.sqrt());
        beam + arm.hub_inertia.sqrt() * x[4 * k - 2 + i] + l * arm.tip_mass.sqrt() * x[4 * k + i]
    };
    p.arms.iter().enumerate().map(of_arm).sum::<f64>() + l * p.object_mass.sqrt() * x[4 * k + 2]
}

/// While both tips press, the motion is that of the bilateral plant; so are the forces, if ΔF acts nowhere.
#[test]
fn while_both_tips_press_it_is_the_papers_plant() {
    for tip_uncertainty in [0.0, 0.05] {
        let parameters = Parameters { start: preload(), tip_uncertainty, ..Parameters::default() };
        let mut paper = Plant::new(parameters.clone()).unwrap();
        let mut opening = Plant::new(Parameters { contact_model: ContactModel::Unilateral, ..parameters }).unwrap();
        for i in 0..1000 {
            let inputs = Inputs {
                torque_command: [0.02 + 1e-3 * (f64::from(i) * 0.03).sin(), -0.02],
                force_command: 1e-3 * (f64::from(i) * 0.05).cos(),
                ..Inputs::ZERO
            };
            for plant in [&mut paper, &mut opening] {
                plant.step(1e-3, &inputs, &Inputs::ZERO).unwrap();
            }
            let (a, b) = (paper.measured(), opening.measured());
            // Rounding of two different sums of the same system.
            assert!((a.theta[0] - b.theta[0]).abs() < 1e-12 && (a.y_object - b.y_object).abs() < 1e-12, "{i}");
            assert!((a.tip_shear[0] - b.tip_shear[0]).abs() < 1e-9, "{i}");
            if tip_uncertainty == 0.0 {
                let (a, b) = (paper.direct(&inputs), opening.direct(&inputs));
                assert!((a.contact_force[0] - b.contact_force[0]).abs() < 1e-9, "{i} {a:?} {b:?}");
                assert!((a.lambda[1] - b.lambda[1]).abs() < 1e-9);
            }
        }
        assert_eq!(opening.state().contact.as_deref().unwrap().openings, [0; 2]);
    }
}

/// Driven through thousands of switches: energy − supplied energy + losses, momentum, and gap = ±φ + indentation stay what they
/// were; no force is ever tensile, no gap negative, no loss taken back.
#[test]
fn the_books_balance_through_thousands_of_switches() {
    for contact_model in [ContactModel::Unilateral, ContactModel::Compliant] {
        for (restitution, damping) in [(0.0, 0.0), (0.5, 5.0), (1.0, 50.0)] {
            let start = Start { theta: [-0.005, 0.01], theta_dot: [0.3, -0.2], y_object: 0.05, y_object_dot: 0.5 };
            let faces = [Face { stiffness: 3000.0, damping }; 2];
            let parameters = Parameters { start, restitution, faces, order: 6, ..conservative(contact_model) };
            let mut plant = Plant::new(parameters).unwrap();
            let (energy, before) = (plant.energy(), momentum(&plant));
            let (mut impulse, mut loss) = (0.0, 0.0);
            for i in 0..1500 {
                let t = f64::from(i) * 1e-3;
                let inputs = Inputs {
                    torque_command: [0.05 + 0.02 * (20.0 * t).sin(), -0.06],
                    force_command: 0.3 * (13.0 * t).sin(),
                    ..Inputs::ZERO
                };
                // Every third step is a ramp.
                let rate = if i % 3 == 0 { 5.0 } else { 0.0 };
                plant.step(1e-3, &inputs, &Inputs { force_command: rate, ..Inputs::ZERO }).unwrap();
                let [tau_1, tau_2] = inputs.torque_command;
                impulse += 1e-3 * (tau_1 + tau_2 + 0.2 * (inputs.force_command + 0.5e-3 * rate));
                let contact = plant.contact();
                let balance = plant.energy() + contact.loss - plant.supplied_energy() - energy;
                assert!(balance.abs() < 1e-12, "{contact_model:?} {restitution}: {balance:e} J");
                let gained = momentum(&plant) - before - impulse;
                assert!(gained.abs() < 1e-12, "{contact_model:?} {restitution}: {gained:e}");
                for (side, phi) in plant.constraint().into_iter().enumerate() {
                    let distance = [-phi, phi][side] + contact.indentation[side];
                    assert!((distance - contact.gap[side]).abs() < 1e-14, "{distance:e}");
                    assert!(contact.gap[side] >= 0.0 && plant.direct(&inputs).contact_force[side] >= 0.0);
                }
                // Elastic impacts lose nothing but rounding.
                assert!(contact.loss >= loss - 1e-15, "{loss:e} {:e}", contact.loss);
                loss = contact.loss;
            }
            let switches = plant.state().contact.as_deref().unwrap();
            println!("{contact_model:?} {restitution} {damping}: {switches:?}");
            assert!(switches.impacts.iter().all(|impacts| *impacts > 3), "{switches:?}");
        }
    }
}

/// Arms that are nearly nothing but their tips' masses: the object falls on tip 1 like a ball on a ball, and all is known.
/// Relative acceleration a = F/M in flight, bounces e^n v apart, an infinity of them before 3 √(2g/a) for e = ½.
#[test]
fn bounces_of_light_arms_come_when_a_ball_would_bounce() {
    let light = Arm { ei: 1e-9, rho: 1e-9, hub_inertia: 1e-9, tip_mass: 0.1 };
    let (gap, force, mass, e) = (0.01, 0.3, 0.3, 0.5);
    let parameters = Parameters {
        arms: [light; 2],
        restitution: e,
        plastic_speed: 1e-9,
        start: Start { theta: [-gap / 0.2, 0.5], ..Start::default() },
        ..conservative(ContactModel::Unilateral)
    };
    let inputs = Inputs { force_command: -force, ..Inputs::ZERO };
    let acceleration: f64 = force / mass;
    let first = (2.0 * gap / acceleration).sqrt();
    let speed = acceleration * first;
    // The hub's inertia is J/l² = 2.5e-8 kg at the tip, a quarter of a millionth of its mass.
    let (slack, margin) = (2e-6, 1e-6);
    let mut plant = Plant::new(parameters.clone()).unwrap();
    let (mut now, mut bounce) = (0.0, first);
    for n in 1..12 {
        let flight = 2.0 * e.powi(n) * speed / acceleration;
        let impacts = |plant: &Plant| plant.state().contact.as_deref().unwrap().impacts;
        plant.step(bounce - margin - now, &inputs, &Inputs::ZERO).unwrap();
        assert_eq!(impacts(&plant), [n.cast_unsigned() - 1, 0], "{n}");
        plant.step(2.0 * margin, &inputs, &Inputs::ZERO).unwrap();
        assert_eq!(impacts(&plant), [n.cast_unsigned(), 0], "{n}");
        now = bounce + margin;
        bounce += flight;
    }
    // One step over all bounces ends where the small ones do, with object and tip together: momentum −F t, and the centre of
    // mass has fallen F t²/2m.
    let total = 4.0 * first;
    let mut whole = Plant::new(parameters).unwrap();
    whole.step(total, &inputs, &Inputs::ZERO).unwrap();
    plant.step(total - now, &inputs, &Inputs::ZERO).unwrap();
    for plant in [&whole, &plant] {
        let both = mass + 0.1;
        let v = -force * total / both;
        assert!((plant.measured().y_object_dot - v).abs() < slack * v.abs());
        let fallen = -force * total * total / 2.0 / both;
        let centre = mass * (plant.measured().y_object - 0.05) + 0.1 * (plant.measured().y_object - 0.05 + gap);
        assert!((centre / both - fallen).abs() < slack * fallen.abs(), "{centre} {fallen}");
        let pressing = plant.direct(&inputs).contact_force[0];
        assert!((pressing - force * 0.1 / both).abs() < slack, "{pressing}");
        assert_eq!(plant.contact().gap[0], 0.0);
        // What a plastic impact would have taken at once.
        let loss = 0.5 * (mass * 0.1 / both) * speed * speed;
        assert!((plant.contact().loss - loss).abs() < slack * loss, "{} {loss}", plant.contact().loss);
    }
}

/// The stiffer the faces, the closer to rigid ones: the way through an approach, an impact and a squeeze, to first order in
/// 1/k.
#[test]
fn stiff_faces_become_rigid_ones() {
    let start = Start { theta: [-0.02, 0.02], ..Start::default() };
    let inputs = Inputs { torque_command: [0.1, -0.1], ..Inputs::ZERO };
    let run = |parameters: Parameters| {
        let mut plant = Plant::new(Parameters { start, ..parameters }).unwrap();
        (0..400).for_each(|_| plant.step(1e-3, &inputs, &Inputs::ZERO).unwrap());
        (plant.measured().theta, plant.direct(&inputs).contact_force, plant.contact().loss)
    };
    let rigid = run(Parameters { contact_model: ContactModel::Unilateral, ..Parameters::default() });
    let mut before = f64::INFINITY;
    for stiffness in [1e4, 1e5, 1e6, 1e7] {
        let faces = [Face { stiffness, damping: 0.01 * stiffness }; 2];
        let soft = run(Parameters { contact_model: ContactModel::Compliant, faces, ..Parameters::default() });
        let error = (soft.0[0] - rigid.0[0]).abs();
        println!("{stiffness:e}: {error:e} rad, forces {:?} {:?}, losses {:e} {:e}", soft.1, rigid.1, soft.2, rigid.2);
        assert!(error < before / 8.0, "{stiffness:e}: {error:e} after {before:e}");
        before = error;
    }
    assert!(before < 1e-6, "{before:e}");
}

/// One step over everything, many small ones, steps of all sizes, a clone, a state from a text format: the same motion, and
/// for the last two the same bits.
#[test]
fn steps_of_any_size_go_the_same_way() {
    for contact_model in [ContactModel::Unilateral, ContactModel::Compliant] {
        let start = Start { theta: [-0.01, 0.03], theta_dot: [0.5, 0.0], ..Start::default() };
        // Elastic impacts: of plastic ones some dozen come at once, and make of the last bit of a start a difference that is seen.
        let parameters = Parameters { contact_model, restitution: 1.0, start, ..Parameters::default() };
        let plant = Plant::new(parameters).unwrap();
        let inputs = Inputs { torque_command: [0.1, -0.1], ..Inputs::ZERO };
        let mut plants = vec![plant; 3];
        let total = 0.256;
        plants[0].step(total, &inputs, &Inputs::ZERO).unwrap();
        (0..256).for_each(|_| plants[1].step(total / 256.0, &inputs, &Inputs::ZERO).unwrap());
        let (mut done, mut i) = (0.0, 0);
        while done < total {
            let h = (1e-3 * (1.1 + f64::from(i).sin())).min(total - done);
            plants[2].step(h, &inputs, &Inputs::ZERO).unwrap();
            (done, i) = (done + h, i + 1);
        }
        let switches = plants[0].state().contact.as_deref().unwrap();
        println!("{contact_model:?} {switches:?}");
        assert!(switches.impacts[0] >= 1 && switches.impacts[1] >= 1, "{switches:?}");
        for other in &plants[1..] {
            assert_eq!(other.state().contact.as_deref().unwrap().impacts, switches.impacts);
            let (a, b) = (plants[0].measured(), other.measured());
            assert!((a.theta[0] - b.theta[0]).abs() < 1e-11 && (a.y_object - b.y_object).abs() < 1e-11);
            assert!((a.tip_shear[0] - b.tip_shear[0]).abs() < 1e-8);
        }
        let text = serde_json::to_string(plants[2].state()).unwrap();
        let mut read = Plant::new(plants[2].parameters().clone()).unwrap();
        read.set_state(&serde_json::from_str(&text).unwrap()).unwrap();
        let mut clone = plants[2].clone();
        for plant in [&mut read, &mut clone] {
            (0..50).for_each(|_| plant.step(2e-3, &Inputs::ZERO, &Inputs::ZERO).unwrap());
        }
        assert_eq!(read.state(), clone.state());
        let glued = Plant::new(Parameters::default()).unwrap();
        assert_eq!(plants[2].clone().set_state(glued.state()), Err(StateError::Length { found: 33, expected: 37 }));
    }
}

/// Rates are the derivatives of what is read: in flight, with one tip, with both, pressed in or relaxing.
#[test]
fn rates_and_directional_derivatives_are_derivatives() {
    for contact_model in [ContactModel::Unilateral, ContactModel::Compliant] {
        let start = Start { theta: [-0.01, 0.012], theta_dot: [0.5, 0.0], ..Start::default() };
        let mut plant = Plant::new(Parameters { contact_model, start, ..Parameters::default() }).unwrap();
        let inputs = Inputs { torque_command: [0.1, -0.1], force_command: 0.01, ..Inputs::ZERO };
        let rates = Inputs { torque_command: [0.3, 0.1], force_command: 0.2, object_disturbance: 0.1, ..Inputs::ZERO };
        let mut seen = [false; 4];
        for i in 0..400 {
            let h = 2e-9;
            let mut later = plant.clone();
            later.step(h, &inputs, &rates).unwrap();
            let touching = |plant: &Plant| plant.state().contact.as_deref().unwrap().touching;
            let [first, second] = touching(&plant);
            if touching(&plant) == touching(&later) {
                seen[usize::from(first) + 2 * usize::from(second)] = true;
                let exact = plant.rates(&inputs, &rates);
                let after = Inputs {
                    torque_command: [0.1 + 0.3 * h, -0.1 + 0.1 * h],
                    force_command: 0.01 + 0.2 * h,
                    object_disturbance: 0.1 * h,
                    ..Inputs::ZERO
                };
                let close = |now: f64, then: f64, exact: f64, scale: f64, what: &str| {
                    let difference = (then - now) / h;
                    // The second derivative, over 2 ns, and rounding.
                    assert!((difference - exact).abs() < scale, "{i} {what}: {difference} {exact}");
                };
                let (c, d) = (plant.contact(), later.contact());
                let (f, g) = (plant.direct(&inputs).contact_force, later.direct(&after).contact_force);
                for side in 0..2 {
                    close(c.gap[side], d.gap[side], exact.contact.gap[side], 1e-4, "gap");
                    close(c.indentation[side], d.indentation[side], exact.contact.indentation[side], 1e-4, "face");
                    let scale = 1.0 + 2e-2 * exact.direct.contact_force[side].abs();
                    close(f[side], g[side], exact.direct.contact_force[side], scale, "force");
                }
                close(c.loss, d.loss, exact.contact.loss, 1e-4, "loss");
                close(plant.energy(), later.energy(), exact.energy, 1e-2 * (1.0 + exact.energy.abs()), "energy");
                let (a, b) = (plant.measured(), later.measured());
                close(a.theta[0], b.theta[0], exact.measured.theta[0], 1e-4, "angle");
                close(
                    a.tip_shear[1],
                    b.tip_shear[1],
                    exact.measured.tip_shear[1],
                    1.0 + 1e-2 * exact.measured.tip_shear[1].abs(),
                    "shear",
                );
                let direction = Inputs { force_command: 1.0, object_disturbance: 2.0, ..Inputs::ZERO };
                let moved = Inputs { force_command: 0.01 + 1e-4, object_disturbance: 2e-4, ..inputs };
                let change = plant.direct_derivative(&inputs, &direction).contact_force;
                let pushed = plant.direct(&moved).contact_force;
                for side in 0..2 {
                    let linear = f[side] + 1e-4 * change[side];
                    // Unless the push opens a contact.
                    assert!((pushed[side] - linear).abs() < 1e-12 || pushed.contains(&0.0), "{i} {pushed:?} {linear}");
                }
            }
            plant.step(1e-3, &inputs, &Inputs::ZERO).unwrap();
        }
        assert!(seen[0] && seen[3] && (seen[1] || seen[2]), "{contact_model:?} {seen:?}");
    }
}

/// Held where it only just touches, with forces that are nothing but rounding; pushed to and fro by as little: no step fails.
#[test]
fn grazes_and_rest_are_no_trouble() {
    for contact_model in [ContactModel::Unilateral, ContactModel::Compliant] {
        for restitution in [0.0, 0.9] {
            let parameters = Parameters { contact_model, restitution, ..Parameters::default() };
            let mut plant = Plant::new(parameters).unwrap();
            for i in 0..300 {
                let tiny = [0.0, 1e-17, -1e-17, 1e-12, -1e-12, 1e-9][i % 6];
                let inputs = Inputs { force_command: tiny, torque_command: [tiny, -tiny], ..Inputs::ZERO };
                plant.step([1e-3, 1e-6, 0.02][i % 3], &inputs, &Inputs::ZERO).unwrap();
            }
            // The squeeze that follows is the same as ever.
            let inputs = Inputs { torque_command: [0.1, -0.1], ..Inputs::ZERO };
            (0..300).for_each(|_| plant.step(0.01, &inputs, &Inputs::ZERO).unwrap());
            let force = plant.direct(&inputs).contact_force;
            assert!((force[0] - 0.5).abs() < 1e-3 && (force[1] - 0.5).abs() < 1e-3, "{contact_model:?} {force:?}");
        }
    }
}

/// A step that cannot be resolved is refused with the reason, and the plant is as it was.
#[test]
fn a_step_with_too_many_switches_is_refused_and_changes_nothing() {
    let light = Arm { ei: 1e-9, rho: 1e-9, hub_inertia: 1e-9, tip_mass: 0.1 };
    let parameters = Parameters {
        arms: [light; 2],
        order: 4,
        restitution: 0.9999,
        plastic_speed: 1e-9,
        start: Start { theta: [-1e-4, 0.5], ..Start::default() },
        ..conservative(ContactModel::Unilateral)
    };
    let mut plant = Plant::new(parameters).unwrap();
    let inputs = Inputs { force_command: -300.0, ..Inputs::ZERO };
    let before = plant.clone();
    let error = plant.step(50.0, &inputs, &Inputs::ZERO).unwrap_err();
    assert_eq!(
        error.to_string(),
        "a step of 5e1 s cannot be resolved: the contacts switch more than 20001 times; take a shorter one"
    );
    assert_eq!(plant.state(), before.state());
    let mut other = before;
    for plant in [&mut plant, &mut other] {
        plant.step(1e-3, &inputs, &Inputs::ZERO).unwrap();
    }
    assert_eq!(plant.state(), other.state());
}

/// With damped arms and ΔF a rigid contact can have no next mode (`contact/endless.rs`): its step is refused with a remedy, and changes
/// nothing. Without one of them, or with soft faces, every step of the same grasp is taken.
#[test]
fn damped_arms_with_rigid_faces_need_no_shorter_steps_but_no_built_in_force() {
    let inputs = Inputs { torque_command: [0.5, 0.0], ..Inputs::ZERO };
    let both =
        Parameters { order: 12, kelvin_voigt: 1e-5, contact_model: ContactModel::Unilateral, ..Parameters::default() };
    for parameters in [
        Parameters { tip_uncertainty: 0.0, ..both.clone() },
        Parameters { kelvin_voigt: 0.0, ..both.clone() },
        Parameters { contact_model: ContactModel::Compliant, ..both.clone() },
    ] {
        let mut plant = Plant::new(parameters).unwrap();
        for _ in 0..50 {
            plant.step(1e-3, &inputs, &Inputs::ZERO).unwrap();
        }
    }
    for h in [1e-3, 1e-4] {
        let mut plant = Plant::new(both.clone()).unwrap();
        let mut before = plant.state().clone();
        let error = loop {
            match plant.step(h, &inputs, &Inputs::ZERO) {
                Ok(()) => before = plant.state().clone(),
                Err(error) => break error,
            }
        };
        assert!(matches!(error, StepError::Endless { .. }), "{error}");
        assert!(error.to_string().contains("set one of these to 0, or contact_model to compliant"), "{error}");
        assert_eq!(*plant.state(), before);
    }
}
