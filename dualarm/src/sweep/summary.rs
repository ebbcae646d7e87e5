//! The summary of a study: how often each controller succeeds, and how its figures are distributed.

use serde::Serialize;

use super::table::Layout;
use super::{Row, Status};

/// Of all runs with one controller, or of all runs.
#[derive(Debug, Clone, Default, Serialize)]
pub struct Group {
    /// The name of the controller in tables.
    pub controller: Option<String>,
    /// How many runs.
    pub runs: u64,
    /// How many of them went to their end.
    pub ok: u64,
    /// How many were ended early by an FMU.
    pub ended: u64,
    /// How many failed, crashed or took too long.
    pub failed: u64,
    /// The number of successes, if the study defines success.
    pub successes: Option<u64>,
    /// Their share and its 95 % confidence interval.
    pub success_rate: Option<Rate>,
    /// How each figure is distributed.
    pub figures: Vec<Distribution>,
    #[serde(skip)]
    values: Vec<Vec<f64>>,
}

/// A share with its confidence interval.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Rate {
    /// The observed share.
    pub share: f64,
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

/// The distribution of a figure. A missing value, such as the settling time of a run that never settles, counts as the
/// largest.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Distribution {
    /// The figure.
    pub name: String,
    /// In how many runs it exists.
    pub count: usize,
    /// Exceeded by 95 % of the runs.
    pub p05: Option<f64>,
    /// The median; `None` if it does not exist.
    pub median: Option<f64>,
    /// By 5 % of them.
    pub p95: Option<f64>,
}

/// Adds up rows.
pub struct Summary {
    names: Vec<String>,
    groups: Vec<Group>,
}

impl Summary {
    /// Of rows with these figures, by controller.
    #[must_use]
    pub fn new(controllers: &[&str], figures: &[String]) -> Self {
        let group = |controller: Option<&&str>| Group {
            controller: controller.map(|name| (*name).to_owned()),
            values: vec![Vec::new(); figures.len()],
            ..Group::default()
        };
        let groups = if controllers.is_empty() {
            vec![group(None)]
        } else {
            controllers.iter().map(|name| group(Some(name))).collect()
        };
        Self { names: figures.to_vec(), groups }
    }

    /// Adds a row of the controller at `entrant`.
    pub fn add(&mut self, entrant: usize, row: &Row, layout: &Layout) {
        let Some(group) = self.groups.get_mut(entrant) else { return };
        group.runs += 1;
        match row.status {
            Status::Ok => group.ok += 1,
            Status::Ended => group.ended += 1,
            _ => group.failed += 1,
        }
        if let Some(success) = layout.success(row) {
            *group.successes.get_or_insert(0) += u64::from(success);
        }
        for (place, values) in group.values.iter_mut().enumerate() {
            values.push(row.figure(place).filter(|value| !value.is_nan()).unwrap_or(f64::INFINITY));
        }
    }

    /// The groups in the order of the controllers.
    #[must_use]
    pub fn finish(mut self) -> Vec<Group> {
        for group in &mut self.groups {
            group.success_rate = group.successes.map(|successes| wilson(successes, group.runs));
            for (name, values) in self.names.iter().zip(&mut group.values) {
                values.sort_by(f64::total_cmp);
                let quantile = |share: f64| quantile(values, share).filter(|value| value.is_finite());
                group.figures.push(Distribution {
                    name: name.clone(),
                    count: values.iter().filter(|value| value.is_finite()).count(),
                    p05: quantile(0.05),
                    median: quantile(0.5),
                    p95: quantile(0.95),
                });
            }
        }
        self.groups
    }
}

/// The value at this share of sorted ones: the smallest that at least this share does not exceed.
fn quantile(sorted: &[f64], share: f64) -> Option<f64> {
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // between 0 and the length
    let index = (share * sorted.len() as f64).ceil() as usize;
    sorted.get(index.saturating_sub(1)).copied()
}

/// The 95 % interval of E. B. Wilson, *Probable inference, the law of succession, and statistical inference*, Journal of
/// the American Statistical Association 22 (1927) 209–212. It is also valid near 0 and 1, where no run or every run
/// succeeds.
#[must_use]
pub fn wilson(successes: u64, runs: u64) -> Rate {
    const Z: f64 = 1.959_963_984_540_054;
    if runs == 0 {
        return Rate { share: 0.0, low: 0.0, high: 1.0 };
    }
    let (n, share) = (runs as f64, successes as f64 / runs as f64);
    let centre = (share + Z * Z / (2.0 * n)) / (1.0 + Z * Z / n);
    let half = Z / (1.0 + Z * Z / n) * (share * (1.0 - share) / n + Z * Z / (4.0 * n * n)).sqrt();
    // At 0 and 1 one end is the share itself, but for rounding.
    Rate { share, low: (centre - half).clamp(0.0, share), high: (centre + half).clamp(share, 1.0) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wilsons_interval_is_as_published() {
        // Solves (p̂ − p)² = z² p (1 − p)/n at both ends, which is its definition.
        for (successes, runs) in [(0, 10), (3, 10), (10, 10), (1234, 2000)] {
            let Rate { share, low, high } = wilson(successes, runs);
            for end in [low, high] {
                let error = (share - end).powi(2) - 1.959_963_984_540_054_f64.powi(2) * end * (1.0 - end) / runs as f64;
                assert!(error.abs() < 1e-12 || end == 0.0 || end == 1.0, "{successes}/{runs}: {end}");
            }
            assert!(low <= share && share <= high);
        }
        assert!((wilson(0, 10).high - 0.277_53).abs() < 1e-4);
    }

    #[test]
    fn what_never_settles_counts_as_the_latest() {
        let values = [0.1, 0.2, f64::INFINITY, f64::INFINITY];
        assert_eq!(
            [0.05, 0.5, 0.75].map(|share| quantile(&values, share)),
            [Some(0.1), Some(0.2), Some(f64::INFINITY)]
        );
        assert_eq!(quantile(&[], 0.5), None);
    }
}
