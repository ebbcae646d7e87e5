//! Which numbers an axis shows.

/// Round values inside a range, about `wanted` of them, and the decimals they need.
pub(super) fn ticks(range: (f64, f64), wanted: f64) -> (Vec<f64>, usize) {
    let raw = (range.1 - range.0) / wanted.max(1.0);
    let power = 10_f64.powf(raw.log10().floor());
    let distance = |step: &f64| (step / raw).ln().abs();
    let steps = [1.0, 2.0, 5.0, 10.0].map(|factor| factor * power);
    let step = steps.into_iter().min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap_or(power);
    #[allow(clippy::cast_possible_truncation, clippy::cast_sign_loss)] // a handful
    let decimals = (-step.log10() - 1e-9).ceil().max(0.0) as usize;
    let mut ticks = Vec::new();
    let mut index = (range.0 / step - 1e-9).ceil();
    while index * step <= range.1 + 1e-9 * step {
        ticks.push(index * step);
        index += 1.0;
    }
    (ticks, decimals)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_inside() {
        assert_eq!(ticks((0.0, 5.0), 5.0), (vec![0.0, 1.0, 2.0, 3.0, 4.0, 5.0], 0));
        let (values, decimals) = ticks((-0.012, 0.53), 6.0);
        assert_eq!((values.len(), decimals), (6, 1));
        assert_eq!(ticks((0.0, 0.003), 3.0).1, 3);
    }
}
