//! Linear feedback of the measured signals, in error coordinates.

use crate::Grasp;
use crate::root_strain::Port;

/// τ_i = −(angle e + rate ė + moment M̃ + moment_rate M̃̇), with M̃ = EI q''(0).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct HubFeedback {
    /// \[N·m/rad\].
    pub angle: f64,
    /// \[N·m·s/rad\].
    pub rate: f64,
    /// \[1\].
    pub moment: f64,
    /// \[s\].
    pub moment_rate: f64,
}

/// v = −(position p + rate ṗ + Σ (shear_i Q̃_i + shear_rate_i Q̃̇_i)), with Q̃_i = EI_i q_i'''(l).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ObjectFeedback {
    /// \[N/m\].
    pub position: f64,
    /// \[N·s/m\].
    pub rate: f64,
    /// \[1\], by arm.
    pub shear: [f64; 2],
    /// \[s\], by arm.
    pub shear_rate: [f64; 2],
}

/// Plant and law as one linear loop. [`Default`] is the plant alone.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LinearLoop {
    /// Hub loops.
    pub hub: [HubFeedback; 2],
    /// The object's loop.
    pub object: ObjectFeedback,
}

impl LinearLoop {
    /// PD, (97) and (98), or PDS, (95) and (96), with strain gains `ks` (0 for PD).
    #[must_use]
    pub fn pds(object: [f64; 2], angle: [f64; 2], rate: [f64; 2], ks: [f64; 2]) -> Self {
        // The law's +EI q''(0) and +ΣEI q'''(l) cancel the loads on hub and object.
        let hub =
            |i: usize| HubFeedback { angle: angle[i], rate: rate[i], moment: ks[i] - 1.0, ..HubFeedback::default() };
        let object = ObjectFeedback { position: object[0], rate: object[1], shear: [-1.0; 2], shear_rate: [0.0; 2] };
        Self { hub: [hub(0), hub(1)], object }
    }

    /// The root-strain law without observers, with straight surface and unfiltered rates, and the effect of the built-in
    /// uncertainties.
    #[must_use]
    pub fn root_strain(ports: &[Port; 3]) -> Self {
        let hub = |port: &Port| {
            let [position, rate, load, load_rate] = port.feedback();
            HubFeedback { angle: position, rate, moment: load, moment_rate: load_rate + port.load_rate }
        };
        let [position, rate, load, load_rate] = ports[2].feedback();
        let shear_rate = [load_rate + ports[2].load_rate; 2];
        let object = ObjectFeedback { position, rate, shear: [load; 2], shear_rate };
        Self { hub: [hub(&ports[0]), hub(&ports[1])], object }
    }

    /// The same loop with the built-in uncertainties of Section IV, c_f and c_F \[s\].
    #[must_use]
    pub fn with_uncertainties(mut self, grasp: &Grasp, c_f: f64, c_force: f64) -> Self {
        let both = grasp.arms[0].ei + grasp.arms[1].ei;
        for i in 0..2 {
            self.hub[i].moment_rate += c_f;
            self.object.shear_rate[i] += c_force * both / grasp.arms[i].ei;
        }
        self
    }
}
