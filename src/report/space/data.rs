//! The results of exploring a space of machines.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::quantity::Resolution;
use crate::report::sweep::Change;

/// A whole space.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct SpaceSummary {
    /// The experiment's name.
    pub experiment: String,
    /// The scene's name.
    pub scene: String,
    /// The fidelity level of the replays.
    pub fidelity: String,
    /// Numbers of the frames.
    pub frames: Vec<u32>,
    /// Size of the pictures.
    pub resolution: Resolution,
    /// The size of the space, and the effort.
    pub size: Size,
    /// Wrong pixels of each policy.
    pub policies: Vec<PolicyPixels>,
    /// Designs, which are machines under policies, in the order in which they were drawn.
    pub designs: Vec<Design>,
    /// The effect of each field.
    pub sensitivities: Vec<Sensitivity>,
    /// The accuracy of predictions, by figure.
    pub accuracy: BTreeMap<String, Accuracy>,
}

/// The size of the space, and the effort.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Size {
    /// Combinations of values for each machine of the experiment.
    pub combinations: f64,
    /// Machines that were drawn.
    pub machines: u64,
    /// Drawn combinations that are no valid machines.
    pub left_out: u64,
    /// Why the first of these combinations is not valid.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub why: Option<String>,
    /// Number of replays.
    pub replays: u64,
    /// Number of replays that the config allows.
    pub budget: u64,
    /// Passes over streams for the estimates of all designs.
    pub passes: u64,
    /// Designs that may be on the front, but were not replayed.
    pub unsure: u64,
}

/// Wrong pixels of a policy.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct PolicyPixels {
    /// The policy's name.
    pub policy: String,
    /// Pixels of the measured frames.
    pub pixels: u64,
    /// Wrong pixels of the measured frames.
    pub wrong_pixels: u64,
}

/// A machine under a policy.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Design {
    /// The machine's name.
    pub machine: String,
    /// The policy's name.
    pub policy: String,
    /// Fields that differ from the machine's file.
    pub changes: Vec<Change>,
    /// Whether its figures were measured by a replay; otherwise they are predicted.
    pub replayed: bool,
    /// Whether it was replayed and no other replayed design is better in everything.
    pub front: bool,
    /// Number of wrong pixels.
    pub wrong_pixels: u64,
    /// Cycles.
    pub cycles: f64,
    /// Bytes of the DRAM.
    pub dram_bytes: f64,
    /// Energy in J.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub joules: Option<f64>,
    /// Half the widths of the 95 % intervals of predicted figures.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub half_widths: BTreeMap<String, f64>,
    /// The predictions before the replay, if any: expected value and ends of the 95 % interval.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub foreseen: BTreeMap<String, [f64; 3]>,
}

/// The effect of a field on a machine under a policy: the values with the least and the largest figure, as means over
/// all designs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Sensitivity {
    /// The machine's name.
    pub machine: String,
    /// The policy's name.
    pub policy: String,
    /// The field's path.
    pub field: String,
    /// The figure.
    pub figure: String,
    /// The value with the least figure, and its relative difference from the mean.
    pub least: (String, f64),
    /// The value with the largest figure, and its relative difference from the mean.
    pub most: (String, f64),
    /// The share of the variance of the figure's logarithm that the field alone explains.
    pub share: f64,
}

/// The accuracy of predictions of a figure.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Accuracy {
    /// Designs that were predicted and then replayed.
    pub foreseen: Errors,
    /// Leave-one-out cross-validation: each design of the first set, predicted by a surrogate fitted without it.
    pub left_out: Errors,
}

/// Errors of predictions, as shares of the measured figures.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Errors {
    /// Number of predictions.
    pub count: u64,
    /// Half of the errors are at most this.
    pub median: f64,
    /// Nine of ten errors are at most this.
    pub ninth: f64,
    /// The largest error.
    pub most: f64,
    /// The share of predictions within 3 %.
    pub within: f64,
    /// The share of predictions whose 95 % interval holds.
    pub holds: f64,
}

impl Errors {
    /// From errors, each with whether its interval holds.
    pub(crate) fn new(mut errors: Vec<(f64, bool)>) -> Self {
        errors.sort_by(|a, b| a.0.total_cmp(&b.0));
        let Some(&(most, _)) = errors.last() else { return Self::default() };
        let count = errors.len();
        let at = |share: f64| errors[((count as f64 * share).ceil() as usize).clamp(1, count) - 1].0;
        let share = |of: fn(&&(f64, bool)) -> bool| errors.iter().filter(of).count() as f64 / count as f64;
        Self {
            count: count as u64,
            median: at(0.5),
            ninth: at(0.9),
            most,
            within: share(|it| it.0 <= 0.03),
            holds: share(|it| it.1),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_are_summed_up() {
        let errors = Errors::new((1..=10).map(|at| (f64::from(at) / 100.0, at != 10)).collect());
        let expected = Errors { count: 10, median: 0.05, ninth: 0.09, most: 0.1, within: 0.3, holds: 0.9 };
        assert_eq!(errors, expected);
        assert_eq!(Errors::new(Vec::new()), Errors::default());
    }
}
