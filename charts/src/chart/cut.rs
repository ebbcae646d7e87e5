//! A line between two heights.

/// The pieces of a curve between two heights; each ends where the curve leaves.
pub(super) fn cut(points: &[(f64, f64)], (low, high): (f64, f64)) -> Vec<Vec<(f64, f64)>> {
    let is_inside = |y: f64| (low..=high).contains(&y);
    let mut pieces = Vec::new();
    let mut piece: Vec<(f64, f64)> = Vec::new();
    for (index, &(x, y)) in points.iter().enumerate() {
        if let Some(&(x0, y0)) = index.checked_sub(1).and_then(|before| points.get(before)) {
            // Where the way from the point before crosses the heights, in its order.
            let mut crossings: Vec<(f64, f64)> = [low, high]
                .into_iter()
                .filter(|edge| (y0 < *edge) != (y < *edge) && (y0 - y).abs() > 0.0)
                .map(|edge| (x0 + (edge - y0) / (y - y0) * (x - x0), edge))
                .collect();
            if y < y0 {
                crossings.reverse();
            }
            for crossing in crossings {
                piece.push(crossing);
                if piece.len() > 1 && !is_inside(f64::midpoint(crossing.1, y)) {
                    pieces.push(std::mem::take(&mut piece));
                }
            }
        }
        if is_inside(y) {
            piece.push((x, y));
        } else {
            piece.clear();
        }
    }
    pieces.push(piece);
    pieces.retain(|piece| !piece.is_empty());
    pieces
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curves_are_cut_where_they_leave_the_axis() {
        let points = [(0.0, 4.0), (1.0, 0.0), (2.0, 0.0), (4.0, -4.0), (5.0, -4.0), (6.0, 4.0), (8.0, 0.0)];
        assert_eq!(
            cut(&points, (-1.0, 2.0)),
            [
                vec![(0.5, 2.0), (1.0, 0.0), (2.0, 0.0), (2.5, -1.0)],
                vec![(5.375, -1.0), (5.75, 2.0)],
                vec![(7.0, 2.0), (8.0, 0.0)],
            ]
        );
        assert_eq!(cut(&points[..3], (-9.0, 9.0)), [points[..3].to_vec()]);
    }
}
