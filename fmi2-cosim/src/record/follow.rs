//! A sink that keeps [some columns at every step](Follow).

use std::io;

use super::{Column, Pick, Points, Sink, Table};

/// Keeps some columns at every communication point of a run that [follows](crate::master::Master::follow) them, and wants nothing
/// else to be read. A column that is not followed has no numbers.
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

    fn idle(&mut self) -> f64 {
        f64::INFINITY
    }

    fn row(&mut self, _: f64, _: &[f64]) -> io::Result<()> {
        Ok(())
    }

    fn points(&mut self, points: &Points) -> io::Result<()> {
        let Pick { indices, table } = &mut self.picked;
        table.extend(points, indices);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_step_is_in_the_table() {
        let columns = ["a", "b"].map(|name| Column { name: name.into(), ..Column::default() });
        let mut follow = Follow::new(&columns, |name| name == "b");
        let mut points = Points::new(vec![0, 1]);
        for step in 0..300 {
            let value = f64::from(step);
            if points.push(value, &[7.0, value]) {
                follow.points(&points).unwrap();
                points.clear();
            }
            // What is a row, too, is there only once.
            follow.row(value, &[7.0, value]).unwrap();
        }
        follow.points(&points).unwrap();
        let table = follow.table();
        assert_eq!((table.columns().len(), table.column("b")), (1, Some(table.times())));
        assert!(table.times().iter().copied().eq((0..300).map(f64::from)));
    }
}
