//! Time derivatives within a mode.

use super::Modes;
use super::layout::Layout;
use super::piece::Scratch;
use crate::kernel::LANES;

impl Modes {
    /// m.
    pub fn moving_mass(&self) -> f64 {
        self.tip_masses[0] + self.tip_masses[1] + self.object_mass
    }

    /// The rate of the distance between tip and face on a side that is open.
    pub fn gap_rate(&self, x: &[f64], side: usize) -> f64 {
        self.opening_rate(x, side) + self.relaxing(x, side) / self.faces[side].stiffness.sqrt()
    }

    /// The rate of a free face's coordinate.
    fn relaxing(&self, x: &[f64], side: usize) -> f64 {
        let deformed = x[self.layout.face(side)];
        if deformed == 0.0 { 0.0 } else { -self.relaxation[side] * deformed }
    }

    /// ẋ in the mode in which these sides touch: linear in x and g.
    pub fn rates(&self, touching: [bool; 2], x: &[f64], forces: &[f64]) -> Scratch {
        let layout = self.layout;
        let n = layout.size();
        let mut z = [[0.0; LANES]; Layout::MOST_PANELS];
        let flat = z.as_flattened_mut();
        flat[..n].copy_from_slice(x);
        flat[layout.force()..layout.force_rate()].copy_from_slice(forces);
        let mut rates = [[0.0; LANES]; Layout::MOST_PANELS];
        self.mode(touching).panels.multiply(&z.as_flattened()[..layout.extended()], &mut rates);
        let of_coordinates = rates.as_flattened_mut();
        of_coordinates[n..].fill(0.0);
        for side in (0..2).filter(|side| !self.rigid && !touching[*side]) {
            of_coordinates[layout.face(side)] = self.relaxing(x, side);
        }
        rates
    }

    /// What a compliant face takes \[W\], as the bilinear form of which the losses are the square.
    pub fn loss_rate(&self, touching: [bool; 2], x: &[f64], y: &[f64], side: usize) -> f64 {
        if self.rigid {
            return 0.0;
        }
        if touching[side] {
            return self.faces[side].damping * self.opening_rate(x, side) * self.opening_rate(y, side);
        }
        -x[self.layout.face(side)] * self.relaxing(y, side)
    }
}
