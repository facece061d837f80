//! The covariance of the values at two points: a constant, a linear and a smooth part.

/// Inputs that share one slope and one length scale.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Group {
    /// Positions of the inputs in a point.
    pub(crate) inputs: std::ops::Range<usize>,
}

/// The parameters of a kernel, all above zero: standard deviations, and length scales in units of the inputs.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Kernel {
    /// Groups of inputs.
    pub(super) groups: Vec<Group>,
    /// Standard deviation of the constant part.
    pub(super) constant: f64,
    /// Standard deviation of the smooth part.
    pub(super) smooth: f64,
    /// Standard deviation of the values' own noise.
    pub(super) noise: f64,
    /// Standard deviation of the slopes of the linear part, one per group.
    pub(super) slopes: Vec<f64>,
    /// Length scale of the smooth part, one per group.
    pub(super) lengths: Vec<f64>,
}

impl Kernel {
    /// A kernel with the parameters from which a fit starts. They are assumed.
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
        // Matern's kernel of order 5/2 (4.17): twice differentiable. Contention for resources is assumed to be no
        // smoother.
        let root = (5.0 * far).sqrt();
        linear + self.smooth * self.smooth * (1.0 + root + root * root / 3.0) * (-root).exp()
    }

    /// The parameters that a fit changes, with their priors. Medians and spreads are assumed.
    pub(super) fn parameters(&mut self) -> Vec<(&mut f64, Prior)> {
        let Self { smooth, noise, slopes, lengths, .. } = self;
        let mut all = vec![(smooth, Prior { median: 0.1, spread: 1.0 }), (noise, Prior { median: 0.004, spread: 0.7 })];
        all.extend(slopes.iter_mut().map(|slope| (slope, Prior { median: 0.1, spread: 1.0 })));
        all.extend(lengths.iter_mut().map(|length| (length, Prior { median: 1.5, spread: 0.8 })));
        all
    }
}

/// The prior of a parameter: its logarithm is normal.
#[derive(Clone, Copy, Debug)]
pub(super) struct Prior {
    /// The parameter's median.
    pub(super) median: f64,
    /// The standard deviation of the parameter's logarithm.
    pub(super) spread: f64,
}

impl Prior {
    /// The logarithm of the density, but for a constant.
    pub(super) fn log_density(&self, value: f64) -> f64 {
        -0.5 * ((value / self.median).ln() / self.spread).powi(2)
    }
}
