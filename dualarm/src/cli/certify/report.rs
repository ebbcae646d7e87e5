//! Results of `certify` about the paper's conditions, as text and as JSON.
// Formulas are written with the paper's letters, not as code.
#![allow(clippy::doc_markdown)]

use std::fmt;

use grasp_certify::corrected;
use grasp_certify::printed::{self, Bounds, Conflict, Verdict};
use grasp_certify::settings::Settings;
use serde::Serialize;

/// `--mode printed`.
#[derive(Serialize)]
pub struct Printed {
    command: &'static str,
    mode: &'static str,
    /// `feasible`, `infeasible`, `undecided`.
    verdict: &'static str,
    conflicts: Vec<Conflict>,
    bounds: Option<Bounds>,
    /// |p| at the start \[m\].
    start_position: f64,
    /// |e_i| at the start \[rad\].
    start_angle: [f64; 2],
    /// Force that (92) and (94) allow \[N\], by arm.
    force: Option<[f64; 2]>,
}

impl Printed {
    pub fn new(settings: &Settings) -> Self {
        let (grasp, gains) = (settings.grasp(), settings.printed_gains());
        let (angle, position) = settings.start_errors();
        let (verdict, conflicts, bounds) = match printed::decide(&grasp, &gains) {
            Verdict::Feasible(constants) => {
                let bounds = printed::bounds(&grasp, &gains, &settings.learning(), &constants);
                ("feasible", Vec::new(), Some(bounds))
            }
            Verdict::Infeasible(conflicts) => ("infeasible", conflicts, None),
            Verdict::Undecided => ("undecided", Vec::new(), None),
        };
        let force = bounds.map(|bounds| {
            std::array::from_fn(|i| grasp.tip_stiffness(i) * (grasp.length * bounds.angle[i] + bounds.position))
        });
        Self {
            command: "certify",
            mode: "printed",
            verdict,
            conflicts,
            bounds,
            start_position: position.abs(),
            start_angle: angle.map(f64::abs),
            force,
        }
    }
}

impl fmt::Display for Printed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "(71), (82)-(88) as printed: {}", self.verdict)?;
        for conflict in &self.conflicts {
            let Conflict { conditions, quantity, value, limit } = conflict;
            writeln!(f, "  {conditions} exclude each other: {quantity} {limit:.6} (it is {value:.6})")?;
        }
        if self.verdict == "undecided" {
            writeln!(f, "  too close to the limit to call; change a gain by a millionth")?;
        }
        let (Some(b), Some(force)) = (&self.bounds, &self.force) else { return Ok(()) };
        let c = &b.constants;
        writeln!(
            f,
            "  beta_1 {:.6}, beta_2 {:.6}, theta_1..3 {:.6} {:.6} {:.6}",
            c.beta_1, c.beta_2, c.theta_1, c.theta_2, c.theta_3
        )?;
        for i in 0..2 {
            writeln!(
                f,
                "  theta_4..7 of arm {}: {:.6} {:.6} {:.6} {:.6}",
                i + 1,
                c.theta_4[i],
                c.theta_5[i],
                c.theta_6[i],
                c.theta_7[i]
            )?;
        }
        writeln!(
            f,
            "  phi {:.4e} 1/s (as printed, divided by phi_2 = {:.4}: {:.4e}), h {:.4e}",
            b.phi, b.phi_2, b.phi_printed, b.h
        )?;
        writeln!(
            f,
            "  (92): |p| <= {:.1} mm in the end, at the start it is {:.4} mm; no gains promise less than {:.1} mm",
            1e3 * b.position,
            1e3 * self.start_position,
            1e3 * b.least_position
        )?;
        for (i, force) in force.iter().enumerate() {
            writeln!(
                f,
                "  (94): |e_{}| <= {:.3} rad, at the start {:.4}; never less than {:.3} rad. Force within {:.3e} mN",
                i + 1,
                b.angle[i],
                self.start_angle[i],
                b.least_angle[i],
                1e3 * force
            )?;
        }
        writeln!(f, "Corrected, no gains satisfy them: --mode corrected")
    }
}

/// `--mode corrected`.
#[derive(Serialize)]
pub struct Corrected {
    command: &'static str,
    mode: &'static str,
    /// g = mu_bar + c1 \[1/s\].
    g: f64,
    /// The form for the beta_1 that the printed conditions need at least.
    form: corrected::Form,
    /// Frequencies of motions that nothing damps \[rad/s\].
    undamped: Vec<f64>,
}

impl Corrected {
    pub fn new(settings: &Settings) -> Self {
        let (grasp, gains) = (settings.grasp(), settings.printed_gains());
        let ei = 0.5 * (grasp.arms[0].ei + grasp.arms[1].ei);
        let form = corrected::form(gains.g, printed::smallest_b_of_all() / (2.0 * ei), ei);
        Self {
            command: "certify",
            mode: "corrected",
            g: gains.g,
            form,
            undamped: corrected::undamped_frequencies(&grasp, 3),
        }
    }
}

impl fmt::Display for Corrected {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let form = &self.form;
        writeln!(f, "corrected: infeasible for all gains")?;
        writeln!(
            f,
            "  on s = 0 the object's part of dH/dt is exactly -g z^2 - (1+bg) z S - b S^2, which is never negative definite:"
        )?;
        writeln!(
            f,
            "  discriminant (1-bg)^2 = {:.6} with g = {} 1/s, b = beta_1 EI = {:.4};",
            form.discriminant, self.g, form.b
        )?;
        writeln!(f, "  at S = {:.4} z it is +{:.6} z^2", form.worst_shear, form.value)?;
        if self.undamped.is_empty() {
            return writeln!(
                f,
                "  (arms of different EI/rho have no motion of the kind q_1 = -q_2 that nothing damps)"
            );
        }
        let frequencies: Vec<String> = self.undamped.iter().map(|w| format!("{w:.3}")).collect();
        writeln!(
            f,
            "  Theorem 3 is false for Delta = 0: q_1 = -q_2, clamped at resting hubs and pinned at the resting object, has"
        )?;
        writeln!(f, "  s = s_1 = s_2 = 0 and swings for ever with {} rad/s, whatever the gains", frequencies.join(", "))
    }
}
