//! What is left out where only instances are made.

use serde::{Deserialize, Serialize};

use super::Declarations;
use crate::layout::Layout;
use crate::{Declare, Failure, Info, Model, ModelExchange, Step, Unit, Variables};

#[derive(Clone, Default, Serialize, Deserialize)]
struct Everything {
    u: [f64; 2],
    slope: [f64; 2],
    y: f64,
    rate: f64,
    x: f64,
    x_dot: f64,
    count: i32,
    on: bool,
    length: f64,
}

impl Declare for Everything {
    const INFO: Info = Info { name: "Everything", ..Info::new() };

    fn variables(variables: &mut Variables<Self>) {
        let outputs = variables.evaluation(|m| m.y = m.u[0] + m.x);
        let rates = variables.evaluation(|m| (m.x_dot, m.rate) = (m.u[1], m.u[1]));
        let percent: Unit = "1".parse().unwrap();
        variables
            .input_array("u{}", |m| &mut m.u)
            .unit("rad")
            .display_degrees()
            .ramp_array(|m| &mut m.slope)
            .description("Input {}");
        variables
            .output("y", outputs, |m| &mut m.y)
            .unit("rad")
            .display_unit("mrad", 1e3)
            .depends_on(["u1"])
            .starts_from(["u2"])
            .depends_on_states(["x"])
            .rate(rates, |m| &mut m.rate)
            .description("Output");
        variables.output("x", rates, |m| &mut m.x).state().nominal(3.0).unit("rad").description("State");
        variables.local("der(x)", rates, |m| &mut m.x_dot).derivative_of("x").unit("rad/s").description("Its rate");
        variables.parameter("count", |m| &mut m.count).range(0.0, 7.0).description("A number");
        variables.parameter("on", |m| &mut m.on).tunable().description("A switch");
        variables.parameter("length", |m| &mut m.length).other_unit(&percent).min(0.0).description("A ratio");
    }
}

impl Model for Everything {
    fn step(&mut self, _: &mut Step<'_>) -> Result<(), Failure> {
        Ok(())
    }
}

impl ModelExchange for Everything {}

/// All that instances look at is the same, and what they do not look at is left out.
#[test]
fn a_brief_layout_does_all_that_the_whole_one_does() {
    let whole = Layout::build::<Everything>().unwrap();
    let brief = Layout::of(Declarations::brief::<Everything>());
    assert_eq!(whole.references, brief.references);
    assert_eq!((whole.input_dependent, &whole.ramps), (brief.input_dependent, &brief.ramps));
    assert_eq!(whole.has_rates(), brief.has_rates());
    let reals = |layout: &Layout| -> Vec<_> {
        let of = |r: &crate::layout::RealSlot| (r.min, r.max, r.offset, r.variable, r.settable, r.kind, r.run, r.needs);
        layout.reals.iter().map(of).collect()
    };
    assert_eq!(reals(&whole), reals(&brief));
    let slots = |layout: &Layout| -> Vec<_> {
        let of = |s: &crate::layout::Slot| (s.variable, s.causality, s.settable, s.evaluation);
        [&layout.integers, &layout.booleans, &layout.strings]
            .map(|slots| slots.iter().map(of).collect::<Vec<_>>())
            .into()
    };
    assert_eq!(slots(&whole), slots(&brief));
    let states = |layout: &Layout| -> Vec<_> {
        let continuous = layout.continuous.as_ref().unwrap();
        continuous.states.iter().map(|slot| (slot.state, slot.derivative, slot.nominal)).collect()
    };
    assert_eq!(states(&whole), states(&brief));
    for (whole, brief) in whole.variables.iter().zip(&brief.variables) {
        let kept = |v: &crate::variable::Variable| {
            (v.name.clone(), v.causality, v.variability, v.min, v.max, v.nominal, v.is_state, v.derivative_of.clone())
        };
        assert_eq!(kept(whole), kept(brief));
        assert_eq!(whole.depends_on.len(), brief.depends_on.len());
        assert!(
            !whole.description.is_empty() && brief.description.is_empty() && brief.unit.is_none(),
            "{}",
            whole.name
        );
        assert!(brief.display_unit.is_none() && brief.starts_from.is_empty() && brief.depends_on_states.is_none());
    }
}
