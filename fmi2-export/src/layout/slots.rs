//! What setting and reading a variable takes.

use crate::variable::{Causality, Variability, Variable};

/// When the host may set a variable: one bit per phase.
pub(crate) mod settable {
    pub const INSTANTIATED: u8 = 1;
    pub const INITIALIZATION: u8 = 2;
    /// Between communication steps.
    pub const STEPPING: u8 = 4;
    /// In event mode of a model exchange.
    pub const EVENT: u8 = 8;
    /// In continuous-time mode of a model exchange.
    pub const CONTINUOUS: u8 = 16;
}

/// What setting and reading a variable of another base type takes.
#[derive(Clone, Copy)]
pub(crate) struct Slot {
    /// Index into [`Layout::variables`].
    pub variable: u32,
    pub causality: Causality,
    /// Phases in which the host may set it.
    pub settable: u8,
    /// The evaluation to run before reading it, as a bit; 0 if none.
    pub evaluation: u64,
}

/// What setting and reading a real variable takes.
#[derive(Clone, Copy)]
pub(crate) struct RealSlot {
    /// The least value it may have, finite: [`f64::MIN`] where none is declared.
    pub min: f64,
    /// The greatest, likewise.
    pub max: f64,
    /// How many bytes behind the model's beginning it always is, or [`ELSEWHERE`](Self::ELSEWHERE).
    pub offset: u32,
    /// Index into [`Layout::variables`].
    pub variable: u32,
    /// Phases in which the host may set it.
    pub settable: u8,
    /// The bit of what it is.
    pub kind: u8,
    /// How many variables of successive references, from this one on, follow each other in memory and are alike in all else: most hosts
    /// set and read such a group, and one check does for all. Zero if it has no short way.
    pub run: u16,
    /// The evaluation to run before reading it, as a bit, 0 if none; or [`NO_SHORT_WAY`](Self::NO_SHORT_WAY).
    pub needs: u32,
}

impl RealSlot {
    /// Bytes of a number.
    const SIZE: u32 = 8;
    /// No offset: the declared function leads to the variable.
    pub const ELSEWHERE: u32 = u32::MAX;
    /// Of [`needs`](Self::needs): the variable is elsewhere, or its evaluation has no bit here.
    pub const NO_SHORT_WAY: u32 = 1 << 31;

    /// What [`needs`](Self::needs) of a variable with this evaluation, as a bit, and this offset.
    pub fn needs(evaluation: u64, offset: u32) -> u32 {
        let short = u32::try_from(evaluation).ok().filter(|needs| needs & Self::NO_SHORT_WAY == 0);
        short.filter(|_| offset != Self::ELSEWHERE).unwrap_or(Self::NO_SHORT_WAY)
    }

    pub fn has(&self, causality: Causality) -> bool {
        self.kind & causality.bit() != 0
    }

    /// Whether it can be set and read together with the variable of the next reference.
    pub fn is_like(&self, next: &Self) -> bool {
        let of = |slot: &Self| (slot.min.to_bits(), slot.max.to_bits(), slot.settable, slot.kind, slot.needs);
        of(self) == of(next) && self.offset.checked_add(Self::SIZE) == Some(next.offset)
    }

    /// Whether the variable may have this value. NaN and infinities never are between two finite numbers.
    #[inline]
    pub fn accepts(&self, value: f64) -> bool {
        self.min <= value && value <= self.max
    }
}

/// A variable's base type and its value reference among those of that type.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Reference {
    pub base: BaseType,
    pub index: u32,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum BaseType {
    Real,
    Integer,
    Boolean,
    String,
}

/// Condition columns 1, 3 and 6 of the table in FMI 2.0.4, section 4.2.4, but inputs may also be set before
/// initialization: the standard's own example sets "all variable start values" there, and hosts do.
///
/// In model exchange columns 1, 3, 4 and 5 of the table in section 3.2.3: in continuous-time mode nothing may jump.
pub(super) fn when_settable(variable: &Variable) -> u8 {
    let before_stepping = settable::INSTANTIATED | settable::INITIALIZATION;
    let running = before_stepping | settable::STEPPING | settable::EVENT;
    match (variable.causality, variable.variability) {
        (Causality::Input, Variability::Continuous) => running | settable::CONTINUOUS,
        (Causality::Input, _) | (Causality::Parameter, Variability::Tunable) => running,
        (Causality::Parameter, _) => before_stepping,
        (Causality::Output | Causality::Local, _) => 0,
    }
}
