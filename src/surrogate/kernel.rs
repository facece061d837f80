//! How alike the values at two points are: a constant, a linear part and a smooth one.

/// Inputs that share a length: from one to the next so much further, the smooth part forgets.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Group {
    /// Places of the inputs.
    pub(crate) inputs: std::ops::Range<usize>,
}

/// The parameters of a kernel; all are standard deviations and lengths, so above zero.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Kernel {
    /// Groups of inputs.
    pub(super) groups: Vec<Group>,
    /// Of the constant part.
    pub(super) constant: f64,
    /// Of the smooth part.
    pub(super) smooth: f64,
    /// Of what is not smooth: the values' own noise.
    pub(super) noise: f64,
    /// Slopes of the linear part, a group.
    pub(super) slopes: Vec<f64>,
    /// Lengths of the smooth part, a group.
    pub(super) lengths: Vec<f64>,
}

impl Kernel {
    /// A kernel of inputs in groups, before it was fitted.
    pub(crate) fn new(groups: Vec<Group>) -> Self {
        let each = |value: f64| vec![value; groups.len()];
        Self { constant: 2.0, smooth: 0.1, noise: 0.005, slopes: each(0.1), lengths: each(1.5), groups }
    }

    /// The covariance of values at two points, without noise.
    pub(super) fn covariance(&self, a: &[f64], b: &[f64]) -> f64 {
        let mut linear = self.constant * self.constant;
        let mut far = 0.0;
        for ((group, slope), length) in self.groups.iter().zip(&self.slopes).zip(&self.lengths) {
            let (mut products, mut squares) = (0.0, 0.0);
            for (x, y) in a[group.inputs.clone()].iter().zip(&b[group.inputs.clone()]) {
                products += x * y;
                squares += (x - y) * (x - y);
            }
            linear += slope * slope * products;
            far += squares / (length * length);
        }
        // Matern's kernel of order 5/2 (4.17): twice differentiable, as what queues do is not smoother.
        let root = (5.0 * far).sqrt();
        linear + self.smooth * self.smooth * (1.0 + root + root * root / 3.0) * (-root).exp()
    }

    /// The parameters that a fit changes.
    pub(super) fn parameters(&mut self) -> Vec<(&mut f64, Prior)> {
        let Self { smooth, noise, slopes, lengths, .. } = self;
        let mut all = vec![(smooth, Prior { median: 0.1, spread: 1.0 }), (noise, Prior { median: 0.004, spread: 0.7 })];
        all.extend(slopes.iter_mut().map(|slope| (slope, Prior { median: 0.1, spread: 1.0 })));
        all.extend(lengths.iter_mut().map(|length| (length, Prior { median: 1.5, spread: 0.8 })));
        all
    }
}

/// What is thought of a parameter beforehand: its logarithm is normal.
#[derive(Clone, Copy, Debug)]
pub(super) struct Prior {
    /// Its median.
    pub(super) median: f64,
    /// The logarithm's standard deviation.
    pub(super) spread: f64,
}

impl Prior {
    /// The logarithm of the density, but for a constant.
    pub(super) fn log_density(&self, value: f64) -> f64 {
        -0.5 * ((value / self.median).ln() / self.spread).powi(2)
    }
}
