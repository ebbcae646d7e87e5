//! Real variables that stand side by side are set and read together. Nobody can tell: any list of references does what its elements do one
//! by one.

use std::ffi::CString;
use std::ptr::null;

use fmi2_export::ffi::types::Status;
use fmi2_export::{Declare, Experiment, Failure, Info, Model, Step, Variables, field};
use proptest::prelude::*;
use serde::{Deserialize, Serialize};

#[path = "common/linked.rs"]
mod linked;
use linked::*;

/// Inputs 0 to 4 stand side by side in memory, but only the first three are alike; so do outputs 5 to 8, but they belong to two
/// evaluations, one of which panics if it is asked to. 9 is a parameter, 10 is where only a function leads.
#[derive(Clone, Default, Serialize, Deserialize)]
#[repr(C)]
struct Row {
    alike: [f64; 3],
    limited: [f64; 2],
    sums: [f64; 2],
    products: [f64; 2],
    factor: f64,
    distant: f64,
}

impl Declare for Row {
    const INFO: Info = Info { name: "Row", description: "Sums and products", ..Info::new() };

    fn variables(variables: &mut Variables<Self>) {
        let sums = variables.evaluation(|m| m.sums = [m.alike.iter().sum(), m.limited.iter().sum()]);
        let products = variables.evaluation(|m| {
            assert!(m.distant != 13.0, "thirteen");
            m.products = [m.alike.iter().product(), m.factor * m.distant];
        });
        variables.input_field("alike{}", field!(Self, alike)).description("Input {}");
        variables.input_field("limited{}", field!(Self, limited)).range(-1.0, 1.0).description("Limited input {}");
        variables.output_field("sum{}", sums, field!(Self, sums)).depends_on(inputs()).description("Sum {}");
        variables
            .output_field("product{}", products, field!(Self, products))
            .depends_on(inputs())
            .description("Product {}");
        variables.parameter_field("factor", field!(Self, factor)).tunable().description("Factor");
        variables.input("distant", |m| &mut m.distant).description("Input elsewhere");
    }
}

fn inputs() -> [&'static str; 6] {
    ["alike1", "alike2", "alike3", "limited1", "limited2", "distant"]
}

impl Model for Row {
    fn initialize(&mut self, _: &Experiment) -> Result<(), Failure> {
        Ok(())
    }

    fn step(&mut self, _: &mut Step<'_>) -> Result<(), Failure> {
        Ok(())
    }
}

fmi2_export::export!(Row);

/// An instance between two steps.
struct Slave(C);

impl Slave {
    fn new() -> Self {
        let guid = CString::new(FMUS.models()[0].description().unwrap().guid).unwrap();
        // SAFETY: as a host does.
        unsafe {
            let c = fmi2Instantiate(c"a".as_ptr(), 1, guid.as_ptr(), null(), &NO_CALLBACKS, 0, 0);
            for status in [
                fmi2SetupExperiment(c, 0, 0.0, 0.0, 0, 0.0),
                fmi2EnterInitializationMode(c),
                fmi2ExitInitializationMode(c),
                fmi2DoStep(c, 0.0, 1.0, 1),
            ] {
                assert_eq!(status, Status::Ok);
            }
            Self(c)
        }
    }

    fn set(&self, references: &[u32], values: &[f64]) -> Status {
        // SAFETY: as many values as references.
        unsafe { fmi2SetReal(self.0, references.as_ptr(), references.len(), values.as_ptr()) }
    }

    fn get(&self, references: &[u32]) -> (Status, Vec<u64>) {
        let mut values = vec![-7.0; references.len()];
        // SAFETY: as many places as references.
        let status = unsafe { fmi2GetReal(self.0, references.as_ptr(), references.len(), values.as_mut_ptr()) };
        (status, values.into_iter().map(f64::to_bits).collect())
    }

    /// All values, one by one.
    fn all(&self) -> Vec<u64> {
        (0..=10).flat_map(|reference| self.get(&[reference]).1).collect()
    }
}

impl Drop for Slave {
    fn drop(&mut self) {
        // SAFETY: as a host does.
        unsafe { fmi2FreeInstance(self.0) };
    }
}

/// Lists as hosts have them: from one reference on, backwards, or any.
fn references() -> impl Strategy<Value = Vec<u32>> {
    let forward = (0..12_u32, 1..12_u32).prop_map(|(first, count)| (first..first + count).collect());
    let backward = (0..12_u32).prop_map(|first| (0..=first).rev().collect());
    prop_oneof![4 => forward, 1 => backward, 2 => prop::collection::vec(0..12_u32, 1..8)]
}

fn value() -> impl Strategy<Value = f64> {
    prop_oneof![8 => -1.0..1.0, 2 => Just(-0.0), 1 => -2.0..2.0, 1 => Just(f64::NAN), 1 => Just(f64::INFINITY), 1 => Just(f64::MAX)]
}

proptest! {
    #[test]
    fn a_list_of_references_does_what_its_elements_do(
        lists in prop::collection::vec((references(), prop::collection::vec(value(), 12)), 1..6),
        asked in prop::collection::vec(references(), 1..6),
    ) {
        let (together, alone) = (Slave::new(), Slave::new());
        for (list, values) in &lists {
            let values = &values[..list.len().min(12)];
            let list = &list[..values.len()];
            let before = together.all();
            let may = list.iter().zip(values).all(|(reference, value)| match reference {
                0..=2 | 9 | 10 => value.is_finite(),
                3 | 4 => value.abs() <= 1.0,
                _ => false,
            });
            prop_assert_eq!(together.set(list, values) == Status::Ok, may, "{:?} {:?}", list, values);
            if may {
                for (reference, value) in list.iter().zip(values) {
                    prop_assert_eq!(alone.set(&[*reference], &[*value]), Status::Ok);
                }
            } else {
                prop_assert_eq!(together.all(), before, "nothing is set of a list that is refused");
            }
            prop_assert_eq!(together.all(), alone.all());
        }
        for list in &asked {
            let (status, values) = together.get(list);
            if list.iter().all(|reference| *reference <= 10) {
                let one_by_one: Vec<u64> = list.iter().flat_map(|reference| alone.get(&[*reference]).1).collect();
                prop_assert_eq!((status, values), (Status::Ok, one_by_one), "{:?}", list);
            } else {
                prop_assert_eq!((status, values), (Status::Error, vec![(-7.0_f64).to_bits(); list.len()]));
            }
        }
    }
}

/// An evaluation that panics ends the instance's life whichever way it is called.
#[test]
fn a_panic_while_a_group_is_read_is_an_error() {
    for list in [&[7, 8][..], &[8], &[8, 7]] {
        let slave = Slave::new();
        assert_eq!(slave.set(&[0, 1, 2], &[1.0, 2.0, 3.0]), Status::Ok);
        assert_eq!(slave.set(&[10], &[13.0]), Status::Ok);
        assert_eq!(slave.get(&[5, 6]), (Status::Ok, vec![6.0_f64.to_bits(), 0]));
        let nothing = vec![(-7.0_f64).to_bits(); list.len()];
        assert_eq!(slave.get(list), (Status::Error, nothing), "{list:?}");
        assert_eq!(slave.set(&[0, 1, 2], &[1.0, 2.0, 3.0]), Status::Error, "after an error");
        // SAFETY: as a host does.
        assert_eq!(unsafe { fmi2DoStep(slave.0, 1.0, 1.0, 1) }, Status::Error);
    }
}
