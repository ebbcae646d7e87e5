//! Variables by their names.

use super::Variable;

/// The indices of variables in the order of their names. A table of hashes would need a copy of each name.
#[derive(Debug, Clone, Default)]
pub(super) struct ByName(Vec<usize>);

impl ByName {
    /// # Errors
    /// When two variables have one name: the index of the first one whose name was there before.
    pub fn of(variables: &[Variable]) -> Result<Self, usize> {
        let mut indices: Vec<_> = (0..variables.len()).collect();
        // Of equal names the first one stays before the others.
        indices.sort_by(|one, other| variables[*one].name.cmp(&variables[*other].name));
        let again = indices.windows(2).filter(|pair| variables[pair[0]].name == variables[pair[1]].name);
        match again.map(|pair| pair[1]).min() {
            Some(again) => Err(again),
            None => Ok(Self(indices)),
        }
    }

    /// The index of the variable of that name. The variables are those that it was made of.
    pub fn index_of(&self, name: &str, variables: &[Variable]) -> Option<usize> {
        let name_of = |index: usize| variables.get(index).map(|variable| variable.name.as_str());
        let place = self.0.binary_search_by(|index| name_of(*index).cmp(&Some(name))).ok()?;
        Some(self.0[place])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::description::{Causality, Variability, VariableType};

    fn variables(names: &[&str]) -> Vec<Variable> {
        let variable = |name: &&str| Variable {
            name: (*name).to_owned(),
            value_reference: 0,
            description: None,
            causality: Causality::Local,
            variability: Variability::Discrete,
            initial: None,
            kind: VariableType::Boolean { start: None },
        };
        names.iter().map(variable).collect()
    }

    #[test]
    fn every_variable_is_found() {
        let variables = variables(&["x[10]", "b", "a", "x[2]", "", "ä"]);
        let by_name = ByName::of(&variables).unwrap();
        for (index, variable) in variables.iter().enumerate() {
            assert_eq!(by_name.index_of(&variable.name, &variables), Some(index));
        }
        assert_eq!(by_name.index_of("x", &variables), None);
    }

    /// What is said of a file should not depend on the order of its names.
    #[test]
    fn the_first_name_that_was_there_before_is_the_fault() {
        for (names, again) in [(["b", "a", "b", "a"], 2), (["b", "a", "a", "b"], 2), (["c", "b", "a", "b"], 3)] {
            assert_eq!(ByName::of(&variables(&names)).unwrap_err(), again);
        }
    }
}
