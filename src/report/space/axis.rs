//! Logarithmic axes.

use crate::report::draw::canvas::tick_step;

/// A logarithmic axis from one place on a sheet to another.
pub(super) struct Axis {
    low: f64,
    high: f64,
    from: i32,
    to: i32,
}

impl Axis {
    /// The axis of all `values` that are above zero.
    pub(super) fn new(values: impl Iterator<Item = f64>, from: i32, to: i32) -> Self {
        let (low, high) = values
            .filter(|value| *value > 0.0)
            .fold((f64::INFINITY, 0.0), |(low, high): (f64, f64), value| (low.min(value), high.max(value)));
        let (low, high) = if low <= high { (low, high) } else { (1.0, 10.0) };
        // Both ends have a margin of a twentieth of the axis; an axis spans at least 4 %.
        let margin = (high / low).max(1.04).powf(0.05);
        Self { low: low / margin, high: high.max(low * 1.04) * margin, from, to }
    }

    /// The place of a value.
    pub(super) fn at(&self, value: f64) -> i32 {
        let share = (value.max(self.low) / self.low).ln() / (self.high / self.low).ln();
        self.from + (share * f64::from(self.to - self.from)).round() as i32
    }

    /// Values for ticks: 1, 2 and 5 times powers of ten, or even steps if these give fewer than 3 ticks.
    pub(super) fn ticks(&self, most: u32) -> Vec<f64> {
        let first = self.low.log10().floor() as i32;
        let inside = |value: &f64| (self.low..=self.high).contains(value);
        let powers = (first..first + 30).map(|power| 10f64.powi(power)).take_while(|power| *power <= self.high);
        let decades: Vec<f64> = powers.flat_map(|power| [1.0, 2.0, 5.0].map(|it| it * power)).filter(inside).collect();
        if decades.len() >= 3 {
            return decades;
        }
        let step = tick_step(self.high - self.low, most);
        let first = (self.low / step).ceil() as i64;
        (first..first + i64::from(most) + 2).map(|at| at as f64 * step).filter(inside).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_few_and_even() {
        let ticks = |low: f64, high: f64| Axis::new([low, high].into_iter(), 0, 100).ticks(5);
        assert_eq!(ticks(100.0, 1000.0), [100.0, 200.0, 500.0, 1000.0]);
        assert_eq!(ticks(1.01e6, 1.39e6), [1.0e6, 1.1e6, 1.2e6, 1.3e6, 1.4e6]);
        let axis = Axis::new([10.0, 1000.0].into_iter(), 0, 100);
        assert_eq!(axis.at(100.0), 50);
        assert!(!Axis::new(std::iter::empty(), 0, 100).ticks(5).is_empty());
    }
}
