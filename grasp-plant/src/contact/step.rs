//! A step from switch to switch.

use super::impact::{ROUNDING, SIMULTANEOUS, forces_of};
use super::layout::SIGN;
use super::mode::{Mode, RUNGS};
use super::piece::{Motion, Piece};
use super::series::{Series, Undecided};
use super::{ContactState, Contacts, Modes, mode_index};
use crate::dynamics::{FORCES, Signals};
use crate::plant::{MAX_KINK_TIMES, Model, all_usable, at, flush};
use crate::signals::Inputs;
use crate::state::{State, StepError};
use crate::step_sizes::REMEMBERED;

/// Switches in one step after which it is refused: some seconds of computing time.
const MOST_SWITCHES: u32 = 20_000;

/// Switches at one instant after which the step is refused. Two sides can need four.
const MOST_AT_ONCE: u32 = 64;

/// What a part of a step works on.
struct Part<'a> {
    modes: &'a Modes,
    motion: &'a mut Motion,
    /// (x, g, r) at the time reached.
    drive: &'a mut [f64],
    /// The length of `drive` that counts: without the rates if they are zero.
    length: usize,
    contact: &'a mut ContactState,
    /// ∫(θ̇_1, θ̇_2, ẏ_M) and the work of the forces, of the step so far.
    travel: &'a mut [f64; FORCES],
    work: &'a mut f64,
    switches: &'a mut u32,
}

impl Contacts {
    /// Advances by h, exactly: the counterpart of [`Plant::step`](crate::Plant::step), which has checked its arguments.
    #[cold]
    pub fn step(
        &mut self,
        model: &Model,
        state: &mut State,
        signals: &mut Signals,
        h: f64,
        inputs: &Inputs,
        rates: &Inputs,
    ) -> Result<(), StepError> {
        // So that no later switch has to allocate.
        for mode in &self.modes.by_touching {
            mode.ladder();
        }
        let longest = self.longest_part();
        let Some(now) = state.contact.as_deref() else { return Err(StepError::Overflow) };
        let n = self.modes.layout.size();
        let mut contact = *now;
        let mut sizes = state.sizes;
        sizes.note(h);
        let mut times = [0.0; MAX_KINK_TIMES];
        let kinks = if *rates == Inputs::ZERO {
            &[][..]
        } else {
            if !(all_usable(&rates.commands()) & all_usable(&rates.disturbances())) {
                return Err(StepError::Overflow);
            }
            model.kink_times(h, inputs, rates, &mut times)
        };
        self.drive[..n].copy_from_slice(&state.coordinates);
        let (mut travel, mut work, mut switches) = ([0.0; FORCES], 0.0, 0);
        let mut begin = 0.0;
        for end in kinks.iter().copied().chain([h]) {
            let duration = end - begin;
            let forces = model.forces(&at(inputs, rates, begin));
            let force_rates = model.force_rates(&at(inputs, rates, f64::midpoint(begin, end)), rates);
            let parts = (duration / longest).ceil().max(1.0);
            let part = duration / parts;
            let pieces =
                (kinks.is_empty() && sizes.repeat()).then(|| self.cache.get(&self.modes.by_touching, part, REMEMBERED));
            self.drive[n + FORCES..].copy_from_slice(&force_rates);
            let mut i = 0.0;
            while i < parts {
                for ((drive, force), rate) in self.drive[n..].iter_mut().zip(&forces).zip(&force_rates) {
                    *drive = force + rate * (i * part);
                }
                let mut work = Part {
                    modes: &self.modes,
                    motion: &mut self.motion,
                    length: if force_rates == [0.0; FORCES] { n + FORCES } else { n + 2 * FORCES },
                    drive: &mut self.drive,
                    contact: &mut contact,
                    travel: &mut travel,
                    work: &mut work,
                    switches: &mut switches,
                };
                if begin == 0.0 && i == 0.0 {
                    work.settle();
                }
                work.run(part, pieces.as_ref().map(|pieces| &pieces[..]), h)?;
                i += 1.0;
            }
            begin = end;
        }
        let next = &mut self.next;
        next.coordinates.copy_from_slice(&self.drive[..n]);
        flush(&mut next.coordinates);
        next.travel(state, &travel);
        next.supplied_energy = state.supplied_energy + work;
        next.sizes = sizes;
        let new_signals = self.modes.signals(&next.coordinates);
        let usable = all_usable(&inputs.disturbances())
            & all_usable(&next.coordinates)
            & all_usable(&next.position)
            & all_usable(&new_signals)
            & all_usable(&contact.clearance);
        if !(usable & next.supplied_energy.is_finite() & contact.loss.is_finite()) {
            return Err(StepError::Overflow);
        }
        if let Some(place) = next.contact.as_deref_mut() {
            *place = contact;
        }
        *signals = new_signals;
        std::mem::swap(state, next);
        Ok(())
    }
}

impl Part<'_> {
    fn forces(&self) -> &[f64] {
        forces_of(self.drive, self.modes.layout.size())
    }

    fn magnitude(&self) -> f64 {
        Modes::magnitude(&self.drive[..self.modes.layout.size()], self.forces())
    }

    /// Opens rigid sides that forces which jumped would pull.
    fn settle(&mut self) {
        if !self.modes.rigid || self.contact.touching == [false; 2] {
            return;
        }
        let n = self.modes.layout.size();
        let touching = self.contact.touching;
        let (_, pushing) = self.modes.pushing(&self.drive[..n], self.forces(), touching, self.magnitude());
        self.modes.touch(&mut self.drive[..n], self.contact, pushing);
    }

    /// Advances by `duration`; `pieces` are the modes' pieces of this duration.
    fn run(&mut self, duration: f64, pieces: Option<&[Piece]>, h: f64) -> Result<(), StepError> {
        let mut left = duration;
        let mut at_once = 0;
        // Pieces of the ladder that may be tried: fewer where a signal stays near zero.
        let mut most = RUNGS as usize;
        while left > 0.0 {
            let mode = self.modes.mode(self.contact.touching);
            let drive = &self.drive[..self.length];
            let whole = pieces.filter(|_| left == duration && most == RUNGS as usize);
            let (taken, below) = match (whole, mode.rung(left, most)) {
                (Some(pieces), rung) => {
                    pieces[mode_index(mode.touching)].motion(drive, self.motion);
                    (duration, rung.map_or(0, |(place, _)| place))
                }
                (None, Some((place, piece))) => {
                    piece.motion(drive, self.motion);
                    (piece.duration, place)
                }
                (None, None) => {
                    let taken = left.min(mode.base());
                    mode.short(taken, self.drive, self.motion);
                    (taken, 0)
                }
            };
            match self.first_switch(taken, mode) {
                Err(Undecided) if most > 0 => most = below,
                Err(Undecided) => return Err(self.unresolved(h)),
                Ok(None) => {
                    self.lose(taken, 1.0);
                    self.accept(taken);
                    self.relax(taken);
                    left -= taken;
                    at_once = 0;
                    most = (most + 1).min(RUNGS as usize);
                }
                Ok(Some((side, xi))) => {
                    let time = xi * taken;
                    self.lose(taken, xi);
                    self.advance(mode, time);
                    self.relax(time);
                    left -= time;
                    *self.switches += 1;
                    at_once = if time > 0.0 { 1 } else { at_once + 1 };
                    if *self.switches > MOST_SWITCHES || at_once > MOST_AT_ONCE {
                        return Err(self.unresolved(h));
                    }
                    self.switch(side);
                }
            }
        }
        Ok(())
    }

    /// The side that switches first in the piece of the motion at hand, and when: as a share of the piece.
    fn first_switch(&self, taken: f64, mode: &Mode) -> Result<Option<(usize, f64)>, Undecided> {
        let size = self.magnitude();
        let mut first: Option<(usize, f64)> = None;
        for side in 0..2 {
            let size = mode.sizes[side] * size;
            let made;
            let (signal, noise) = if self.modes.rigid && self.contact.touching[side] {
                (&self.motion.watched[side], ROUNDING * size)
            } else {
                made = self.signal(side, taken, size);
                (&made.0, made.1)
            };
            if let Some(xi) = signal.first_negative(noise)?
                && first.is_none_or(|(_, other)| xi < other)
            {
                first = Some((side, xi));
            }
        }
        Ok(first)
    }

    /// What must not become negative on a side, over the piece of the motion at hand, and its rounding, unless it is what is watched
    /// itself: the force of a rigid contact. `size` is that of what is watched.
    fn signal(&self, side: usize, taken: f64, size: f64) -> (Series, f64) {
        let watched = &self.motion.watched[side];
        let (modes, clearance) = (self.modes, self.contact.clearance[side]);
        let face = &modes.faces[side];
        let pressed = if modes.rigid { 0.0 } else { self.drive[modes.layout.face(side)] / face.stiffness.sqrt() };
        if self.contact.touching[side] {
            // k δ + c δ̇, δ̇ being the closing rate.
            let deformation = watched.integrated(pressed, -taken);
            let force = deformation.combined(face.stiffness, watched, -face.damping);
            return (force, ROUNDING * (face.stiffness * (pressed.abs() + size * taken) + face.damping * size));
        }
        let mut gap = watched.integrated(clearance, taken);
        if pressed != 0.0 {
            gap.amplitude = pressed;
            gap.rate = modes.relaxation[side] * taken;
        }
        (gap, ROUNDING * (size * taken + clearance.abs() + pressed))
    }

    /// Counts what the dampers of touching faces take over a share of the piece at hand: ∫c δ̇².
    fn lose(&mut self, taken: f64, share: f64) {
        for side in 0..2 {
            let damping = self.modes.faces[side].damping;
            if !self.modes.rigid && self.contact.touching[side] && damping > 0.0 {
                let square = self.motion.watched[side].square(share, &self.modes.rule);
                self.contact.loss += damping * taken * square;
            }
        }
    }

    /// Free faces relax for this long.
    fn relax(&mut self, duration: f64) {
        for side in 0..2 {
            let place = self.modes.layout.face(side);
            let before = self.drive[place];
            if !self.contact.touching[side] && before != 0.0 {
                let after = before * super::decay::decay(self.modes.relaxation[side] * duration);
                self.contact.loss += 0.5 * (before - after) * (before + after);
                self.drive[place] = after;
            }
        }
    }

    /// Advances within a mode, whatever is watched.
    fn advance(&mut self, mode: &Mode, duration: f64) {
        let mut left = duration;
        while left > 0.0 {
            let taken = if let Some((_, piece)) = mode.rung(left, RUNGS as usize) {
                piece.increment(&self.drive[..self.length], &mut self.motion.increment);
                piece.duration
            } else {
                mode.short(left, self.drive, self.motion);
                left
            };
            self.accept(taken);
            left -= taken;
        }
    }

    /// Adds the increments of the motion at hand.
    fn accept(&mut self, taken: f64) {
        let (modes, layout) = (self.modes, self.modes.layout);
        let n = layout.size();
        let increment = self.motion.increment.as_flattened();
        let (state, forces) = self.drive.split_at_mut(n);
        let rise = increment[layout.travel() + 2];
        for i in 0..FORCES {
            let (travel, integral) = (increment[layout.travel() + i], increment[layout.travel_integral() + i]);
            // ∫ t Θ̇ dt = τ Θ(τ) − ∫ Θ dt
            *self.work += forces[i] * travel + forces[FORCES + i] * (taken * travel - integral);
        }
        for i in 0..FORCES {
            forces[i] += forces[FORCES + i] * taken;
        }
        for (x, increment) in state.iter_mut().zip(increment) {
            *x += increment;
        }
        for i in 0..2 {
            let opening = increment[layout.opening() + i];
            // l Δθ_i = Δw_i(l) + ΔY_i(l), as (12) has it.
            let bending = modes.tip_compliance[i] * increment[layout.moments(i)];
            self.travel[i] += (bending + rise + SIGN[i] * opening) / modes.length;
            if !self.contact.touching[i] {
                self.contact.clearance[i] += opening;
            } else if !modes.rigid {
                self.contact.clearance[i] = -state[layout.face(i)] / modes.faces[i].stiffness.sqrt();
            }
        }
        self.travel[2] += rise;
        if modes.rigid {
            modes.merge(state, self.contact.touching);
        }
    }

    #[cold]
    fn unresolved(&self, h: f64) -> StepError {
        let switches = *self.switches;
        if self.modes.may_not_end { StepError::Endless { h, switches } } else { StepError::Unresolved { h, switches } }
    }

    /// A side opens, or closes with an impact, now.
    fn switch(&mut self, side: usize) {
        let (x, forces) = self.drive.split_at_mut(self.modes.layout.size());
        let (modes, contact) = (self.modes, &mut *self.contact);
        match (modes.rigid, contact.touching[side]) {
            (true, true) => {
                let mut touching = contact.touching;
                touching[side] = false;
                contact.clearance[side] = 0.0;
                modes.touch(x, contact, touching);
            }
            (true, false) => {
                let mut closing = [false; 2];
                closing[side] = true;
                let closing = modes.closing_with(x, contact, closing, SIMULTANEOUS);
                modes.hit(x, &forces[..FORCES], contact, closing);
            }
            (false, true) => modes.leave(x, contact, side),
            (false, false) => modes.meet(x, contact, side),
        }
    }
}
