//! Results of policies and timing models under stress.

use serde::{Deserialize, Serialize};

use crate::quantity::Cycle;
use crate::report::format::{counted, percent};
use crate::student::student;

/// The version of the names in `summary.json`.
const SCHEMA: u32 = 3;

/// Results of all policies in all cases; `summary.json` holds them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct StressSummary {
    /// The version of these names.
    pub schema: u32,
    /// The policies, in the order of the columns.
    pub policies: Vec<StressPolicy>,
    /// The timing models that replayed the cases; the first is the truth for the others.
    pub models: Vec<StressModel>,
    /// The cases.
    pub cases: Vec<CaseSummary>,
    /// The effect of each answer to an open question.
    pub effects: Vec<Effect>,
    /// Number of random scenes behind the effects.
    pub effect_scenes: u32,
}

/// A policy under stress.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct StressPolicy {
    /// Its name.
    pub name: String,
    /// Whether it must never make a wrong decision.
    pub exact: bool,
}

/// A timing model under stress.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct StressModel {
    /// Its name.
    pub name: String,
    /// Whether its figures must equal the first model's.
    pub exact: bool,
}

/// A timing model's result for a case, over all streams.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum ModelVerdict {
    /// Every figure equals the first model's.
    Agrees,
    /// Some figure differs; the relative difference of cycles is at most this.
    Differs(f64),
    /// It could not replay a stream, for this reason.
    Failed(String),
}

impl ModelVerdict {
    /// Records that a stream takes `found` cycles in the model instead of `truth`.
    pub(crate) fn off_by(&mut self, truth: Cycle, found: Cycle) {
        let share = (found.0 as f64 - truth.0 as f64).abs() / truth.0.max(1) as f64;
        let before = if let Self::Differs(share) = self { *share } else { 0.0 };
        *self = Self::Differs(share.max(before));
    }
}

/// The results of a case.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct CaseSummary {
    /// Its name.
    pub name: String,
    /// Its subject.
    pub title: String,
    /// Wrong decisions of each policy, frame by frame.
    pub policies: Vec<Vec<FrameWrong>>,
    /// The result of each timing model.
    pub models: Vec<ModelVerdict>,
}

/// Wrong decisions in a frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct FrameWrong {
    /// Shadow rays decided on.
    pub shadow_rays: u64,
    /// Decided dark, though the light is visible.
    pub false_dark: u64,
    /// Decided lit, though the light is hidden.
    pub false_lit: u64,
}

impl FrameWrong {
    /// Wrong decisions of both kinds.
    pub(crate) fn wrong(&self) -> u64 {
        self.false_dark + self.false_lit
    }
}

/// The outcome of a case for a policy.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Outcome {
    /// No decision was wrong.
    Right,
    /// Some decisions were wrong, but none in the last frame.
    Healed {
        /// Frames with wrong decisions.
        frames: usize,
        /// The most in a frame.
        worst: u64,
    },
    /// Some decisions are wrong in the last frame.
    Wrong {
        /// Frames with wrong decisions.
        frames: usize,
        /// The most in a frame.
        worst: u64,
    },
}

impl Outcome {
    /// The outcome of some frames.
    pub(crate) fn of(all: &[FrameWrong]) -> Self {
        let frames = all.iter().filter(|frame| frame.wrong() > 0).count();
        let worst = all.iter().map(FrameWrong::wrong).max().unwrap_or(0);
        match all.last() {
            _ if frames == 0 => Self::Right,
            Some(last) if last.wrong() > 0 => Self::Wrong { frames, worst },
            _ => Self::Healed { frames, worst },
        }
    }
}

/// The effect of another answer to a question that the published text leaves open, against the default answers on the
/// same scenes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Effect {
    /// The answer, as written in a config.
    pub option: String,
    /// Change of the share of shadow traversal saved.
    pub saving: Shift,
    /// Change of the number of wrong decisions per million shadow rays.
    pub wrong_per_million: Shift,
}

/// A mean change over scenes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Shift {
    /// The mean.
    pub mean: f64,
    /// Half the width of its 95 % confidence interval.
    pub error: f64,
}

impl Shift {
    /// From the changes in several scenes, at least two, by Student's t.
    pub(crate) fn of(changes: &[f64]) -> Self {
        let count = changes.len() as f64;
        let mean = changes.iter().sum::<f64>() / count;
        let variance = changes.iter().map(|change| (change - mean).powi(2)).sum::<f64>() / (count - 1.0);
        Self { mean, error: student(count - 1.0) * (variance / count).sqrt() }
    }

    /// Whether the change is larger than half the width of its interval.
    pub(crate) fn matters(&self) -> bool {
        self.mean.abs() > self.error
    }
}

impl StressSummary {
    /// A summary of this version.
    pub(crate) fn new(
        policies: Vec<StressPolicy>,
        models: Vec<StressModel>,
        cases: Vec<CaseSummary>,
        effects: Vec<Effect>,
        effect_scenes: u32,
    ) -> Self {
        Self { schema: SCHEMA, policies, models, cases, effects, effect_scenes }
    }

    /// The number of cases in which exact policies were wrong: `8 exact policies: 0 wrong in 45 cases`.
    pub(crate) fn verdict(&self) -> String {
        let exact: Vec<usize> = (0..self.policies.len()).filter(|&at| self.policies[at].exact).collect();
        let is_wrong = |case: &&CaseSummary| exact.iter().any(|&at| Outcome::of(&case.policies[at]) != Outcome::Right);
        let wrong = self.cases.iter().filter(is_wrong).count();
        let failed = self.cases.iter().flat_map(|case| self.broken_models(case)).count();
        let models =
            if failed > 0 { format!("; {} must agree and do not", counted(failed, "result")) } else { String::new() };
        let policies = if exact.len() == 1 { "policy" } else { "policies" };
        format!("{} exact {policies}: {wrong} wrong in {}{models}", exact.len(), counted(self.cases.len(), "case"))
    }

    /// Wrong decisions of exact policies, and timing models that failed or differ although they must agree.
    pub(crate) fn broken(&self) -> Vec<String> {
        let of_case = |case| self.wrong_policies(case).chain(self.broken_models(case));
        self.cases.iter().flat_map(of_case).collect()
    }

    /// Exact policies with wrong decisions in a case.
    fn wrong_policies(&self, case: &CaseSummary) -> impl Iterator<Item = String> {
        let exact = self.policies.iter().zip(&case.policies).filter(|(policy, _)| policy.exact);
        let wrong = exact.filter(|(_, frames)| Outcome::of(frames) != Outcome::Right);
        wrong.map(|(policy, _)| format!("{} in {}", policy.name, case.name))
    }

    /// Timing models that failed in a case, or differ although they must agree.
    fn broken_models(&self, case: &CaseSummary) -> impl Iterator<Item = String> {
        self.models.iter().zip(&case.models).filter_map(|(model, verdict)| match verdict {
            ModelVerdict::Agrees => None,
            ModelVerdict::Differs(share) => {
                model.exact.then(|| format!("{} in {}: cycles differ by {}", model.name, case.name, percent(*share)))
            }
            ModelVerdict::Failed(why) => Some(format!("{} in {}: {why}", model.name, case.name)),
        })
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    fn frames(wrong: &[u64]) -> Vec<FrameWrong> {
        wrong.iter().map(|&wrong| FrameWrong { shadow_rays: 9, false_dark: wrong, false_lit: 0 }).collect()
    }

    #[test]
    fn outcomes_by_hand() {
        assert_eq!(Outcome::of(&frames(&[0, 0])), Outcome::Right);
        assert_eq!(Outcome::of(&[]), Outcome::Right);
        assert_eq!(Outcome::of(&frames(&[0, 3, 5, 0])), Outcome::Healed { frames: 2, worst: 5 });
        assert_eq!(Outcome::of(&frames(&[0, 3, 5])), Outcome::Wrong { frames: 2, worst: 5 });
    }

    #[test]
    fn a_shift_by_hand() {
        // Variance 4 over 12 scenes: the standard error is 2 / sqrt(12).
        let changes = [1.0, 5.0, 3.0, 1.0, 5.0, 3.0, 1.0, 5.0, 3.0, 1.0, 5.0, 3.0].map(|x: f64| x);
        let shift = Shift::of(&changes);
        let variance: f64 = 8.0 * 4.0 / 11.0;
        assert_eq!(shift.mean, 3.0);
        // The 97.5 % point of Student's t with 11 degrees of freedom, from a table.
        assert!((shift.error - 2.200_985 * (variance / 12.0).sqrt()).abs() < 1e-6);
        assert!(shift.matters());
        assert!(!Shift::of(&[0.0; 12]).matters());
    }

    pub(crate) fn summary() -> StressSummary {
        let policy = |name: &str, exact| StressPolicy { name: name.into(), exact };
        let case = CaseSummary {
            name: "C8".into(),
            title: "a dynamic blocker leaves".into(),
            policies: vec![frames(&[0, 0, 0]), frames(&[0, 78, 78])],
            models: vec![ModelVerdict::Agrees, ModelVerdict::Differs(0.5)],
        };
        let model = |name: &str, exact| StressModel { name: name.into(), exact };
        let models = vec![model("Cycle", true), model("Bound", false)];
        let shift = Shift { mean: 0.25, error: 0.125 };
        let effect = Effect { option: "partial: Sticky".into(), saving: shift, wrong_per_million: shift };
        StressSummary::new(vec![policy("Off", true), policy("Published", false)], models, vec![case], vec![effect], 12)
    }

    #[test]
    fn an_exact_policy_that_is_wrong_is_named() {
        let mut summary = summary();
        assert_eq!(summary.broken(), Vec::<String>::new());
        assert_eq!(summary.verdict(), "1 exact policy: 0 wrong in 1 case");
        summary.policies[1].exact = true;
        // Two policies are wrong in one case: no timing model is blamed for it.
        let third = summary.cases[0].policies[1].clone();
        summary.cases[0].policies.push(third);
        summary.policies.push(StressPolicy { name: "Other".into(), exact: true });
        assert_eq!(summary.verdict(), "3 exact policies: 1 wrong in 1 case");
        summary.cases[0].policies.pop();
        summary.policies.pop();
        summary.models[1].exact = true;
        assert_eq!(summary.verdict(), "2 exact policies: 1 wrong in 1 case; 1 result must agree and do not");
        assert_eq!(summary.broken(), ["Published in C8", "Bound in C8: cycles differ by 50.0 %"]);
    }
}
