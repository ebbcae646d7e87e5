//! Contacts that open and close, at the moment when they do: the same whether a step finds that moment or the host of a solver.

use super::{ContactState, Modes};

impl Modes {
    /// Rigid sides that touch from now on; others that did open.
    pub fn touch(&self, x: &mut [f64], contact: &mut ContactState, touching: [bool; 2]) {
        for i in 0..2 {
            if contact.touching[i] && !touching[i] {
                contact.openings[i] = contact.openings[i].saturating_add(1);
            }
        }
        contact.touching = touching;
        self.merge(x, touching);
    }

    /// Rigid sides hit the object.
    pub fn hit(&self, x: &mut [f64], forces: &[f64], contact: &mut ContactState, closing: [bool; 2]) {
        for i in (0..2).filter(|i| closing[*i]) {
            contact.clearance[i] = 0.0;
            contact.impacts[i] = contact.impacts[i].saturating_add(1);
        }
        let (loss, together) = self.impact(x, contact.touching, closing);
        contact.loss += loss;
        let (_, pushing) = self.pushing(x, forces, together, Self::magnitude(x, forces));
        self.touch(x, contact, pushing);
    }

    /// The tip leaves a compliant face.
    pub fn leave(&self, x: &mut [f64], contact: &mut ContactState, side: usize) {
        contact.touching[side] = false;
        contact.openings[side] = contact.openings[side].saturating_add(1);
        let place = self.layout.face(side);
        if self.faces[side].damping == 0.0 {
            // A face without damping opens where it is not pressed in: what is left is rounding.
            x[place] = 0.0;
        }
        contact.clearance[side] = -x[place] / self.faces[side].stiffness.sqrt();
    }

    /// The tip comes onto a compliant face.
    pub fn meet(&self, x: &[f64], contact: &mut ContactState, side: usize) {
        contact.touching[side] = true;
        contact.impacts[side] = contact.impacts[side].saturating_add(1);
        contact.clearance[side] = -x[self.layout.face(side)] / self.faces[side].stiffness.sqrt();
    }
}
