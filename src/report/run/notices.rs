//! Warnings before the numbers: a run was stopped, sampled too thinly, or has little to tell.

use super::machine_run::MachineRun;
use super::summary::Summary;
use crate::report::format::percent;
use crate::stats::Accuracy;

/// Half width, as a share, above which an interval makes a figure of little use.
const WIDE: f64 = 0.1;

/// The warnings of a run, the gravest first.
pub(crate) fn notices(summary: &Summary) -> Vec<String> {
    let mut all = Vec::new();
    if let Some(done) = summary.provenance.get("stopped early") {
        all.push(format!("The run was stopped early: {done} are done, and all figures are of these."));
    }
    for (machine, found) in summary.machines.iter() {
        all.extend(found.policies.iter().filter_map(|(policy, run)| thin(machine, policy, run)));
    }
    let culls = |name: &str| summary.baseline.as_deref() != Some(name);
    let culling = summary.policies.iter().filter(|&(name, _)| culls(name)).count();
    if summary.policies.iter().all(|(_, policy)| policy.counts.shadow_rays == 0) {
        all.push("No shadow ray was asked for: the scene has no light, or the camera sees nothing.".into());
    } else if culling == 0 {
        all.push("No policy culls: `policies` has `Off` alone, and there is nothing to compare.".into());
    } else if summary.frames.len() == 1 {
        all.push(
            "One frame was traced: a policy that learns from earlier frames has learned nothing. Trace more.".into(),
        );
    }
    if summary.machines.is_empty() {
        all.push(
            "No machine replayed the frames: there are no times, bytes or energies. Name one in `machines`.".into(),
        );
    } else if culling > 0 && summary.machines.iter().all(|(_, found)| found.warmup.is_empty()) {
        all.push(
            "Machines measured from a cold start on: caches and mode words were empty. `warmup` changes that.".into(),
        );
    }
    all
}

/// The warning that a sample is too thin, or that its error is not known.
fn thin(machine: &str, policy: &str, run: &MachineRun) -> Option<String> {
    let whose = format!("`{machine}` under `{policy}`");
    match run.stats.accuracy {
        Accuracy::Unknown => Some(format!("{whose}: how far off the figures are is not known.")),
        _ => run
            .stats
            .accuracy
            .widest()
            .filter(|&widest| widest > WIDE)
            .map(|widest| format!("{whose} was sampled too thinly: its figures may be {} off.", percent(widest))),
    }
}

#[cfg(test)]
mod tests {
    use super::super::tests::sample::sample;
    use super::*;
    use crate::named::Named;

    #[test]
    fn what_makes_a_run_useless_is_told() {
        let run = sample(&[0, 16]).summary;
        let told = |summary: &Summary, what: &str| notices(summary).iter().any(|notice| notice.contains(what));
        assert!(!told(&run, "stopped") && !told(&run, "No ") && !told(&run, "thinly"), "{:?}", notices(&run));

        let mut stopped = run.clone();
        stopped.provenance.insert("stopped early", "2 of 9 frames".to_owned());
        assert!(notices(&stopped)[0].contains("2 of 9 frames are done"));
        assert!(told(&Summary { machines: Named::default(), ..run.clone() }, "No machine"));
        assert!(told(&sample(&[0]).summary, "One frame"));
        let mut thin = run.clone();
        for machine in thin.machines.values_mut() {
            for run in machine.policies.values_mut() {
                run.stats.accuracy = Accuracy::Estimated { cycles: 0.3, l2_bytes: 0.1, dram_bytes: 0.1, rate: 0.1 };
            }
        }
        assert!(told(&thin, "its figures may be 30.0 % off"));
        let mut dark = run.clone();
        dark.policies.values_mut().for_each(|policy| policy.counts.totals.shadow_rays = 0);
        assert!(told(&dark, "No shadow ray"));
        let off = run.policies.get("off").unwrap().clone();
        assert!(told(&Summary { policies: [("off", off)].into_iter().collect(), ..run }, "No policy culls"));
    }
}
