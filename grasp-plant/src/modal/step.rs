//! The exact step of one size in modal coordinates, and the loops that every step comes down to.
//!
//! Four blocks side by side make a group, so that the compiler uses whole registers. As in the kernel of the dense plant nothing
//! is fused, and every sum has one order, whatever registers the processor has.

// Inlined into functions for wide registers, or the compiler does not use these registers.
#![allow(clippy::inline_always)]

use super::block::{Block, Functions};
use crate::cache::OfOneSize;
use crate::dynamics::{FORCES, SIGNALS, Signals};

/// Blocks side by side.
pub(super) const LANES: usize = 4;

/// Numbers of as many blocks.
pub(super) type Lanes = [f64; LANES];

/// Coordinates of a group: the first of each block, then the second.
pub(super) const GROUP: usize = 2 * LANES;

/// Coordinates smaller than this \[√J\] become zero after a step. A decaying motion would otherwise end in subnormal
/// numbers, on which processors are a hundred times slower; the energy given up is below the smallest normal number.
pub(crate) const NEGLIGIBLE: f64 = 1e-150;

/// What a force does to the two coordinates of each block, by force.
type Gain = [[Lanes; FORCES]; 2];

/// What a step of one size does to a group.
#[derive(Clone, Copy, Debug)]
struct Held {
    /// e^{Λh} − I.
    increment: [[Lanes; 2]; 2],
    /// h φ_1 Γ.
    gain: Gain,
}

/// What more is to be known of ramps.
#[derive(Clone, Copy, Debug)]
struct Ramped {
    /// h² φ_2 Γ: what a slope does to the coordinates, and a force to their integral.
    gain: Gain,
    /// h (φ_1 − I): the integral of what the coordinates travel from where they were.
    integral: [[Lanes; 2]; 2],
    /// h³ φ_3 Γ.
    integral_gain: Gain,
}

/// The exact step of one size.
#[derive(Clone, Debug)]
pub(crate) struct Table {
    h: f64,
    held: Vec<Held>,
    ramped: Vec<Ramped>,
}

/// The rigid motion: ζ̇ = gain·g, and the object rises as velocity·ζ + drift·g besides what the blocks make it rise.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rigid {
    pub gain: [f64; FORCES],
    pub velocity: f64,
    pub drift: [f64; FORCES],
}

/// What a step changes besides the coordinates.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Travel {
    /// By how much w_1(l), w_2(l) and y_M have risen \[m\].
    pub total: [f64; FORCES],
    /// The integral of that over the step \[m s\]; only of ramps.
    pub integral: [f64; FORCES],
}

impl Travel {
    /// The same as the forces see it: of θ_1, θ_2 and y_M. By (12), l Δθ_i = Δw_i(l) + Δy_M.
    #[inline]
    pub fn of_forces(&self, length: f64) -> ([f64; FORCES], [f64; FORCES]) {
        let turned =
            |values: [f64; FORCES]| [(values[0] + values[2]) / length, (values[1] + values[2]) / length, values[2]];
        (turned(self.total), turned(self.integral))
    }
}

impl Table {
    /// Room for the steps of so many blocks.
    pub fn new(blocks: usize) -> Self {
        let gain = [[[0.0; LANES]; FORCES]; 2];
        let square = [[[0.0; LANES]; 2]; 2];
        let groups = blocks.div_ceil(LANES);
        Self {
            h: 0.0,
            held: vec![Held { increment: square, gain }; groups],
            ramped: vec![Ramped { gain, integral: square, integral_gain: gain }; groups],
        }
    }

    /// Becomes the step of size h of these blocks, with what the forces do to each.
    pub(super) fn fill(&mut self, h: f64, blocks: &[Block], gains: &[[[f64; FORCES]; 2]]) {
        self.h = h;
        for (i, (block, gain)) in blocks.iter().zip(gains).enumerate() {
            let (held, ramped) = (&mut self.held[i / LANES], &mut self.ramped[i / LANES]);
            let lane = i % LANES;
            let Functions { increment, first_less_one, second, third } = block.functions(h);
            let (h_2, h_3) = (h * h, h * h * h);
            for r in 0..2 {
                for c in 0..2 {
                    held.increment[r][c][lane] = increment[r][c];
                    ramped.integral[r][c][lane] = h * first_less_one[r][c];
                }
                for f in 0..FORCES {
                    let (own, other) = (gain[r][f], gain[1 - r][f]);
                    held.gain[r][f][lane] = h * (own + (first_less_one[r][r] * own + first_less_one[r][1 - r] * other));
                    ramped.gain[r][f][lane] = h_2 * (second[r][r] * own + second[r][1 - r] * other);
                    ramped.integral_gain[r][f][lane] = h_3 * (third[r][r] * own + third[r][1 - r] * other);
                }
            }
        }
    }

    /// Every number, padding included.
    #[cfg(test)]
    pub fn entries(&self) -> impl Iterator<Item = &f64> {
        let held = self.held.iter().flat_map(|h| h.increment.as_flattened().iter().chain(h.gain.as_flattened()));
        let ramped = self.ramped.iter().flat_map(|r| {
            r.gain.as_flattened().iter().chain(r.integral.as_flattened()).chain(r.integral_gain.as_flattened())
        });
        held.chain(ramped).flatten()
    }
}

impl OfOneSize for Table {
    fn step_size(&self) -> f64 {
        self.h
    }
}

/// What is read from the coordinates.
#[derive(Clone, Debug)]
pub(super) struct Readings {
    /// Signals per coordinate of each group, and per ζ.
    pub signals: Vec<[Signals; GROUP]>,
    pub rigid: Signals,
    /// w_1(l), w_2(l) and y_M per coordinate.
    pub positions: Vec<[[Lanes; 2]; FORCES]>,
}

impl Readings {
    /// The signals of coordinates.
    #[inline(always)]
    fn signals_here(&self, coordinates: &[f64]) -> Signals {
        let (groups, rest) = coordinates.as_chunks::<GROUP>();
        let (mut first, mut second) = ([0.0; SIGNALS], [0.0; SIGNALS]);
        for (columns, group) in self.signals.iter().zip(groups) {
            for lane in 0..LANES {
                let (x, y) = (group[lane], group[LANES + lane]);
                for row in 0..SIGNALS {
                    first[row] += columns[lane][row] * x;
                    second[row] += columns[LANES + lane][row] * y;
                }
            }
        }
        let rigid = rest.first().copied().unwrap_or_default();
        std::array::from_fn(|row| first[row] + second[row] + self.rigid[row] * rigid)
    }

    /// w_1(l) and w_2(l).
    pub fn tip_deflection(&self, coordinates: &[f64]) -> [f64; 2] {
        let (groups, _) = coordinates.as_chunks::<GROUP>();
        let mut tips = [0.0; 2];
        for (positions, group) in self.positions.iter().zip(groups) {
            for (tip, position) in tips.iter_mut().zip(positions) {
                *tip += position.as_flattened().iter().zip(group).map(|(position, z)| position * z).sum::<f64>();
            }
        }
        tips
    }

    #[inline]
    pub fn signals(&self, coordinates: &[f64]) -> Signals {
        #[cfg(target_arch = "x86_64")]
        if crate::kernel::has_wide_registers() {
            // SAFETY: the processor has it.
            return unsafe { self.signals_wide(coordinates) };
        }
        self.signals_here(coordinates)
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx")]
    fn signals_wide(&self, coordinates: &[f64]) -> Signals {
        self.signals_here(coordinates)
    }
}

/// A step with forces g + r t: where to begin, and what happens.
#[derive(Clone, Copy)]
pub(super) struct Motion<'a> {
    pub table: &'a Table,
    pub readings: &'a Readings,
    pub rigid: &'a Rigid,
    pub from: &'a [f64],
    pub forces: &'a [f64; FORCES],
    pub rates: Option<&'a [f64; FORCES]>,
}

impl Motion<'_> {
    /// Makes the step, into `next`; gives what it changes besides.
    #[inline]
    pub fn make(self, next: &mut [f64]) -> Travel {
        #[cfg(target_arch = "x86_64")]
        if crate::kernel::has_wide_registers() {
            // SAFETY: the processor has it.
            return unsafe { self.make_wide(next) };
        }
        self.make_here(next)
    }

    #[cfg(target_arch = "x86_64")]
    #[target_feature(enable = "avx")]
    fn make_wide(self, next: &mut [f64]) -> Travel {
        self.make_here(next)
    }

    #[inline(always)]
    fn make_here(self, next: &mut [f64]) -> Travel {
        let Self { table, readings, rigid, from, forces, rates } = self;
        let (from, rest) = from.as_chunks::<GROUP>();
        let (next, rest_next) = next.as_chunks_mut::<GROUP>();
        let (mut total, mut integral) = ([[0.0; LANES]; FORCES], [[0.0; LANES]; FORCES]);
        for (i, ((from, next), (held, positions))) in
            from.iter().zip(next).zip(table.held.iter().zip(&readings.positions)).enumerate()
        {
            let mut change = moved(from, &held.increment, &held.gain, forces);
            if let Some(rates) = rates {
                let ramped = &table.ramped[i];
                let more = driven(&ramped.gain, rates);
                let area = moved(from, &ramped.integral, &ramped.gain, forces);
                let area_more = driven(&ramped.integral_gain, rates);
                for c in 0..2 {
                    for lane in 0..LANES {
                        change[c][lane] += more[c][lane];
                    }
                }
                for (integral, position) in integral.iter_mut().zip(positions) {
                    for lane in 0..LANES {
                        integral[lane] += position[0][lane] * (area[0][lane] + area_more[0][lane])
                            + position[1][lane] * (area[1][lane] + area_more[1][lane]);
                    }
                }
            }
            // What the coordinates really change by, rounding included, so that positions and coordinates stay together.
            let mut real = [[0.0; LANES]; 2];
            for c in 0..2 {
                for lane in 0..LANES {
                    let before = from[c * LANES + lane];
                    let after = before + change[c][lane];
                    let after = if after.abs() < NEGLIGIBLE { 0.0 } else { after };
                    next[c * LANES + lane] = after;
                    real[c][lane] = after - before;
                }
            }
            for (total, position) in total.iter_mut().zip(positions) {
                for lane in 0..LANES {
                    total[lane] += position[0][lane] * real[0][lane] + position[1][lane] * real[1][lane];
                }
            }
        }
        let sum = |lanes: [Lanes; FORCES]| lanes.map(|l| (l[0] + l[1]) + (l[2] + l[3]));
        let mut travel = Travel { total: sum(total), integral: sum(integral) };
        let (Some(before), Some(after)) = (rest.first(), rest_next.first_mut()) else { return travel };
        rigid.step(table.h, *before, forces, rates, after, &mut travel);
        travel
    }
}

/// Matrix times coordinates, and gain times forces, of a group.
#[inline(always)]
fn moved(from: &[f64; GROUP], matrix: &[[Lanes; 2]; 2], gain: &Gain, forces: &[f64; FORCES]) -> [Lanes; 2] {
    let mut change = driven(gain, forces);
    for c in 0..2 {
        for lane in 0..LANES {
            change[c][lane] += matrix[c][0][lane] * from[lane] + matrix[c][1][lane] * from[LANES + lane];
        }
    }
    change
}

/// Gain times forces, of a group.
#[inline(always)]
fn driven(gain: &Gain, forces: &[f64; FORCES]) -> [Lanes; 2] {
    let mut change = [[0.0; LANES]; 2];
    for c in 0..2 {
        for lane in 0..LANES {
            change[c][lane] =
                gain[c][0][lane] * forces[0] + gain[c][1][lane] * forces[1] + gain[c][2][lane] * forces[2];
        }
    }
    change
}

impl Rigid {
    /// The rigid part of a step.
    #[inline(always)]
    fn step(
        &self,
        h: f64,
        before: f64,
        forces: &[f64; FORCES],
        rates: Option<&[f64; FORCES]>,
        after: &mut f64,
        travel: &mut Travel,
    ) {
        let with = |gain: &[f64; FORCES], by: &[f64; FORCES]| gain[0] * by[0] + gain[1] * by[1] + gain[2] * by[2];
        let (push, drift) = (with(&self.gain, forces), with(&self.drift, forces));
        let mut change = h * push;
        let mut rise = h * (self.velocity * (before + 0.5 * change) + drift);
        if let Some(rates) = rates {
            let (push_rate, drift_rate) = (with(&self.gain, rates), with(&self.drift, rates));
            let (h_2, sixth) = (h * h, 1.0 / 6.0);
            rise += h_2 * (self.velocity * (h * sixth) * push_rate + 0.5 * drift_rate);
            travel.integral[2] += h_2
                * (self.velocity * (0.5 * before + h * (sixth * push + h * (1.0 / 24.0) * push_rate))
                    + (0.5 * drift + h * sixth * drift_rate));
            change += 0.5 * h_2 * push_rate;
        }
        *after = before + change;
        if after.abs() < NEGLIGIBLE {
            *after = 0.0;
        }
        travel.total[2] += rise;
    }
}
