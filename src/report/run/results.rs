//! The rows of a run's `results.csv`.

use super::machine_run::MachineRun;
use super::summary::{MachineSummary, PolicySummary, Psnr, Summary};
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

/// The half width of counts, and of numbers that follow from counts.
fn exact(_: &str) -> Option<f64> {
    Some(0.0)
}

impl Results for Summary {
    fn rows(&self, take: &mut Take<'_>) -> Result<(), ReportError> {
        let families = Families::new();
        let run = Subject {
            run: &self.experiment,
            scene: &self.scene.name,
            scope: Scope::Total,
            frame: None,
            policy: "",
            machine: None,
            varied: &[],
        };
        for (name, policy) in self.policies.iter() {
            families.of_policy(Subject { policy: name, ..run }, policy, take)?;
        }
        for (name, machine) in self.machines.iter() {
            families.of_machine(Subject { machine: Some((name, &machine.fidelity)), ..run }, machine, take)?;
        }
        Ok(())
    }
}

/// Hands over the rows of a machine.
///
/// # Errors
/// See [`Results::rows`].
pub(in crate::report) fn machine_rows(
    of: Subject<'_>,
    machine: &MachineSummary,
    take: &mut Take<'_>,
) -> Result<(), ReportError> {
    Families::new().of_machine(of, machine, take)
}

impl Families {
    /// Hands over the rows of a policy, as counted by the tracer.
    fn of_policy(&self, of: Subject<'_>, policy: &PolicySummary, take: &mut Take<'_>) -> Result<(), ReportError> {
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
                take(&Row { of, part: None, class: None, metric, value: Some(value), half_width: Some(0.0) })?;
            }
        }
        Ok(())
    }

    /// Hands over the rows of a machine.
    fn of_machine(&self, of: Subject<'_>, machine: &MachineSummary, take: &mut Take<'_>) -> Result<(), ReportError> {
        for (policy, run) in machine.policies.iter() {
            let of = Subject { policy, ..of };
            let half_width = |path: &str| half_width(run, path);
            let walk = Walk { family: &self.machine, of, part: None, half_width: &half_width };
            walk.rows(run, take)?;
            for frame in &run.stats.frames {
                let scope = if frame.warmup { Scope::Warmup } else { Scope::Frame };
                let of = Subject { scope, frame: Some(frame.frame), ..of };
                // Only levels that replay everything have exact figures of single frames.
                let half_width = |_: &str| (run.stats.accuracy == Accuracy::Exact).then_some(0.0);
                Walk { family: &self.frame, of, part: None, half_width: &half_width }.rows(frame, take)?;
            }
            if let Some(split) = machine.split.get(policy) {
                split.rows(run.stats.accuracy == Accuracy::Exact, Walk { family: &self.split, ..walk }, take)?;
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
