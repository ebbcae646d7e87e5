//! Exact eigenvalues of the loops.

use std::fmt;

use grasp_certify::LinearLoop;
use grasp_certify::root_strain::Port;
use grasp_certify::settings::Settings;
use grasp_certify::spectrum::{Characteristic, Region, count, eigenvalues};
use serde::Serialize;

use super::Chart;
use super::draw::{Plane, plane};
use crate::cli::Failure;

/// Where they are looked for; no corner at a round number, on which an eigenvalue could lie.
const REGION: Region = Region { left: -140.37, right: 20.61, bottom: -1.073, top: 2000.9 };

/// `--map spectrum`.
#[derive(Serialize)]
pub struct Spectra {
    command: &'static str,
    map: &'static str,
    /// Left, right, bottom, top \[1/s\].
    region: [f64; 4],
    loops: Vec<Loop>,
}

#[derive(Serialize)]
struct Loop {
    title: &'static str,
    /// The count by the argument principle, with multiplicities.
    counted: u32,
    /// Real part, imaginary part \[1/s\], multiplicity.
    eigenvalues: Vec<(f64, f64, u32)>,
}

impl Spectra {
    pub fn new(settings: &Settings) -> Result<Self, Failure> {
        let grasp = settings.grasp();
        let paper = grasp_plant::Parameters::default();
        let uncertain = |law: LinearLoop| law.with_uncertainties(&grasp, paper.root_uncertainty, paper.tip_uncertainty);
        let pd = LinearLoop::pds([settings.pd.kp, settings.pd.kv], settings.pd.kp_arm, settings.pd.kv_arm, [0.0; 2]);
        let gains = &settings.pds;
        let pds = LinearLoop::pds([gains.kp, gains.kv], gains.kp_arm, gains.kv_arm, gains.ks_arm);
        let root = |settings: &Settings| {
            settings.ports().map(|ports| LinearLoop::root_strain(&ports.map(Port::without_observer)))
        };
        let mut certified = settings.clone();
        certified.set_preset("certified").map_err(Failure::failed)?;
        let loops = [
            ("no control", Some(uncertain(LinearLoop::default()))),
            ("PD", Some(uncertain(pd))),
            ("PDS", Some(uncertain(pds))),
            ("NABFC-R, certified, undamped plant", root(&certified)),
        ];
        let mut found = Vec::new();
        for (title, feedback) in loops {
            let Some(feedback) = feedback else { continue };
            let function = Characteristic { grasp, feedback, kelvin_voigt: settings.plant.kelvin_voigt };
            let counted = count(&function, &REGION).map_err(Failure::failed)?;
            let all = eigenvalues(&function, &REGION).map_err(Failure::failed)?;
            let eigenvalues = all.iter().map(|e| (e.s.re, e.s.im, e.multiplicity)).collect();
            found.push(Loop { title, counted, eigenvalues });
        }
        Ok(Self {
            command: "certify",
            map: "spectrum",
            region: [REGION.left, REGION.right, REGION.bottom, REGION.top],
            loops: found,
        })
    }
}

impl fmt::Display for Spectra {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [left, right, bottom, top] = self.region;
        writeln!(f, "Exact eigenvalues with {left} < Re < {right} and {bottom} < Im < {top} 1/s:")?;
        for each in &self.loops {
            let found: u32 = each.eigenvalues.iter().map(|(.., multiplicity)| multiplicity).sum();
            writeln!(f, "{}: {} counted by the argument principle, {found} found", each.title, each.counted)?;
            for (re, im, multiplicity) in &each.eigenvalues {
                let times = if *multiplicity > 1 { format!("  ({multiplicity} times)") } else { String::new() };
                writeln!(f, "  {re:>14.6} {im:>+14.6}j{times}")?;
            }
        }
        Ok(())
    }
}

impl Chart for Spectra {
    fn svg(&self) -> Option<String> {
        let sets: Vec<_> = self
            .loops
            .iter()
            .map(|each| Plane {
                name: format!("{} ({})", each.title, each.counted),
                points: each.eigenvalues.iter().map(|(re, im, _)| (*re, *im)).collect(),
            })
            .collect();
        Some(plane(&sets, self.region))
    }
}
