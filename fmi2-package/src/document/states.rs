//! The page's table of continuous states and their time derivatives. It is collapsed, because it can be long and only
//! readers who integrate the model need it.

use std::fmt::Write as _;

use fmi2_export::Causality;
use fmi2_export::packaging::{Interface, VariableFacts};

use super::tables::{Columns, row};

/// Whether a variable is in this table and in no other.
pub fn has(variable: &VariableFacts) -> bool {
    variable.causality == Causality::Local && (variable.is_state || variable.derivative_of.is_some())
}

/// The local variables among states and derivatives.
pub fn table(html: &mut String, interface: &Interface) {
    let Some(exchange) = interface.exchange.as_ref().filter(|exchange| !exchange.states.is_empty()) else { return };
    let _ = writeln!(
        html,
        "<details><summary>Local variables that are continuous states or their time derivatives</summary>\n<p>For model exchange, \
         which has {} states and {} event indicators.</p>\n<table class=\"variables\">\n<thead><tr><th scope=\"col\">Name</th>\
         <th scope=\"col\">Description</th><th scope=\"col\">Unit</th></tr></thead>\n<tbody>",
        exchange.states.len(),
        exchange.event_indicators
    );
    for variable in interface.variables.iter().filter(|variable| has(variable)) {
        row(html, variable, Columns { range: false, start: false });
    }
    html.push_str("</tbody>\n</table>\n</details>\n");
}
