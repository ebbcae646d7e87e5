//! A sink that keeps [some columns at every step](Follow).

use std::io;

use super::{Column, Pick, Sink, Table};

/// Keeps some columns at every communication point of a run that [follows](crate::master::Master::follow) them, and wants nothing
/// else to be read.
#[derive(Debug)]
pub struct Follow {
    picked: Pick,
    coarse: Coarse,
}

/// Columns in single precision, and their values.
pub type Singles = Vec<(Column, Vec<f32>)>;

/// What is kept in single precision. A step has one value of each column, which are far from each other: so a few steps are
/// collected first.
#[derive(Debug, Default)]
struct Coarse {
    places: Vec<usize>,
    columns: Singles,
    /// The last values that are not in their columns yet, step by step.
    waiting: Vec<f32>,
}

impl Coarse {
    /// So many steps at once.
    const STEPS: usize = 64;

    #[allow(clippy::cast_possible_truncation)] // that is what they are kept for
    fn push(&mut self, values: &[f64]) {
        self.waiting.extend(self.places.iter().map(|place| values[*place] as f32));
        if self.waiting.len() >= Self::STEPS * self.places.len() {
            self.put_away();
        }
    }

    fn put_away(&mut self) {
        let width = self.places.len();
        for (place, (_, values)) in self.columns.iter_mut().enumerate() {
            values.extend(self.waiting.chunks_exact(width).map(|step| step[place]));
        }
        self.waiting.clear();
    }
}

impl Follow {
    /// Those of `columns` that `wanted` accepts.
    pub fn new(columns: &[Column], wanted: impl Fn(&str) -> bool) -> Self {
        Self { picked: Pick::new(columns, wanted), coarse: Coarse::default() }
    }

    /// And those that `wanted` accepts in single precision, which are not in the table; those that already are in it stay there.
    #[must_use]
    pub fn and_coarsely(mut self, columns: &[Column], wanted: impl Fn(&str) -> bool) -> Self {
        for (place, column) in columns.iter().enumerate() {
            if wanted(&column.name) && !self.picked.indices.contains(&place) {
                self.coarse.places.push(place);
                self.coarse.columns.push((column.clone(), Vec::new()));
            }
        }
        self
    }

    /// The same, with room for so many communication points from the beginning.
    #[must_use]
    pub fn with_room(mut self, points: usize) -> Self {
        self.picked.table = self.picked.table.with_room(points);
        self.coarse.columns.iter_mut().for_each(|(_, values)| values.reserve_exact(points));
        self.coarse.waiting.reserve_exact(Coarse::STEPS * self.coarse.places.len());
        self
    }

    /// Which of so many columns it keeps, as [`Master::follow`](crate::master::Master::follow) wants to know.
    #[must_use]
    pub fn columns(&self, count: usize) -> Vec<bool> {
        let Self { picked, coarse } = self;
        (0..count).map(|index| picked.indices.contains(&index) || coarse.places.contains(&index)).collect()
    }

    /// What was kept, but for single precision.
    #[must_use]
    pub fn table(&self) -> &Table {
        &self.picked.table
    }

    /// What was kept: the table, and the columns in single precision, which are as long.
    #[must_use]
    pub fn into_parts(mut self) -> (Table, Singles) {
        self.coarse.put_away();
        (self.picked.table, self.coarse.columns)
    }
}

impl Sink for Follow {
    fn wants(&mut self, _: f64) -> bool {
        false
    }

    fn row(&mut self, time: f64, values: &[f64]) -> io::Result<()> {
        self.coarse.push(values);
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
    fn every_step_is_in_every_column() {
        let columns = ["a", "b", "c", "d"].map(|name| Column { name: name.into(), ..Column::default() });
        for steps in [0_u32, 1, 63, 64, 65, 128, 1000] {
            let mut follow = Follow::new(&columns, |name| name == "c")
                .and_coarsely(&columns, |name| name != "b")
                .with_room(usize::try_from(steps).unwrap());
            assert_eq!(follow.columns(4), [true, false, true, true]);
            for step in 0..steps {
                let value = f64::from(step);
                let row = [value + 0.1, 7.0, value, -value];
                if step % 10 == 0 { follow.row(value, &row) } else { follow.between(value, &row) }.unwrap();
            }
            let (table, singles) = follow.into_parts();
            assert_eq!(table.columns().len(), 1);
            let [(a, first), (d, last)] = &singles[..] else { panic!("{} columns", singles.len()) };
            assert_eq!((a.name.as_str(), d.name.as_str()), ("a", "d"));
            let exact = table.column("c").unwrap();
            assert!(exact.iter().copied().eq((0..steps).map(f64::from)) && exact == table.times());
            #[allow(clippy::cast_possible_truncation)]
            let singles = |value: fn(f64) -> f64| exact.iter().map(|time| value(*time) as f32).collect::<Vec<_>>();
            assert_eq!((first, last), (&singles(|time| time + 0.1), &singles(|time| -time)));
        }
        // Nothing in single precision.
        let mut follow = Follow::new(&columns, |_| true);
        follow.row(0.0, &[1.0; 4]).unwrap();
        assert_eq!(follow.into_parts().1.len(), 0);
    }
}
