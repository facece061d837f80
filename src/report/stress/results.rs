//! The rows of a stress report's `results.csv`. A case stands in the column of scenes. The effect of an answer to an
//! open question has that answer as its part.

use super::data::{CaseSummary, Effect, FrameWrong, ModelVerdict, StressSummary};
use crate::report::error::ReportError;
use crate::report::results::{Amount, Family, Results, Row, Scope, Subject, Take};

/// The machine that replays the cases.
const MACHINE: &str = "default";

/// The subject of all rows.
const OF: Subject<'_> =
    Subject { run: "stress", scene: "", scope: Scope::Total, frame: None, policy: "", machine: None, varied: &[] };

impl Results for StressSummary {
    fn rows(&self, take: &mut Take<'_>) -> Result<(), ReportError> {
        let [family, models] = [Family::new("policies.*.", ""), Family::new("cases.*.models.*.", "model")];
        for case in &self.cases {
            for (policy, frames) in self.policies.iter().zip(&case.policies) {
                let of = Subject { scene: &case.name, policy: &policy.name, ..OF };
                rows(&family, of, frames, take)?;
                for (number, frame) in (0..).zip(frames) {
                    let of = Subject { scope: Scope::Frame, frame: Some(number), ..of };
                    rows(&family, of, std::slice::from_ref(frame), take)?;
                }
            }
            self.of_models(&models, case, take)?;
        }
        let effects = Family::new("effects.*.", "effect");
        self.effects.iter().try_for_each(|effect| of_effect(&effects, effect, take))
    }
}

impl StressSummary {
    /// The error of each timing model in a case. A failed model has a row without a number; the page tells the
    /// reason.
    fn of_models(&self, family: &Family, case: &CaseSummary, take: &mut Take<'_>) -> Result<(), ReportError> {
        let Some(metric) = family.metric("differs") else { return Ok(()) };
        for (model, verdict) in self.models.iter().zip(&case.models) {
            let share = match verdict {
                ModelVerdict::Agrees => Some(0.0),
                ModelVerdict::Differs(share) => Some(*share),
                ModelVerdict::Failed(_) => None,
            };
            let of = Subject { scene: &case.name, machine: Some((MACHINE, &model.name)), ..OF };
            let (value, half_width) = (share.map(Amount::Real), share.map(|_| 0.0));
            take(&Row { of, part: None, class: None, metric, value, half_width })?;
        }
        Ok(())
    }
}

/// The effect of an answer.
fn of_effect(family: &Family, effect: &Effect, take: &mut Take<'_>) -> Result<(), ReportError> {
    let Effect { option, saving, wrong_per_million } = effect;
    for (path, shift) in [("saving.mean", saving), ("wrong_per_million.mean", wrong_per_million)] {
        let Some(metric) = family.metric(path) else { continue };
        let of = Subject { policy: "Published", ..OF };
        let (part, value) = (Some(option.as_str()), Some(Amount::Real(shift.mean)));
        take(&Row { of, part, class: None, metric, value, half_width: Some(shift.error) })?;
    }
    Ok(())
}

/// Sums over frames.
fn rows(family: &Family, of: Subject<'_>, frames: &[FrameWrong], take: &mut Take<'_>) -> Result<(), ReportError> {
    let sum = |count: fn(&FrameWrong) -> u64| frames.iter().map(count).sum::<u64>();
    let counts = [
        ("shadow_rays", sum(|frame| frame.shadow_rays)),
        ("false_dark", sum(|frame| frame.false_dark)),
        ("false_lit", sum(|frame| frame.false_lit)),
    ];
    for (path, count) in counts {
        let Some(metric) = family.metric(path) else { continue };
        let value = Some(Amount::Whole(count.into()));
        take(&Row { of, part: None, class: None, metric, value, half_width: Some(0.0) })?;
    }
    Ok(())
}
