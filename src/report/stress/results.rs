//! The rows of a stress report's `results.csv`: wrong decisions of each policy in each case, which is the scene.

use super::data::{FrameWrong, StressSummary};
use crate::report::error::ReportError;
use crate::report::results::{Amount, Family, Results, Row, Scope, Subject, Take};

impl Results for StressSummary {
    fn rows(&self, take: &mut Take<'_>) -> Result<(), ReportError> {
        let family = Family::new("policies.*.", "");
        for case in &self.cases {
            for (policy, frames) in self.policies.iter().zip(&case.policies) {
                let of = Subject {
                    run: "stress",
                    scene: &case.name,
                    scope: Scope::Total,
                    frame: None,
                    policy: &policy.name,
                    machine: None,
                    varied: &[],
                };
                rows(&family, of, frames, take)?;
                for (number, frame) in (0..).zip(frames) {
                    let of = Subject { scope: Scope::Frame, frame: Some(number), ..of };
                    rows(&family, of, std::slice::from_ref(frame), take)?;
                }
            }
        }
        Ok(())
    }
}

/// The sums of some frames.
fn rows(family: &Family, of: Subject<'_>, frames: &[FrameWrong], take: &mut Take<'_>) -> Result<(), ReportError> {
    let sum = |count: fn(&FrameWrong) -> u64| frames.iter().map(count).sum::<u64>();
    let counts = [
        ("shadow_rays", sum(|frame| frame.shadow_rays)),
        ("false_dark", sum(|frame| frame.false_dark)),
        ("false_lit", sum(|frame| frame.false_lit)),
    ];
    for (path, count) in counts {
        let Some(metric) = family.metric(path) else { continue };
        let value = Amount::Whole(count.into());
        take(&Row { of, part: None, class: None, metric, value, half_width: Some(0.0) })?;
    }
    Ok(())
}
