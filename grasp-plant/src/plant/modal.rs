//! Steps in modal coordinates.

use super::step::at;
use super::{Plant, Workspace};
use crate::dynamics::FORCES;
use crate::kernel::dot;
use crate::modal::Travel;
use crate::signals::Inputs;
use crate::state::{Basis, State};

impl Plant {
    /// One step whose forces have kinks at the given times, if any, into the workspace's next state. A size that does not
    /// repeat is not kept; the bits are the same.
    pub(super) fn modal_step(&mut self, h: f64, inputs: &Inputs, rates: &Inputs, kinks: &[f64], repeats: bool) {
        let Self { model, state, cache, work, .. } = self;
        let Some(modal) = model.modal() else { return };
        let Workspace { drive, next, table, .. } = work;
        next.coordinates.resize(modal.size());
        next.basis = modal.state_basis();
        next.supplied_energy = state.supplied_energy;
        let drive = &mut drive[..modal.size()];
        if kinks.is_empty() {
            let from = match state.basis {
                Basis::Modal | Basis::EvenAndOdd => &state.coordinates[..],
                Basis::Energy => {
                    modal.modal_coordinates(&state.coordinates, drive);
                    drive
                }
            };
            let table = if repeats {
                cache.tables.get(&model.tables, h, || modal.table_of(h))
            } else {
                let table = table.get_or_insert_with(|| modal.table());
                modal.fill(table, h);
                table
            };
            let forces = model.forces(inputs);
            let force_rates = (*rates != Inputs::ZERO).then(|| model.force_rates(&at(inputs, rates, h / 2.0), rates));
            let travel = modal.step(table, from, &forces, force_rates.as_ref(), &mut next.coordinates);
            let moved = conclude(next, h, &travel, &forces, force_rates.as_ref());
            next.travel(state, &moved);
            return;
        }
        match state.basis {
            Basis::Modal | Basis::EvenAndOdd => drive.copy_from_slice(&state.coordinates),
            Basis::Energy => modal.modal_coordinates(&state.coordinates, drive),
        }
        let table = table.get_or_insert_with(|| modal.table());
        let mut total = [0.0; FORCES];
        let mut begin = 0.0;
        for end in kinks.iter().copied().chain([h]) {
            let duration = end - begin;
            let forces = model.forces(&at(inputs, rates, begin));
            let force_rates = model.force_rates(&at(inputs, rates, f64::midpoint(begin, end)), rates);
            modal.fill(table, duration);
            let travel = modal.step(table, drive, &forces, Some(&force_rates), &mut next.coordinates);
            drive.copy_from_slice(&next.coordinates);
            let moved = conclude(next, duration, &travel, &forces, Some(&force_rates));
            for (total, moved) in total.iter_mut().zip(moved) {
                *total += moved;
            }
            begin = end;
        }
        next.travel(state, &total);
    }
}

/// Adds the work that forces g + r t have done; gives how far they have travelled.
#[inline]
fn conclude(
    next: &mut State,
    h: f64,
    travel: &Travel,
    forces: &[f64; FORCES],
    rates: Option<&[f64; FORCES]>,
) -> [f64; FORCES] {
    let Travel { total: moved, integral } = *travel;
    next.supplied_energy += dot(forces, &moved);
    if let Some(rates) = rates {
        // ∫ t Θ̇ dt = h Θ(h) − ∫ Θ dt
        next.supplied_energy += (0..FORCES).map(|i| rates[i] * (h * moved[i] - integral[i])).sum::<f64>();
    }
    moved
}
