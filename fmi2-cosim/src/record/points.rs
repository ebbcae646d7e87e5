//! Some columns at communication points that follow each other.

/// The values of the columns that an observer [follows](crate::run::Observer::follows), at up to [`Points::MOST`] communication
/// points: who looks at many of them at once is called seldom.
#[derive(Debug)]
pub struct Points {
    /// The places of the columns in a row.
    places: Vec<usize>,
    times: Vec<f64>,
    /// Point after point.
    values: Vec<f64>,
}

impl Points {
    /// So many points are passed on at once.
    pub const MOST: usize = 128;

    pub(crate) fn new(places: Vec<usize>) -> Self {
        let (times, values) = (Vec::with_capacity(Self::MOST), Vec::with_capacity(Self::MOST * places.len()));
        Self { places, times, values }
    }

    /// Adds a point. True when no more are to come.
    #[inline]
    pub(crate) fn push(&mut self, time: f64, row: &[f64]) -> bool {
        self.times.push(time);
        for place in &self.places {
            self.values.push(row[*place]);
        }
        self.times.len() == Self::MOST
    }

    pub(crate) fn clear(&mut self) {
        self.times.clear();
        self.values.clear();
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.times.is_empty()
    }

    /// Where a point has the column that is at this place of a row, if it has it.
    #[must_use]
    pub fn place(&self, column: usize) -> Option<usize> {
        self.places.iter().position(|place| *place == column)
    }

    /// The points: time in s and values.
    pub fn iter(&self) -> impl Iterator<Item = (f64, &[f64])> {
        self.times.iter().copied().zip(self.values.chunks_exact(self.places.len().max(1)))
    }

    /// Writes the values of a point to their places in a row, as far as it reaches.
    pub fn put(&self, point: &[f64], row: &mut [f64]) {
        for (place, value) in self.places.iter().zip(point) {
            if let Some(cell) = row.get_mut(*place) {
                *cell = *value;
            }
        }
    }
}
