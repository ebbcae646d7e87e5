//! Sensors and actuators between plant and controller.
//!
//! `GraspInstruments.fmu` has an input `X` and an output `X_measured` for each signal `X` of the plant;
//! `GraspActuators.fmu` has an input `X` and an output `X_sent` for each command `X` of the controller. An FMU cannot have
//! an input and an output of the same name, so equal names alone do not connect it in between: [`connect`] does.

use std::path::Path;

use fmi2_cosim::settings::Setting;
use fmi2_cosim::system::{Connections, Located, System};
use fmi2_cosim::wiring::{Terminal, Wire, Wiring, WiringError, wire_by_name};
use fmi2_import::{Causality, Fmu, FmuError, ModelDescription};

/// An FMU that signals pass through.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Passage {
    /// File name of the FMU.
    pub fmu: &'static str,
    /// The suffix that its outputs' names have after those of its inputs.
    pub suffix: &'static str,
}

/// The sensors.
pub const INSTRUMENTS: Passage = Passage { fmu: "GraspInstruments.fmu", suffix: "_measured" };
/// The actuators.
pub const ACTUATORS: Passage = Passage { fmu: "GraspActuators.fmu", suffix: "_sent" };

/// A set of properties of sensors and actuators, under a name that a user types.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Profile {
    /// The name.
    pub key: &'static str,
    /// Names and values that make the profile of the FMUs.
    settings: &'static [(&'static str, &'static str)],
    /// Whether it leaves a controller without rates.
    no_rates: bool,
}

/// All profiles. *off* keeps the FMUs' start values, with which they have no effect until a value is set.
pub const PROFILES: &[Profile] = &[
    Profile { key: "off", settings: &[], no_rates: false },
    Profile { key: "noise", settings: &[("sensor_profile", "noise")], no_rates: false },
    Profile { key: "encoders", settings: &[("sensor_profile", "encoders")], no_rates: true },
    Profile { key: "delay", settings: &[("actuator_profile", "delay")], no_rates: false },
];

/// The setting with which a controller works without measured rates.
const ESTIMATED: (&str, &str) = ("rate_source", "estimated");

/// Why sensors and actuators cannot be put into a loop.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum InstrumentsError {
    /// An FMU cannot be used.
    #[error("--instruments: {0}; `dualarm package` makes the FMUs, --fmus says where they are")]
    Fmu(#[from] FmuError),
    /// Signals cannot be connected.
    #[error(transparent)]
    Wiring(#[from] WiringError),
    /// Nothing passes through an FMU.
    #[error("--instruments: no signal goes from a plant to a controller and back that {0} could pass on")]
    NoLoop(&'static str),
}

impl Profile {
    /// The profile a user names.
    #[must_use]
    pub fn find(key: &str) -> Option<&'static Self> {
        PROFILES.iter().find(|profile| profile.key == key)
    }
}

impl Passage {
    /// Whether this is it.
    pub(crate) fn is(self, fmu: &Fmu) -> bool {
        self.fmu.strip_suffix(".fmu") == Some(fmu.description().model_name.as_str())
    }

    /// Its place among the components.
    fn place(self, components: &[(String, Fmu)]) -> Option<usize> {
        components.iter().position(|(_, fmu)| self.is(fmu))
    }
}

/// The outputs of sensors or actuators, by place in the description, with the corresponding inputs.
fn pairs(passage: Passage, description: &ModelDescription) -> impl Iterator<Item = (usize, usize)> {
    let inputs = description.variables.iter().enumerate().filter(|(_, v)| v.causality == Causality::Input);
    inputs.filter_map(move |(input, variable)| {
        Some((input, description.index_of(&format!("{}{}", variable.name, passage.suffix))?))
    })
}

/// Puts sensors and actuators of these profiles into the system's loop; those that the system lacks come from the folder
/// `fmus`. Without profiles it only routes signals through the sensors and actuators that the system already has.
///
/// # Errors
/// When their FMUs are missing, or the system has no loop to put them into.
pub fn put_into(system: &mut System, profiles: &[&Profile], fmus: &Path) -> Result<(), InstrumentsError> {
    if profiles.is_empty() { Ok(connect(system)?) } else { insert(system, profiles, fmus) }
}

/// The sentence about them in a report.
#[must_use]
pub fn sentence(profiles: &[&Profile]) -> String {
    if profiles.is_empty() {
        return String::new();
    }
    let keys: Vec<&str> = profiles.iter().map(|profile| profile.key).collect();
    format!(" Between plant and controller are GraspInstruments.fmu and GraspActuators.fmu: {}.", keys.join(", "))
}

/// # Errors
/// When an FMU cannot be opened, or there is no loop.
pub fn insert(system: &mut System, profiles: &[&Profile], fmus: &Path) -> Result<(), InstrumentsError> {
    for passage in [INSTRUMENTS, ACTUATORS] {
        if passage.place(&system.components).is_none() {
            add(system, passage, Fmu::unpack(fmus.join(passage.fmu))?);
        }
    }
    connect(system)?;
    let Connections::Explicit(wires) = &system.connections else { return Ok(()) };
    for passage in [INSTRUMENTS, ACTUATORS] {
        let place = passage.place(&system.components);
        if !wires.iter().any(|wire| Some(wire.from.component) == place) {
            return Err(InstrumentsError::NoLoop(passage.fmu));
        }
    }
    let mut settings: Vec<_> = profiles.iter().flat_map(|profile| profile.settings).copied().collect();
    if profiles.iter().any(|profile| profile.no_rates) {
        if system.components.iter().any(|(_, fmu)| fmu.description().variable(ESTIMATED.0).is_some()) {
            settings.push(ESTIMATED);
        } else {
            system
                .remarks
                .push(format!("no rate is measured, and the controller has no {} to do without", ESTIMATED.0));
        }
    }
    let settings = settings.into_iter().map(|(name, value)| Located::nowhere(Setting::new(name, value)));
    system.settings.splice(0..0, settings);
    Ok(())
}

/// Adds a component after the one whose outputs it takes, so that every component still receives the newest signals.
fn add(system: &mut System, passage: Passage, fmu: Fmu) {
    let description = fmu.description();
    let feeds = |other: &Fmu| {
        pairs(passage, description).any(|(input, _)| offers(other.description(), &description.variables[input].name))
    };
    let source = system.components.iter().position(|(_, other)| feeds(other));
    let place = source.map_or(system.components.len(), |source| source + 1);
    let name = description.model_name.clone();
    system.components.insert(place, (name, fmu));
    if let Connections::Explicit(wires) = &mut system.connections {
        for end in wires.iter_mut().flat_map(|wire| [&mut wire.from, &mut wire.to]) {
            end.component += usize::from(end.component >= place);
        }
    }
}

fn offers(description: &ModelDescription, name: &str) -> bool {
    description.variable(name).is_some_and(|variable| variable.causality == Causality::Output)
}

/// Routes signals through the sensors and actuators among the components. A component that sends commands receives its
/// other signals from the sensors, and its commands go through the actuators. Without sensors and actuators nothing
/// changes.
///
/// # Errors
/// When two outputs could feed one input, or units do not fit.
pub fn connect(system: &mut System) -> Result<(), WiringError> {
    let components = &system.components;
    let places = [INSTRUMENTS, ACTUATORS].map(|passage| passage.place(components));
    if places == [None, None] {
        return Ok(());
    }
    let mut wires = match &system.connections {
        Connections::Explicit(wires) => wires.clone(),
        Connections::ByName => {
            let named: Vec<_> = components.iter().map(|(name, fmu)| (name.as_str(), fmu.description())).collect();
            let Wiring { wires, remarks } = wire_by_name(&named)?;
            system.remarks.extend(remarks);
            wires
        }
    };
    let commands = |component: usize| {
        let description = components[component].1.description();
        ["tau1_cmd", "tau2_cmd", "u_cmd"].iter().any(|command| offers(description, command))
    };
    if let Some(place) = places[0] {
        lead_through(components, &mut wires, INSTRUMENTS, place, |wire| commands(wire.to.component));
    }
    if let Some(place) = places[1] {
        lead_through(components, &mut wires, ACTUATORS, place, |wire| Some(wire.to.component) != places[0]);
    }
    system.connections = Connections::Explicit(wires);
    Ok(())
}

/// Routes the selected wires through the component at `place`, if it takes their signals.
fn lead_through(
    components: &[(String, Fmu)],
    wires: &mut Vec<Wire>,
    passage: Passage,
    place: usize,
    wanted: impl Fn(&Wire) -> bool,
) {
    let description = components[place].1.description();
    for (input, output) in pairs(passage, description) {
        let [input, output] = [input, output].map(|variable| Terminal { component: place, variable });
        let name =
            |terminal: Terminal| &components[terminal.component].1.description().variables[terminal.variable].name;
        for i in 0..wires.len() {
            let Wire { from, to, .. } = wires[i];
            let passes = from.component != place && to.component != place && wanted(&wires[i]);
            if passes && name(from) == name(input) {
                if !wires.iter().any(|wire| wire.to == input) {
                    wires.push(Wire { from, to: input, conversion: None });
                }
                wires[i].from = output;
            }
        }
    }
}
