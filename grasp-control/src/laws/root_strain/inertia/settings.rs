//! Settings of the estimators.

use serde::{Deserialize, Serialize};

/// Settings of the estimator of the mass.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct MassGains {
    /// Mass m₀ at the start \[kg\].
    pub initial: f64,
    /// Smallest estimate \[kg\].
    pub smallest: f64,
    /// Largest estimate \[kg\].
    pub largest: f64,
    /// Force f₀ below which motion tells little \[N\].
    pub threshold: f64,
    /// Weight w of the mass at the start \[N²·s\].
    pub prior: f64,
    /// Excitation S that is remembered \[N²·s\].
    pub memory: f64,
}

/// Settings of the estimators of the hubs' inertias; each begins at what the observers are told.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct InertiaGains {
    /// Smallest estimate in units of the inertia at the start.
    pub smallest: f64,
    /// Largest estimate in units of the inertia at the start.
    pub largest: f64,
    /// Torque f₀ below which motion tells little \[N·m\].
    pub threshold: f64,
    /// Weight w of the inertia at the start \[N²·m²·s\].
    pub prior: f64,
    /// Excitation S that is remembered \[N²·m²·s\].
    pub memory: f64,
}

/// Filters of all estimators.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct FilterGains {
    /// Bandwidth of the filter that stands for the differentiation \[rad/s\].
    pub bandwidth: f64,
    /// Corner below which nothing counts \[rad/s\]: constant disturbances do not.
    pub high_pass: f64,
}
