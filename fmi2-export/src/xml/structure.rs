//! `<ModelStructure>`: what follows from what (FMI 2.0.4, section 2.2.8).

use std::collections::{BTreeSet, HashMap};

use super::Xml;
use crate::interface::{Interface, VariableFacts};
use crate::variable::{Causality, DependencyKind};

pub(super) fn model_structure(xml: &mut Xml, interface: &Interface) {
    let structure = Structure::of(interface);
    xml.element("ModelStructure", &[], |xml| {
        let outputs = || structure.places(|variable| variable.causality == Causality::Output);
        if outputs().next().is_some() {
            xml.element("Outputs", &[], |xml| {
                outputs().for_each(|place| unknown(xml, place, structure.direct(place).as_deref()));
            });
        }
        let states = interface.exchange.iter().flat_map(|exchange| &exchange.states);
        if states.clone().next().is_some() {
            xml.element("Derivatives", &[], |xml| {
                states.for_each(|(_, place)| unknown(xml, *place, structure.direct(*place).as_deref()));
            });
        }
        let initial = || {
            structure.places(|variable| {
                variable.causality == Causality::Output || variable.is_state || variable.derivative_of.is_some()
            })
        };
        if initial().next().is_some() {
            xml.element("InitialUnknowns", &[], |xml| {
                initial().for_each(|place| unknown(xml, place, structure.initial(place).as_deref()));
            });
        }
    });
}

/// What follows from what, by places among the variables.
struct Structure<'a> {
    variables: &'a [VariableFacts],
    place_of: HashMap<&'a str, usize>,
    /// Whether there are continuous states.
    has_states: bool,
    parameters: Vec<usize>,
    /// How many parameters and inputs there are.
    initially_known: usize,
}

/// Places of the variables that one follows from, and how; `None` if it is all there are.
type Knowns = Option<Vec<(usize, DependencyKind)>>;

impl<'a> Structure<'a> {
    fn of(interface: &'a Interface) -> Self {
        let variables = interface.variables.as_slice();
        let parameters: Vec<usize> =
            (0..variables.len()).filter(|place| variables[*place].causality == Causality::Parameter).collect();
        Self {
            variables,
            place_of: variables.iter().enumerate().map(|(place, v)| (v.name.as_str(), place)).collect(),
            has_states: variables.iter().any(|variable| variable.is_state),
            initially_known: parameters.len() + variables.iter().filter(|v| v.causality == Causality::Input).count(),
            parameters,
        }
    }

    fn places(&self, which: impl Fn(&VariableFacts) -> bool) -> impl Iterator<Item = usize> {
        (0..self.variables.len()).filter(move |place| which(&self.variables[*place]))
    }

    /// The inputs and states that an output or a derivative follows at once.
    fn direct(&self, place: usize) -> Knowns {
        let variable = &self.variables[place];
        let says_nothing = variable.depends_on.is_empty() && variable.depends_on_states.is_none();
        if says_nothing && variable.is_state {
            // It is what it follows, also if it is the derivative of another one.
            return Some(vec![(place, DependencyKind::Dependent)]);
        }
        if says_nothing && variable.derivative_of.is_some() {
            return None;
        }
        let inputs = variable.depends_on.iter().filter_map(|(name, kind)| Some((self.place(name)?, *kind)));
        let mut knowns: Vec<_> = inputs.collect();
        match &variable.depends_on_states {
            Some(states) => {
                knowns.extend(states.iter().filter_map(|name| Some((self.place(name)?, DependencyKind::Dependent))));
            }
            None if self.has_states => {
                knowns.extend(self.places(|other| other.is_state).map(|state| (state, DependencyKind::Dependent)));
            }
            None => {}
        }
        knowns.sort_unstable_by_key(|(place, _)| *place);
        Some(knowns)
    }

    /// In initialization mode a variable follows from the parameters, the inputs it directly depends on, and those that the
    /// initial state follows from.
    fn initial(&self, place: usize) -> Knowns {
        let variable = &self.variables[place];
        let says_nothing = variable.depends_on.is_empty() && variable.depends_on_states.is_none();
        if says_nothing && variable.derivative_of.is_some() {
            return None;
        }
        let inputs = variable.depends_on.iter().map(|(input, _)| input).chain(&variable.starts_from);
        let inputs = inputs.filter_map(|name| self.place(name));
        let knowns: BTreeSet<usize> = self.parameters.iter().copied().chain(inputs).collect();
        // Without a list it is all knowns; a thousand outputs of a thousand parameters would list a million.
        (knowns.len() < self.initially_known)
            .then(|| knowns.into_iter().map(|place| (place, DependencyKind::Dependent)).collect())
    }

    fn place(&self, name: &str) -> Option<usize> {
        self.place_of.get(name).copied()
    }
}

/// An element of `ModelStructure`. The standard counts variables from 1.
fn unknown(xml: &mut Xml, place: usize, knowns: Option<&[(usize, DependencyKind)]>) {
    let mut attributes = vec![("index", (place + 1).to_string())];
    if let Some(knowns) = knowns {
        let join = |items: Vec<String>| items.join(" ");
        attributes.push(("dependencies", join(knowns.iter().map(|(place, _)| (place + 1).to_string()).collect())));
        if knowns.iter().any(|(_, kind)| *kind != DependencyKind::Dependent) {
            let kinds = knowns.iter().map(|(_, kind)| dependency_kind(*kind).to_owned()).collect();
            attributes.push(("dependenciesKind", join(kinds)));
        }
    }
    xml.empty("Unknown", &attributes);
}

fn dependency_kind(kind: DependencyKind) -> &'static str {
    match kind {
        DependencyKind::Dependent => "dependent",
        DependencyKind::Fixed => "fixed",
    }
}
