//! The linear system of each mode.
//!
//! With nothing touching, x (see [`Layout`]) obeys ẋ = A x + B g, assembled from the same beams as the bilateral plant, but with
//! a boundary velocity v_i(l) of its own at each tip and a mass there:
//!
//! ```text
//! ȧ_i = η(0) θ̇_i + η'(l) v_i(l) − Gᵀ b_i,    m_i v̇_i(l) = −S_i,    M ÿ_M = u + ΔF_ext,    S_i = EI_i (w_i''' + κ ẇ_i''')(l).
//! ```
//!
//! N_i reads the rate of gap i from x, and N_iᵀ f_i is what a contact force does to it (equal and opposite on tip and object).
//! A rigid side that touches has N_i x = 0. In coordinates whose half square is energy, the motion that obeys it is the
//! orthogonal projection P of the free one: ẋ = P A x + P B g. P puts the touching masses together, m_1 + M, m_2 + M or
//! m_1 + m_2 + M, and as x ← P x it is the plastic impact. A compliant side adds ė = −√k N x and f = √k e − c N x, e = √k δ.

use super::layout::{Layout, SIGN};
use crate::beam::Beam;
use crate::dynamics::{FORCES, ROOT_MOMENT, ROOT_MOMENT_RATE, TIP_SHEAR, TIP_SHEAR_RATE, VELOCITY};
use crate::kernel::{LANES, product};
use crate::parameters::{ContactModel, Parameters};
use nalgebra::{DMatrix, RowDVector};

/// Which sides touch.
pub(super) type Touching = [bool; 2];

/// What is the same in all modes.
pub(super) struct Assembly<'a> {
    parameters: &'a Parameters,
    pub layout: Layout,
    /// A with nothing touching: the part without dissipation, exactly skew, and the rest.
    skew: DMatrix<f64>,
    losses: DMatrix<f64>,
    /// ΔF, built in.
    uncertainty: RowDVector<f64>,
    /// Rows of the signals, in the plant's order.
    pub signals: DMatrix<f64>,
    /// Rows of S_i.
    pub shear: [RowDVector<f64>; 2],
    /// N_i.
    pub opening: [RowDVector<f64>; 2],
    roots_of_tip_mass: [f64; 2],
    root_of_object_mass: f64,
}

/// One mode.
pub(super) struct ModeMatrices {
    /// The extended system 𝒜.
    pub matrix: DMatrix<f64>,
    /// By side, a row over the extended vector: the contact force where a rigid side touches, else the rate of the gap.
    pub watched: [RowDVector<f64>; 2],
    /// By side: the contact force, zero where nothing touches.
    pub force: [RowDVector<f64>; 2],
}

impl<'a> Assembly<'a> {
    pub fn new(parameters: &'a Parameters) -> Self {
        let p = parameters;
        let layout = Layout { order: p.order };
        let (moments, n) = (2 * p.order, layout.size());
        let beams = p.arms.each_ref().map(|arm| Beam::new(arm, p.length, p.order));
        let roots_of_tip_mass = p.arms.map(|arm| arm.tip_mass.sqrt());
        let root_of_object_mass = p.object_mass.sqrt();
        // From the velocities to the rates of the moments.
        let mut rates = DMatrix::zeros(moments, n);
        for (arm, beam) in beams.iter().enumerate() {
            let mut rows = rates.rows_mut(layout.moments(arm), p.order);
            rows.columns_mut(layout.field(arm), p.order - 1).copy_from(&-beam.stiffness.transpose());
            rows.column_mut(layout.hub(arm)).copy_from(&(beam.root.transpose() / p.arms[arm].hub_inertia.sqrt()));
            rows.column_mut(layout.tip(arm)).copy_from(&(beam.tip.transpose() / roots_of_tip_mass[arm]));
        }
        let mut signals = DMatrix::zeros(LANES, n);
        for arm in 0..2 {
            signals[(VELOCITY[arm], layout.hub(arm))] = 1.0 / p.arms[arm].hub_inertia.sqrt();
            let place = (0, layout.moments(arm));
            let reads = |row: &RowDVector<f64>| {
                let mut reads = RowDVector::zeros(n);
                reads.view_mut(place, (1, p.order)).copy_from(row);
                reads
            };
            for (row, rate, of) in [
                (ROOT_MOMENT[arm], ROOT_MOMENT_RATE[arm], reads(&beams[arm].root)),
                (TIP_SHEAR[arm], TIP_SHEAR_RATE[arm], reads(&beams[arm].tip)),
            ] {
                signals.row_mut(row).copy_from(&of);
                let of_rates = product(&DMatrix::from_rows(&[of.columns(0, moments).into_owned()]), &rates);
                signals.row_mut(rate).copy_from(&of_rates);
            }
        }
        signals[(VELOCITY[2], layout.object())] = 1.0 / root_of_object_mass;

        let mut skew = DMatrix::zeros(n, n);
        skew.columns_mut(0, moments).copy_from(&-rates.transpose());
        skew.rows_mut(0, moments).copy_from(&rates);
        let total: f64 = p.arms.iter().map(|arm| arm.ei).sum();
        let mut losses = product(&rates.transpose(), &rates) * -p.kelvin_voigt;
        let mut shear: [RowDVector<f64>; 2] = [RowDVector::zeros(n), RowDVector::zeros(n)];
        let mut opening = shear.clone();
        let mut uncertainty = RowDVector::zeros(n);
        for arm in 0..2 {
            let (moment_rate, shear_rate) = (signals.row(ROOT_MOMENT_RATE[arm]), signals.row(TIP_SHEAR_RATE[arm]));
            let mut hub = losses.row_mut(layout.hub(arm));
            hub -= moment_rate * (p.root_uncertainty / p.arms[arm].hub_inertia.sqrt());
            uncertainty -= shear_rate * (p.tip_uncertainty * total / p.arms[arm].ei);
            shear[arm] = signals.row(TIP_SHEAR[arm]) + shear_rate * p.kelvin_voigt;
            opening[arm][layout.tip(arm)] = SIGN[arm] / roots_of_tip_mass[arm];
            opening[arm][layout.object()] = -SIGN[arm] / root_of_object_mass;
        }
        Self {
            parameters,
            layout,
            skew,
            losses,
            uncertainty,
            signals,
            shear,
            opening,
            roots_of_tip_mass,
            root_of_object_mass,
        }
    }

    /// What takes energy in a mode. ΔF is there while both tips touch, and gives tips and object one acceleration.
    fn losses(&self, touching: Touching) -> DMatrix<f64> {
        let mut losses = self.losses.clone();
        if touching == [true; 2] {
            let mass = self.parameters.moving_mass();
            let bodies = [
                (self.layout.tip(0), self.roots_of_tip_mass[0]),
                (self.layout.tip(1), self.roots_of_tip_mass[1]),
                (self.layout.object(), self.root_of_object_mass),
            ];
            for (place, root) in bodies {
                let mut row = losses.row_mut(place);
                row += &self.uncertainty * (root / mass);
            }
        }
        losses
    }

    /// The places of the masses that are one when these rigid sides touch, and the roots of these masses over the root of
    /// their sum: the unit vector of their common motion.
    fn merged(&self, touching: Touching) -> Vec<(usize, f64)> {
        let mut masses: Vec<(usize, f64)> =
            (0..2).filter(|i| touching[*i]).map(|i| (self.layout.tip(i), self.roots_of_tip_mass[i])).collect();
        masses.push((self.layout.object(), self.root_of_object_mass));
        let root = masses.iter().map(|(_, root)| root * root).sum::<f64>().sqrt();
        masses.iter().map(|(place, mass)| (*place, mass / root)).collect()
    }

    /// Replaces the rows of the merged masses by their projection on the common motion.
    fn project_rows(&self, matrix: &mut DMatrix<f64>, touching: Touching) {
        let merged = self.merged(touching);
        for mut column in matrix.column_iter_mut() {
            let common: f64 = merged.iter().map(|(place, share)| share * column[*place]).sum();
            for (place, share) in &merged {
                column[*place] = share * common;
            }
        }
    }

    /// B, shape n × 3: torques on the hubs, the force on the object.
    fn inputs(&self) -> DMatrix<f64> {
        let mut inputs = DMatrix::zeros(self.layout.size(), FORCES);
        for arm in 0..2 {
            inputs[(self.layout.hub(arm), arm)] = 1.0 / self.parameters.arms[arm].hub_inertia.sqrt();
        }
        inputs[(self.layout.object(), 2)] = 1.0 / self.root_of_object_mass;
        inputs
    }

    /// The mode in which these sides touch.
    pub fn mode(&self, touching: Touching) -> ModeMatrices {
        match self.parameters.contact_model {
            ContactModel::Compliant => self.compliant(touching),
            ContactModel::Bilateral | ContactModel::Unilateral => self.rigid(touching),
        }
    }

    fn rigid(&self, touching: Touching) -> ModeMatrices {
        let (layout, n) = (self.layout, self.layout.size());
        let mut skew = self.skew.clone();
        self.project_rows(&mut skew, touching);
        skew = skew.transpose();
        self.project_rows(&mut skew, touching);
        // P A P is skew where A is; rounding is made to follow.
        let skew = (&skew.transpose() - &skew) * 0.5;
        let mut losses = self.losses(touching).transpose();
        self.project_rows(&mut losses, touching);
        losses = losses.transpose();
        self.project_rows(&mut losses, touching);
        let mut inputs = self.inputs();
        self.project_rows(&mut inputs, touching);
        let mut matrix = self.extended(&(skew + losses), &inputs);

        // λ_i = S_i + m_i a, a being what their common acceleration is without ΔF, which each mass has from elsewhere.
        let p = self.parameters;
        let mass: f64 = p.object_mass + (0..2).filter(|i| touching[*i]).map(|i| p.arms[i].tip_mass).sum::<f64>();
        let mut acceleration = RowDVector::zeros(layout.extended());
        acceleration[layout.force() + 2] = 1.0 / mass;
        for arm in (0..2).filter(|i| touching[*i]) {
            let mut part = acceleration.columns_mut(0, n);
            part -= &self.shear[arm] / mass;
        }
        let mut watched = self.opening_rows();
        let mut force = [RowDVector::zeros(layout.extended()), RowDVector::zeros(layout.extended())];
        for arm in (0..2).filter(|i| touching[*i]) {
            let mut lambda = &acceleration * p.arms[arm].tip_mass;
            let mut part = lambda.columns_mut(0, n);
            part += &self.shear[arm];
            force[arm] = lambda * SIGN[arm];
            watched[arm] = force[arm].clone();
            matrix.row_mut(layout.opening() + arm).fill(0.0);
        }
        ModeMatrices { matrix, watched, force }
    }

    fn compliant(&self, touching: Touching) -> ModeMatrices {
        let (layout, n) = (self.layout, self.layout.size());
        let mut system = &self.skew + self.losses(touching);
        let mut force = [RowDVector::zeros(layout.extended()), RowDVector::zeros(layout.extended())];
        for arm in (0..2).filter(|i| touching[*i]) {
            let face = &self.parameters.faces[arm];
            let (opening, place, root) = (&self.opening[arm], layout.face(arm), face.stiffness.sqrt());
            let mut column = system.column_mut(place);
            column += opening.transpose() * root;
            let mut row = system.row_mut(place);
            row -= opening * root;
            system -= opening.transpose() * (opening * face.damping);
            let mut part = force[arm].columns_mut(0, n);
            part -= opening * face.damping;
            force[arm][place] = root;
        }
        let matrix = self.extended(&system, &self.inputs());
        ModeMatrices { matrix, watched: self.opening_rows(), force }
    }

    /// N_i over the extended vector.
    fn opening_rows(&self) -> [RowDVector<f64>; 2] {
        self.opening.each_ref().map(|row| {
            let mut extended = RowDVector::zeros(self.layout.extended());
            extended.columns_mut(0, row.len()).copy_from(row);
            extended
        })
    }

    fn extended(&self, system: &DMatrix<f64>, inputs: &DMatrix<f64>) -> DMatrix<f64> {
        let (layout, n) = (self.layout, self.layout.size());
        let mut matrix = DMatrix::zeros(layout.extended(), layout.extended());
        matrix.view_mut((0, 0), (n, n)).copy_from(system);
        matrix.view_mut((0, layout.force()), (n, FORCES)).copy_from(inputs);
        for (i, row) in VELOCITY.into_iter().enumerate() {
            matrix.view_mut((layout.travel() + i, 0), (1, n)).copy_from(&self.signals.row(row));
        }
        for (i, row) in self.opening.iter().enumerate() {
            matrix.view_mut((layout.opening() + i, 0), (1, n)).copy_from(row);
        }
        matrix.view_mut((layout.travel_integral(), layout.travel()), (FORCES, FORCES)).fill_with_identity();
        matrix.view_mut((layout.force(), layout.force_rate()), (FORCES, FORCES)).fill_with_identity();
        matrix
    }
}
