//! What a model says of itself.

/// Identification of a model and of its capabilities.
#[derive(Clone, Copy, Debug)]
pub struct Info {
    /// `modelName` and `modelIdentifier`: a C identifier.
    pub name: &'static str,
    /// One line on what the model is.
    pub description: &'static str,
    /// Version of the model.
    pub version: &'static str,
    /// Who wrote it.
    pub author: &'static str,
    /// Copyright notice.
    pub copyright: &'static str,
    /// Licence, in short, e.g. `MIT`.
    pub license: &'static str,
    /// Default experiment: how long to simulate and with which communication step (s).
    pub default_experiment: DefaultExperiment,
    /// Whether [`Model::directional_derivative`](crate::Model::directional_derivative) is implemented.
    pub directional_derivatives: bool,
}

impl Info {
    /// Defaults to fill up a definition with: `Info { name: "Lag", description: "…", ..Info::new() }`. What Cargo knows of
    /// the crate comes from [`cargo_info!`](crate::cargo_info).
    #[must_use]
    pub const fn new() -> Self {
        Self {
            name: "",
            description: "",
            version: "",
            author: "",
            copyright: "",
            license: "",
            default_experiment: DefaultExperiment { start_time: 0.0, stop_time: 1.0, step_size: 1e-3, tolerance: None },
            directional_derivatives: false,
        }
    }
}

impl Default for Info {
    fn default() -> Self {
        Self::new()
    }
}

/// `<DefaultExperiment>`: what a tool proposes to its user.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DefaultExperiment {
    /// Start time (s).
    pub start_time: f64,
    /// Stop time (s).
    pub stop_time: f64,
    /// Communication step size (s).
    pub step_size: f64,
    /// Relative tolerance, if the model has use for one.
    pub tolerance: Option<f64>,
}

/// An [`Info`] with what `Cargo.toml` says of the crate: description, version, authors, licence. What it says of the model,
/// and its name, are given besides.
///
/// ```
/// # use fmi2_export::Info;
/// const INFO: Info = Info { name: "Lag", directional_derivatives: true, ..fmi2_export::cargo_info!() };
/// ```
///
/// Without a name the FMU is called as the crate, with `_` in place of `-`.
#[macro_export]
macro_rules! cargo_info {
    () => {
        $crate::Info {
            name: ::core::env!("CARGO_CRATE_NAME"),
            description: ::core::env!("CARGO_PKG_DESCRIPTION"),
            version: ::core::env!("CARGO_PKG_VERSION"),
            author: ::core::env!("CARGO_PKG_AUTHORS"),
            license: ::core::env!("CARGO_PKG_LICENSE"),
            ..$crate::Info::new()
        }
    };
}
