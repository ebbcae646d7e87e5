//! One run as the page shows it, wherever it comes from: a simulation or a file of results.

use serde_json::json;

use super::packed::{Geometry, Packed};
use crate::report::parameters::ModelParameters;
use grasp_merit::metrics::Metrics;

/// A run for the page.
#[derive(Debug, Clone, Default)]
pub struct Run {
    /// Names files that are made of it.
    pub key: String,
    /// The title on the page.
    pub title: String,
    /// The settling time that the paper states, or an empty text.
    pub paper: String,
    /// The rows that the page gets, see [`super::rows`].
    pub rows: Packed,
    /// How good it was, if it was a grasp with a target.
    pub metrics: Option<Metrics>,
    /// Notes beside its parameters, in sentences: the command, the settings.
    pub notes: Vec<String>,
    /// Its known models.
    pub models: Vec<ModelParameters>,
}

impl Run {
    /// For the page's scripts, as JSON.
    pub(super) fn data(&self) -> String {
        let Packed { data, last_change, geometry } = &self.rows;
        let geometry = geometry.map(|Geometry { arm, object }| json!({ "arm": arm, "object": object }));
        let run = json!({
            "key": self.key,
            "title": self.title,
            "settling": self.metrics.as_ref().and_then(Metrics::settling_2),
            "since": last_change,
            "judged": self.metrics.is_some(),
            "geometry": geometry,
        });
        // The rows are too long to be copied into another value first: they become its last member as text.
        let run = run.to_string();
        format!("{},\"data\":{data}}}", run.strip_suffix('}').unwrap_or_default())
    }

    /// Whether the page draws it in motion.
    pub(super) fn is_grasp(&self) -> bool {
        self.rows.geometry.is_some()
    }
}
