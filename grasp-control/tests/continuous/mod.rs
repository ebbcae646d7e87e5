//! Plant and law as one system of differential equations, and as a sampled loop.

#![allow(dead_code)]

#[path = "../../../grasp-plant/tests/integrator/mod.rs"]
pub mod integrator;

use grasp_control::blocks::observer::RateSource;
use grasp_control::continuous::{
    Continuous, Direction, NABFC_INDICATORS, PDS_INDICATORS, PDS_STATES, Regimes, nabfc_state_variables, nabfc_states,
    pds_state_variables,
};
use grasp_control::laws::encoders::{Actuation, Encoders};
use grasp_control::laws::nabfc::{Gains, Nabfc, RbfLayout};
use grasp_control::laws::pd::{Pd, PdGains};
use grasp_control::laws::pds::{Limits, Pds, PdsGains};
use grasp_control::laws::root_strain::{Learner, RootStrain, RootStrainGains};
use grasp_control::{Arms, Inputs, Measurements, References, StateVariable};
use grasp_plant::{Measured, Parameters, Plant};
use integrator::{System, integrate};
use nalgebra::DMatrix;

/// A law with its numbers of states and indicators.
pub struct Case {
    pub name: &'static str,
    pub law: Box<dyn Continuous>,
    pub states: usize,
    pub indicators: usize,
    /// Magnitudes of the states, and how far tests may move them.
    pub scales: Vec<f64>,
    pub reach: Vec<f64>,
}

/// How far a state may be from its start: sums of squares and products only so far that they still are such sums.
pub fn reach(state: &StateVariable) -> f64 {
    let is_sum = ["_ff", "_nn", "_nf", "_af", "_an"].iter().any(|sum| state.name.ends_with(sum));
    if is_sum { 1e-6 } else { state.nominal }
}

fn case(
    name: &'static str,
    law: Box<dyn Continuous>,
    states: usize,
    indicators: usize,
    variables: &[StateVariable],
) -> Case {
    let scales = variables.iter().map(|state| state.nominal).collect();
    Case { name, law, states, indicators, scales, reach: variables.iter().map(reach).collect() }
}

fn pds_case(name: &'static str, law: impl Continuous + 'static) -> Case {
    case(name, Box::new(law), PDS_STATES, PDS_INDICATORS, &pds_state_variables())
}

fn nabfc_case(name: &'static str, law: impl Continuous + 'static, layout: &RbfLayout) -> Case {
    case(name, Box::new(law), nabfc_states(layout), NABFC_INDICATORS, &nabfc_state_variables(layout))
}

pub fn pd(name: &'static str, gains: PdGains, source: RateSource) -> Case {
    let law = Pd::new(Arms::default(), gains, Limits::default()).unwrap();
    pds_case(name, Encoders::new(law, source, Actuation::default()).unwrap())
}

pub fn pds(name: &'static str, gains: PdsGains, source: RateSource) -> Case {
    let law = Pds::new(Arms::default(), gains, Limits::default()).unwrap();
    pds_case(name, Encoders::new(law, source, Actuation::default()).unwrap())
}

pub fn paper(name: &'static str, gains: &Gains, source: RateSource) -> Case {
    let law = Nabfc::new(Arms::default(), *gains).unwrap();
    nabfc_case(name, Encoders::new(law, source, Actuation::default()).unwrap(), &gains.rbf)
}

pub fn root_strain(name: &'static str, gains: &RootStrainGains, source: RateSource) -> Case {
    let layout = RbfLayout::default();
    let law = RootStrain::new(Arms::default(), *gains, Actuation::default(), source, &layout).unwrap();
    nabfc_case(name, law, &layout)
}

/// The paper's gains, everything smooth: a wide sat.
pub fn smooth() -> Gains {
    Gains { sat_limit: 10.0, ..Gains::default() }
}

pub fn networks() -> RootStrainGains {
    RootStrainGains { learner: Learner::Networks, ..RootStrainGains::default() }
}

/// Every law in every way of running.
pub fn cases() -> Vec<Case> {
    let (measured, estimated) = (RateSource::Measured, RateSource::Estimated);
    let unfiltered = RootStrainGains { strain_rate_bandwidth: 0.0, ..RootStrainGains::default() };
    let ball = |radius: f64| {
        let mut gains = smooth();
        gains.object.w_max = radius;
        gains.posture.iter_mut().for_each(|posture| posture.u_max = radius);
        gains
    };
    vec![
        pd("pd", PdGains::default(), measured),
        pd("pd, estimated", PdGains::tuned(), estimated),
        pd("pid", PdGains::pid(), measured),
        pd("pid, estimated", PdGains::pid(), estimated),
        pds("pds", PdsGains::default(), measured),
        pds("pds with integrals", PdsGains { ki: 40.0, ki_arm: [20.0, 15.0], ..PdsGains::tuned() }, measured),
        paper("paper", &smooth(), measured),
        paper("paper, no filter", &Gains { shear_rate_bandwidth: 0.0, ..smooth() }, measured),
        paper("paper without networks", &smooth().without_networks(), measured),
        paper("paper, estimated", &smooth(), estimated),
        paper("paper in balls", &ball(0.3), measured),
        root_strain("root strain", &RootStrainGains::default(), measured),
        root_strain("root strain, fast", &RootStrainGains::fast(), measured),
        root_strain("root strain, certified", &RootStrainGains::certified(), measured),
        root_strain("root strain, no filter", &unfiltered, measured),
        root_strain("root strain, estimated", &RootStrainGains::default(), estimated),
        root_strain("root strain with networks", &networks(), measured),
        root_strain("root strain with networks, estimated", &networks(), estimated),
    ]
}

/// What the plant measures, as a law reads it.
pub fn read(plant: &Plant, reference: References) -> Inputs {
    let measured = measurements(&plant.measured(), plant.uncertainty().root_moment_dot);
    Inputs { measured, reference }
}

fn measurements(measured: &Measured, root_moment_dot: [f64; 2]) -> Measurements {
    let Measured { theta, theta_dot, y_object, y_object_dot, root_moment, tip_shear, tip_shear_dot } = *measured;
    Measurements { theta, theta_dot, y_object, y_object_dot, root_moment, tip_shear, tip_shear_dot, root_moment_dot }
}

/// What the paper asks for, or a small part of it that leaves all limits alone.
pub fn share(part: f64) -> References {
    let whole = References::default();
    References { lambda1_ref: part * whole.lambda1_ref, theta1_ref: part * whole.theta1_ref }
}

/// A closed loop.
pub struct Loop {
    pub plant: Plant,
    pub case: Case,
    pub regimes: Regimes,
    pub reference: References,
    /// External disturbances.
    pub load: grasp_plant::Inputs,
    /// Decisions that have changed a regime.
    pub changes: usize,
}

impl Loop {
    /// The grasp at rest, the law in its initial state.
    pub fn new(mut case: Case, parameters: Parameters, reference: References, load: grasp_plant::Inputs) -> Self {
        let plant = Plant::new(parameters).unwrap();
        let inputs = read(&plant, reference);
        case.law.initialize(&inputs);
        let mut regimes = Regimes::default();
        case.law.decide(&inputs, &mut regimes);
        Self { plant, case, regimes, reference, load, changes: 0 }
    }

    pub fn states(&self) -> Vec<f64> {
        let n = self.plant.state_count();
        let mut x = vec![0.0; n + self.case.states];
        let (plant, law) = x.split_at_mut(n);
        self.plant.continuous_states(plant);
        self.case.law.continuous_states(law);
        x
    }

    pub fn put(&mut self, x: &[f64]) -> Inputs {
        let (plant, law) = x.split_at(self.plant.state_count());
        self.plant.set_continuous_states(plant).unwrap();
        self.case.law.set_continuous_states(law).unwrap();
        read(&self.plant, self.reference)
    }

    pub fn driven(&self, commands: grasp_control::Commands) -> grasp_plant::Inputs {
        grasp_plant::Inputs { torque_command: commands.tau, force_command: commands.u, ..self.load }
    }

    /// The Jacobian of the whole system where it is, from the exact products of its parts.
    pub fn jacobian(&mut self) -> DMatrix<f64> {
        let inputs = read(&self.plant, self.reference);
        let commands = self.case.law.present_commands(&inputs);
        let driven = self.driven(commands);
        let (n, size) = (self.plant.state_count(), self.plant.state_count() + self.case.states);
        let mut jacobian = DMatrix::zeros(size, size);
        for column in 0..size {
            let mut unit = vec![0.0; size];
            unit[column] = 1.0;
            let (plant, law) = unit.split_at(n);
            let outputs = self.plant.output_change(&driven, plant, &grasp_plant::Inputs::ZERO);
            let measured = measurements(&outputs.measured, outputs.uncertainty.root_moment_dot);
            let reference = References { lambda1_ref: 0.0, theta1_ref: 0.0 };
            let seen = Inputs { measured, reference };
            let along = Direction { states: law, inputs: &seen };
            let commands = self.case.law.command_change(&inputs, along);
            let change = grasp_plant::Inputs {
                torque_command: commands.tau,
                force_command: commands.u,
                ..grasp_plant::Inputs::ZERO
            };
            let mut rates = vec![0.0; size];
            let (plant_rates, law_rates) = rates.split_at_mut(n);
            self.plant.derivative_change(&driven, plant, &change, plant_rates);
            self.case.law.derivative_change(&inputs, &self.regimes, along, law_rates);
            jacobian.column_mut(column).copy_from_slice(&rates);
        }
        jacobian
    }

    /// The state at `end`, and when something happened.
    pub fn run(&mut self, end: f64, tolerance: f64) -> (Vec<f64>, Vec<f64>) {
        let mut x = self.states();
        let events = integrate(self, &mut x, 0.0, end, tolerance);
        self.put(&x);
        (x, events)
    }

    /// The sampled loop to the same time in so many steps.
    pub fn sample(&mut self, end: f64, steps: u32) -> Vec<f64> {
        let h = end / f64::from(steps);
        for _ in 0..steps {
            let seen = read(&self.plant, self.reference);
            let commands = self.case.law.commands(&seen);
            let driven = self.driven(commands);
            self.case.law.step(h, &seen, &Inputs::HELD).unwrap();
            self.plant.step(h, &driven, &grasp_plant::Inputs::ZERO).unwrap();
        }
        self.states()
    }
}

impl System for Loop {
    fn rates(&mut self, _time: f64, x: &[f64], out: &mut [f64]) {
        let inputs = self.put(x);
        let commands = self.case.law.present_commands(&inputs);
        let driven = self.driven(commands);
        let (plant, law) = out.split_at_mut(self.plant.state_count());
        self.plant.derivatives(&driven, plant);
        self.case.law.derivatives(&inputs, &self.regimes, law);
    }

    fn scales(&self) -> Vec<f64> {
        let plant = Plant::state_variables(self.plant.parameters().order);
        plant.iter().map(|state| state.nominal).chain(self.case.scales.iter().copied()).collect()
    }

    fn indicators(&mut self, _time: f64, x: &[f64]) -> Vec<f64> {
        let inputs = self.put(x);
        let commands = self.case.law.present_commands(&inputs);
        let driven = self.driven(commands);
        let mut plant = vec![0.0; Plant::EVENT_INDICATORS];
        self.plant.event_indicators(&driven, &mut plant);
        // Contact changes nothing in the motion.
        plant.truncate(Plant::EVENT_INDICATORS - 2);
        let mut law = vec![0.0; self.case.indicators];
        self.case.law.event_indicators(&inputs, &self.regimes, &mut law);
        plant.extend(law);
        plant
    }

    fn event(&mut self, _time: f64, x: &mut [f64]) {
        let inputs = self.put(x);
        let decision = self.case.law.decide(&inputs, &mut self.regimes);
        self.changes += usize::from(decision.regimes);
        if decision.states {
            x.copy_from_slice(&self.states());
        }
    }
}
