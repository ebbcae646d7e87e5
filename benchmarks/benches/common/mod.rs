//! What the benchmark, the instruction counts and the cost curves measure: one communication step through the C interface,
//! with every wired signal handed over and fetched, of each FMU alone and of plant and controller together, by bare calls as a host in C makes
//! them; and a [`peer`], the same algorithms in C.

// Each program uses a part of this.
#![allow(dead_code)]

pub mod peer;
pub mod replay;

use std::error::Error;
use std::path::{Path, PathBuf};
use std::rc::Rc;

use dualarm::grasp::{Controller, NABFC, NABFC_R, PD, PDS, PLANT};
use fmi2_cosim::grid::TimeGrid;
use fmi2_cosim::master::{Coupling, Master};
use fmi2_cosim::settings::Setting;
use fmi2_import::{Fmu, Instance, ValueReference};
use grasp_control::INPUT_NAMES;
use replay::{Replay, Steps};

pub type Result<T> = std::result::Result<T, Box<dyn Error>>;

/// Communication step in s.
pub const STEP: f64 = 1e-4;

/// The signals from the plant to every controller: what it measures, but for the rates of the root moments, which the paper's law
/// does not have.
pub const MEASURED: &[&str] = INPUT_NAMES.split_at(12).0;

/// The signals from every controller to the plant.
pub const COMMANDS: [&str; 3] = ["tau1_cmd", "tau2_cmd", "u_cmd"];

/// Where `cargo run --release -- package` puts the FMUs.
pub fn dist() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../dist")
}

/// An FMU of the folder.
pub fn open(folder: &Path, file: &str) -> Result<Fmu> {
    Ok(Fmu::open(folder.join(file))
        .map_err(|error| format!("{error}; `cargo run --release -- package` makes the FMUs"))?)
}

/// One instance with its wired variables.
pub struct Slave {
    pub instance: Instance,
    inputs: Rc<[ValueReference]>,
    outputs: Rc<[ValueReference]>,
    steps: u32,
}

impl Slave {
    /// An initialised instance; `order` is the plant's.
    pub fn new(
        fmu: &Fmu,
        inputs: &[&str],
        outputs: &[&str],
        order: Option<i32>,
        settings: impl Iterator<Item = Setting>,
    ) -> Result<Self> {
        let references = |names: &[&str]| -> Result<Rc<[ValueReference]>> {
            names
                .iter()
                .map(|name| {
                    let variable = fmu.description().variable(name).ok_or_else(|| format!("no variable {name}"))?;
                    Ok(variable.value_reference)
                })
                .collect()
        };
        let (inputs, outputs) = (references(inputs)?, references(outputs)?);
        let mut instance = fmu.instantiate("measured")?;
        if let Some(order) = order {
            instance.set_integer(&references(&["order"])?, &[order])?;
        }
        for setting in settings {
            let name = setting.target.as_str();
            let variable = fmu.description().variable(name).ok_or_else(|| format!("no variable {name}"))?;
            instance.set(variable, &setting.value)?;
        }
        let mut slave = Self { instance, inputs, outputs, steps: 0 };
        slave.start()?;
        Ok(slave)
    }

    /// Initialises it, at time 0.
    pub fn start(&mut self) -> Result<()> {
        self.instance.setup_experiment(fmi2_import::Experiment { start: 0.0, stop: None, tolerance: None })?;
        self.instance.enter_initialization_mode()?;
        self.instance.exit_initialization_mode()?;
        self.steps = 0;
        Ok(())
    }

    pub fn plant(folder: &Path, order: Option<i32>) -> Result<Self> {
        Self::new(&open(folder, PLANT)?, &COMMANDS, MEASURED, order, std::iter::empty())
    }

    pub fn controller(folder: &Path, scenario: &Controller) -> Result<Self> {
        Self::new(&open(folder, scenario.fmu)?, MEASURED, &COMMANDS, None, scenario.settings())
    }

    /// `fmi2SetReal`: the bare call, as the peer in C is called.
    #[inline]
    pub fn set(&mut self, inputs: &[f64]) {
        assert_eq!(inputs.len(), self.inputs.len());
        let (set, component) = (self.instance.functions().set_real, self.instance.component());
        // SAFETY: living component, both arrays have this length.
        let status = unsafe { set(component, self.inputs.as_ptr(), inputs.len(), inputs.as_ptr()) };
        assert_eq!(status, 0, "fmi2SetReal");
    }

    /// `fmi2GetReal`.
    #[inline]
    pub fn get(&mut self, outputs: &mut [f64]) {
        assert_eq!(outputs.len(), self.outputs.len());
        let (get, component) = (self.instance.functions().get_real, self.instance.component());
        // SAFETY: living component, both arrays have this length.
        let status = unsafe { get(component, self.outputs.as_ptr(), outputs.len(), outputs.as_mut_ptr()) };
        assert_eq!(status, 0, "fmi2GetReal");
    }

    /// `fmi2DoStep`.
    #[inline]
    pub fn do_step(&mut self) {
        let (step, component) = (self.instance.functions().do_step, self.instance.component());
        // SAFETY: living component.
        let status = unsafe { step(component, f64::from(self.steps) * STEP, STEP, 1) };
        assert_eq!(status, 0, "fmi2DoStep");
        self.steps += 1;
    }
}

impl Steps for Slave {
    /// `fmi2SetReal`, `fmi2DoStep`, `fmi2GetReal`.
    #[inline]
    fn step(&mut self, inputs: &[f64], outputs: &mut [f64]) {
        self.set(inputs);
        self.do_step();
        self.get(outputs);
    }
}

/// Plant and controller, coupled by hand: the calls that the FMUs need and nothing else.
pub struct Pair {
    plant: Slave,
    controller: Slave,
    pub measured: [f64; 12],
    pub commands: [f64; 3],
}

impl Pair {
    pub fn new(folder: &Path, scenario: &Controller) -> Result<Self> {
        Self::of(&(open(folder, PLANT)?, open(folder, scenario.fmu)?), scenario)
    }

    /// Of FMUs that are open already: many share their libraries.
    pub fn of((plant, controller): &(Fmu, Fmu), scenario: &Controller) -> Result<Self> {
        Ok(Self {
            plant: Slave::new(plant, &COMMANDS, MEASURED, None, std::iter::empty())?,
            controller: Slave::new(controller, MEASURED, &COMMANDS, None, scenario.settings())?,
            measured: [0.0; 12],
            commands: [0.0; 3],
        })
    }

    /// Another pair of the same FMUs: a host keeps one list of references for all.
    pub fn another(&self, fmus: &(Fmu, Fmu), scenario: &Controller) -> Result<Self> {
        let mut pair = Self::of(fmus, scenario)?;
        for (new, old) in [(&mut pair.plant, &self.plant), (&mut pair.controller, &self.controller)] {
            (new.inputs, new.outputs) = (Rc::clone(&old.inputs), Rc::clone(&old.outputs));
        }
        Ok(pair)
    }

    #[inline]
    pub fn step(&mut self) {
        self.plant.step(&self.commands, &mut self.measured);
        self.controller.step(&self.measured, &mut self.commands);
    }

    /// The other order of calls: the controller is asked for its commands before its step and not after it.
    #[inline]
    pub fn step_get_first(&mut self) {
        self.controller.set(&self.measured);
        self.controller.get(&mut self.commands);
        self.controller.do_step();
        self.plant.step(&self.commands, &mut self.measured);
    }
}

/// Something whose step is measured.
pub enum Case {
    /// One FMU with the inputs it had in a coupled run.
    Alone(Replay<Slave>),
    /// Two FMUs, coupled by hand.
    Coupled(Pair),
    /// The same in the other order of calls.
    GetFirst(Pair),
    /// The same two under the native master.
    Master(Box<Master>, u32),
}

/// Steps of the coupled run that feeds the FMUs when they are measured alone, and of a measurement: the squeeze, from rest
/// until the forces have settled.
pub const RUN: usize = 4000;

impl Case {
    /// The names, in the order of a table; `nabfc` and what it is part of have the paper's law.
    pub const NAMES: [&str; 7] = ["plant", "nabfc", "pds", "pd", "coupled", "get_first", "master"];
    /// The law by default, alone and with the plant.
    pub const DEFAULT: [&str; 2] = ["nabfc-r", "coupled-r"];

    pub fn new(name: &str, folder: &Path) -> Result<Self> {
        let scenario = match name {
            "pds" => PDS,
            "pd" => PD,
            "nabfc-r" | "coupled-r" => NABFC_R,
            _ => NABFC,
        };
        let mut pair = Pair::new(folder, &scenario)?;
        let mut inputs = Vec::new();
        Ok(match name {
            "plant" => {
                for _ in 0..RUN {
                    inputs.extend_from_slice(&pair.commands);
                    pair.step();
                }
                Self::Alone(Replay::new(Slave::plant(folder, None)?, inputs, MEASURED.len()))
            }
            "nabfc" | "nabfc-r" | "pds" | "pd" => {
                for _ in 0..RUN {
                    pair.step();
                    inputs.extend_from_slice(&pair.measured);
                }
                Self::Alone(Replay::new(Slave::controller(folder, &scenario)?, inputs, COMMANDS.len()))
            }
            "coupled" | "coupled-r" => Self::Coupled(pair),
            "get_first" => Self::GetFirst(pair),
            "master" => {
                let fmus = [open(folder, PLANT)?, open(folder, scenario.fmu)?];
                let mut master = Master::new(&fmus, Coupling::GaussSeidel)?;
                for setting in scenario.settings() {
                    master.apply(&setting)?;
                }
                master.initialize(&TimeGrid::new(0.0, 1e6, STEP)?)?;
                Self::Master(Box::new(master), 0)
            }
            _ => {
                let names = [&Self::NAMES[..], &Self::DEFAULT].concat().join(", ");
                return Err(format!("no case {name}; there are {names}").into());
            }
        })
    }

    #[inline]
    pub fn step(&mut self) {
        match self {
            Self::Alone(replay) => replay.step(),
            Self::Coupled(pair) => pair.step(),
            Self::GetFirst(pair) => pair.step_get_first(),
            Self::Master(master, steps) => {
                master.step(f64::from(*steps) * STEP, STEP).expect("a step");
                *steps += 1;
            }
        }
    }
}
