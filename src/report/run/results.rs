//! The rows of a run's `results.csv`.

use super::summary::{MachineRun, MachineSummary, PolicySummary, Psnr, Summary};
use crate::report::error::ReportError;
use crate::report::results::{Amount, Family, Results, Row, Scope, Subject, Take, Walk};
use crate::stats::Accuracy;

/// The declarations of a run's numbers.
struct Families {
    policy: Family,
    light: Family,
    machine: Family,
    frame: Family,
    split: Family,
}

impl Families {
    fn new() -> Self {
        Self {
            policy: Family::new("policies.*.", ""),
            light: Family::new("policies.*.lights.*.", "lights"),
            machine: Family::new("machines.*.policies.*.", ""),
            frame: Family::new("machines.*.policies.*.frames.*.", ""),
            split: Family::new("machines.*.split.*.", "split"),
        }
    }
}

/// Of a number that is a count or follows from counts.
fn exact(_: &str) -> Option<f64> {
    Some(0.0)
}

impl Results for Summary {
    fn run(&self) -> &str {
        &self.experiment
    }

    fn scene(&self) -> &str {
        &self.scene.name
    }

    fn rows(&self, take: &mut Take<'_>) -> Result<(), ReportError> {
        let families = Families::new();
        self.policies.iter().try_for_each(|(name, policy)| families.of_policy(name, policy, take))?;
        self.machines.iter().try_for_each(|(name, machine)| families.of_machine(name, machine, take))
    }
}

impl Families {
    /// What the tracer counted.
    fn of_policy(&self, name: &str, policy: &PolicySummary, take: &mut Take<'_>) -> Result<(), ReportError> {
        let of = Subject { scope: Scope::Total, frame: None, policy: name, machine: None, varied: &[] };
        let walk = Walk { family: &self.policy, of, part: None, half_width: &exact };
        walk.rows(policy, take)?;
        for light in &policy.lights {
            let part = format!("light_{}", light.light);
            Walk { family: &self.light, part: Some(&part), ..walk }.rows(light, take)?;
        }
        for frame in &policy.frames {
            let of = Subject { scope: Scope::Frame, frame: Some(frame.frame), ..of };
            Walk { of, ..walk }.rows(frame, take)?;
            if let (Some(Psnr::Identical), Some(metric)) = (frame.psnr, self.policy.metric("psnr.decibel")) {
                let value = Amount::Real(f64::INFINITY);
                take(&Row { of, part: None, class: None, metric, value, half_width: Some(0.0) })?;
            }
        }
        Ok(())
    }

    /// What a machine measured.
    fn of_machine(&self, name: &str, machine: &MachineSummary, take: &mut Take<'_>) -> Result<(), ReportError> {
        let named = Some((name, machine.fidelity.as_str()));
        for (policy, run) in machine.policies.iter() {
            let of = Subject { scope: Scope::Total, frame: None, policy, machine: named, varied: &[] };
            let half_width = |path: &str| half_width(run, path);
            let walk = Walk { family: &self.machine, of, part: None, half_width: &half_width };
            walk.rows(run, take)?;
            for frame in &run.stats.frames {
                let scope = if frame.warmup { Scope::Warmup } else { Scope::Frame };
                let of = Subject { scope, frame: Some(frame.frame), ..of };
                // Only levels that replay everything know frames apart.
                let half_width = |_: &str| (run.stats.accuracy == Accuracy::Exact).then_some(0.0);
                Walk { family: &self.frame, of, part: None, half_width: &half_width }.rows(frame, take)?;
            }
            if let Some(split) = machine.split.get(policy) {
                let half_width = |_: &str| (run.stats.accuracy == Accuracy::Exact).then_some(0.0);
                Walk { family: &self.split, half_width: &half_width, ..walk }.rows(split, take)?;
            }
        }
        Ok(())
    }
}

/// Half the width of the 95 % interval of a run's number.
fn half_width(run: &MachineRun, path: &str) -> Option<f64> {
    match run.stats.accuracy {
        Accuracy::Exact => Some(0.0),
        _ => run.stats.half_widths.get(path).copied(),
    }
}
