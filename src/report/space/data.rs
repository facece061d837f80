//! What a space of machines is like.

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
    /// How much there is, and how much of it was replayed.
    pub size: Size,
    /// Wrong pixels of each policy.
    pub policies: Vec<PolicyPixels>,
    /// Machines under policies, in the order in which they were drawn.
    pub designs: Vec<Design>,
    /// What each field does.
    pub sensitivities: Vec<Sensitivity>,
    /// How good predictions were, by figure.
    pub accuracy: BTreeMap<String, Accuracy>,
}

/// How much there is, and how much of it was replayed.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Size {
    /// Combinations of values for a machine of the experiment.
    pub combinations: f64,
    /// Machines that were drawn.
    pub machines: u64,
    /// Combinations that were drawn and are no machines.
    pub left_out: u64,
    /// Why the first of them is none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub why: Option<String>,
    /// Replays, and how many the config allows.
    pub replays: u64,
    /// See above.
    pub budget: u64,
    /// Passes over streams for what is known of all machines.
    pub passes: u64,
    /// Designs that may be on the front and were not replayed.
    pub unsure: u64,
}

/// Wrong pixels of a policy.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct PolicyPixels {
    /// The policy's name.
    pub policy: String,
    /// Pixels of the measured frames, and those that are wrong.
    pub pixels: u64,
    /// See above.
    pub wrong_pixels: u64,
}

/// A machine under a policy.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Design {
    /// The machine's name.
    pub machine: String,
    /// The policy's name.
    pub policy: String,
    /// What differs from the machine's file.
    pub changes: Vec<Change>,
    /// Whether its figures were measured by a replay; predicted otherwise.
    pub replayed: bool,
    /// Whether it was replayed, and no other design that was is better in everything.
    pub front: bool,
    /// Pixels that are wrong.
    pub wrong_pixels: u64,
    /// Cycles.
    pub cycles: f64,
    /// Bytes of the DRAM.
    pub dram_bytes: f64,
    /// Energy.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub joules: Option<f64>,
    /// Half the widths of the 95 % intervals of figures that are predicted.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub half_widths: BTreeMap<String, f64>,
    /// What was predicted before the replay, if anything was: expected value and ends of the 95 % interval.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub foreseen: BTreeMap<String, [f64; 3]>,
}

/// What a field does to a machine under a policy: the values with the least and the most, as means over all designs.
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
    /// The value with the least of it, and by how much that differs from the mean.
    pub least: (String, f64),
    /// The value with the most of it.
    pub most: (String, f64),
    /// The share of the variance of the figure's logarithm that the field alone explains.
    pub share: f64,
}

/// How good predictions of a figure were.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Accuracy {
    /// Designs that were predicted and then replayed.
    pub foreseen: Errors,
    /// Designs of the first set, each as the surrogate has it without that one.
    pub left_out: Errors,
}

/// Errors of predictions, as shares of what was measured.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Errors {
    /// How many there are.
    pub count: u64,
    /// Half of them are below this.
    pub median: f64,
    /// Nine of ten are below this.
    pub ninth: f64,
    /// The largest.
    pub most: f64,
    /// The share that is within 3 %.
    pub within: f64,
    /// The share whose 95 % interval holds.
    pub holds: f64,
}

impl Errors {
    /// Of errors, each with whether its interval held.
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
