//! Some columns at communication points that follow each other.

/// The values of the columns that are [followed](crate::master::Master::follow), at up to [`Points::MOST`] communication points: who
/// looks at many of them at once is called seldom.
#[derive(Debug)]
pub struct Points {
    /// The places of the columns in a row.
    places: Vec<usize>,
    times: Vec<f64>,
    /// Column after column, each with room for all points.
    values: Vec<f64>,
}

impl Points {
    /// So many points are passed on at once.
    pub const MOST: usize = 128;

    pub(crate) fn new(places: Vec<usize>) -> Self {
        let values = vec![0.0; Self::MOST * places.len()];
        Self { places, times: Vec::with_capacity(Self::MOST), values }
    }

    /// Adds a point with the values of this row. True when no more are to come.
    pub(crate) fn push(&mut self, time: f64, row: &[f64]) -> bool {
        let Self { places, times, values } = self;
        Self::put_column_by_column(values, times.len(), row, places);
        times.push(time);
        times.len() == Self::MOST
    }

    /// The same of values that are at other places than in a row: `places` has one for each column.
    #[inline]
    pub(crate) fn push_from(&mut self, time: f64, values: &[f64], places: &[usize]) -> bool {
        Self::put_column_by_column(&mut self.values, self.times.len(), values, places);
        self.times.push(time);
        self.times.len() == Self::MOST
    }

    #[inline]
    fn put_column_by_column(columns: &mut [f64], point: usize, values: &[f64], places: &[usize]) {
        let (columns, _) = columns.as_chunks_mut::<{ Self::MOST }>();
        // Two iterators in one would be put together by a call, at every step.
        let mut places = places.iter();
        for column in columns {
            let Some(place) = places.next() else { break };
            column[point] = values[*place];
        }
    }

    pub(crate) fn clear(&mut self) {
        self.times.clear();
    }

    /// Whether there are none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.times.is_empty()
    }

    /// Times of the points in s.
    #[must_use]
    pub fn times(&self) -> &[f64] {
        &self.times
    }

    /// The values of the column that is at this place of a row, if it is there: one for each point.
    #[must_use]
    pub fn column(&self, place: usize) -> Option<&[f64]> {
        let index = self.places.iter().position(|known| *known == place)?;
        Some(&self.values[index * Self::MOST..][..self.times.len()])
    }

    /// Writes the values of one of the points to their places in a row, as far as it reaches.
    ///
    /// # Panics
    /// When there are not that many points.
    pub fn put(&self, point: usize, row: &mut [f64]) {
        assert!(point < self.times.len(), "there are {} points", self.times.len());
        for (place, column) in self.places.iter().zip(self.values.chunks_exact(Self::MOST)) {
            if let Some(cell) = row.get_mut(*place) {
                *cell = column[point];
            }
        }
    }
}
