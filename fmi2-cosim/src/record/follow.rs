//! A sink that keeps [some columns at every step](Follow).

use std::io;

use super::{Column, Pick, Sink, Table};

/// Keeps some columns at every communication point of a run that [follows](crate::master::Master::follow) them, and wants nothing
/// else to be read.
#[derive(Debug)]
pub struct Follow {
    picked: Pick,
}

impl Follow {
    /// Those of `columns` that `wanted` accepts.
    pub fn new(columns: &[Column], wanted: impl Fn(&str) -> bool) -> Self {
        Self { picked: Pick::new(columns, wanted) }
    }

    /// What was kept.
    #[must_use]
    pub fn table(&self) -> &Table {
        &self.picked.table
    }
}

impl Sink for Follow {
    fn wants(&mut self, _: f64) -> bool {
        false
    }

    fn row(&mut self, time: f64, values: &[f64]) -> io::Result<()> {
        self.picked.row(time, values)
    }

    fn between(&mut self, time: f64, values: &[f64]) -> io::Result<()> {
        self.row(time, values)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_step_is_in_the_table() {
        let columns = ["a", "b"].map(|name| Column { name: name.into(), ..Column::default() });
        let mut follow = Follow::new(&columns, |name| name == "b");
        for step in 0..100 {
            let value = f64::from(step);
            if step % 10 == 0 { follow.row(value, &[7.0, value]) } else { follow.between(value, &[7.0, value]) }
                .unwrap();
        }
        let table = follow.table();
        assert_eq!((table.columns().len(), table.column("b")), (1, Some(table.times())));
        assert!(table.times().iter().copied().eq((0..100).map(f64::from)));
    }
}
