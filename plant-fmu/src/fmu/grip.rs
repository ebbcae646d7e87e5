//! When and where contact was lost: remembered during a run, told at its end, in one line.

use grasp_plant::{Inputs, Plant};
use serde::{Deserialize, Serialize};

/// Tension that is more than rounding \[N\].
const TENSION: f64 = 1e-9;

/// What is remembered of both tips.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Grip {
    /// Until when it has been watched \[s\].
    until: f64,
    tips: [Tip; 2],
}

/// What is remembered of a tip. Times are those of the communication points.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Tip {
    /// The end of the first step after which its contact was lost, and of the last \[s\].
    first: f64,
    last: f64,
    /// How long in all \[s\]; never negative.
    duration: f64,
    /// Largest tension that the model bore \[N\]; zero where it bears none.
    tension: f64,
    /// How often it has opened so far.
    openings: u32,
    /// The begin of the first step in which it opened, and the end of the last \[s\].
    within: (f64, f64),
}

impl Grip {
    /// Nothing, at the start of a run.
    pub fn from(start: f64) -> Self {
        Self { until: start, ..Self::default() }
    }

    /// A step ends; returns its size.
    #[inline]
    pub fn passed(&mut self, time: f64) -> f64 {
        let size = time - self.until;
        self.until = time;
        size
    }

    /// Looks at the contacts at the end of a step of this size.
    #[inline(never)]
    pub fn look(&mut self, time: f64, size: f64, plant: &Plant, inputs: &Inputs) {
        let Some(contact) = plant.state().contact.as_deref() else {
            self.pulled(time, size, plant.contact_force(inputs));
            return;
        };
        for ((tip, touching), openings) in self.tips.iter_mut().zip(contact.touching).zip(contact.openings) {
            if openings > tip.openings {
                tip.opened(openings, time, size);
            }
            if openings > 0 && !touching {
                tip.lost(time, size);
            }
        }
    }

    /// A contact that can't open may bear tension.
    fn pulled(&mut self, time: f64, size: f64, force: [f64; 2]) {
        for (tip, force) in self.tips.iter_mut().zip(force) {
            if force < -TENSION {
                tip.lost(time, size);
                tip.tension = tip.tension.max(-force);
            }
        }
    }

    /// What there is to say at the end of a run. Where tips can leave the object, `plant` knows how often they did, also within
    /// steps.
    pub fn summary(&self, plant: &Plant) -> Option<String> {
        let openings = plant.state().contact.as_deref().map(|contact| contact.openings);
        let of_tip = |index: usize| {
            let tip = &self.tips[index];
            let number = index + 1;
            match openings {
                None if tip.duration > 0.0 => Some(format!(
                    "tip {number} from t = {:.6} s to {:.6} s ({:.3} ms in all, with up to {:.3e} N of tension)",
                    tip.first,
                    tip.last,
                    1e3 * tip.duration,
                    tip.tension
                )),
                Some(openings) if openings[index] > 0 => Some(if tip.duration > 0.0 {
                    format!(
                        "tip {number} {}, seen from t = {:.6} s to {:.6} s ({:.3} ms in all)",
                        times(openings[index]),
                        tip.first,
                        tip.last,
                        1e3 * tip.duration
                    )
                } else {
                    format!(
                        "tip {number} {}, between communication points from t = {:.6} s to {:.6} s",
                        times(openings[index]),
                        tip.within.0,
                        tip.within.1
                    )
                }),
                _ => None,
            }
        };
        let said: Vec<String> = [of_tip(0), of_tip(1)].into_iter().flatten().collect();
        if said.is_empty() {
            return None;
        }
        let what = match openings {
            None => {
                "contact_model = bilateral held the arms to the object, which no real grasp does: start with a preload, or set \
                     unilateral"
            }
            Some(_) => "see gap1, gap2 and impacts1, impacts2",
        };
        Some(format!("contact lost: {}. {what}", said.join("; ")))
    }
}

impl Tip {
    #[cold]
    fn opened(&mut self, openings: u32, time: f64, size: f64) {
        if self.openings == 0 {
            self.within.0 = time - size;
        }
        (self.openings, self.within.1) = (openings, time);
    }

    fn lost(&mut self, time: f64, size: f64) {
        if self.duration == 0.0 {
            self.first = time;
        }
        self.last = time;
        self.duration += size;
    }
}

fn times(count: u32) -> String {
    if count == 1 { "once".into() } else { format!("{count} times") }
}
