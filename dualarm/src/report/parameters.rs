//! The values of an FMU's parameters in a run, which the report shows for plant and controllers.

use fmi2_import::{CallError, Causality, Instance, Value, Variable};

/// A model's name and all of its parameters.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ModelParameters {
    /// Name of the model.
    pub model: String,
    /// The description of the model.
    pub description: String,
    /// Parameters in the order of the model description.
    pub parameters: Vec<ReportedParameter>,
}

/// One parameter.
#[derive(Debug, Clone, PartialEq)]
pub struct ReportedParameter {
    /// Name.
    pub name: String,
    /// Value the instance works with; an enumeration's is the name of its item.
    pub value: Value,
    /// Its default value.
    pub default: Option<Value>,
    /// Unit, if it has one.
    pub unit: Option<String>,
    /// Its description.
    pub description: String,
}

impl ModelParameters {
    /// Reads the values of all parameters of an instance.
    ///
    /// # Errors
    /// When the FMU refuses to return one.
    pub fn of(instance: &mut Instance) -> Result<Self, CallError> {
        let description = instance.description();
        let model = description.model_name.clone();
        let text = description.description.clone().unwrap_or_default();
        let variables: Vec<Variable> = description.with_causality(Causality::Parameter).cloned().collect();
        let parameters = variables.iter().map(|variable| parameter(instance, variable)).collect::<Result<_, _>>()?;
        Ok(Self { model, description: text, parameters })
    }

    /// The parameters that do not have their default values.
    pub fn changed(&self) -> impl Iterator<Item = &ReportedParameter> {
        self.parameters.iter().filter(|parameter| parameter.default.as_ref().is_some_and(|it| *it != parameter.value))
    }

    /// The value of a real parameter, if there is one of that name.
    #[must_use]
    pub fn real(&self, name: &str) -> Option<f64> {
        self.parameters.iter().find(|parameter| parameter.name == name).and_then(|parameter| match parameter.value {
            Value::Real(value) => Some(value),
            _ => None,
        })
    }
}

fn parameter(instance: &mut Instance, variable: &Variable) -> Result<ReportedParameter, CallError> {
    Ok(ReportedParameter {
        name: variable.name.clone(),
        value: variable.with_name(instance.get(variable)?),
        default: variable.start().map(|start| variable.with_name(start)),
        unit: variable.unit().map(str::to_owned),
        description: variable.description.clone().unwrap_or_default(),
    })
}
