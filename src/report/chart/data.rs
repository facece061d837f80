//! The chart of saving against error over several runs: every policy of every scene.

use serde::{Deserialize, Serialize};

use crate::report::format::{exact, or_absent, percent, short};
use crate::report::grid::Grid;
use crate::report::run::{PolicySummary, Summary};

/// The version of the names in `summary.json`.
const SCHEMA: u32 = 1;

/// The chart's data; `summary.json` holds it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct ChartSummary {
    /// The version of these names.
    pub schema: u32,
    /// The experiments, in the order in which they were given.
    pub experiments: Vec<String>,
    /// The policies, in the order in which they first occur.
    pub policies: Vec<String>,
    /// One point per experiment and policy.
    pub points: Vec<Point>,
}

/// What a policy saved in an experiment, and its wrong decisions.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Point {
    /// The experiment's name.
    pub experiment: String,
    /// The scene.
    pub scene: String,
    /// Number of frames that the means cover.
    pub frames: usize,
    /// The policy's name.
    pub policy: String,
    /// Share of the shadow rays' node visits that the policy saves: mean over the frames.
    pub traversal_saved: Option<f64>,
    /// Share of the shadow rays' triangle tests that the policy saves: mean over the frames.
    pub intersection_saved: Option<f64>,
    /// Share of all accesses for shadows that the policy saves; see [`PolicySummary::accesses_saved`].
    pub accesses_saved: Option<f64>,
    /// Wrong shadow decisions.
    pub wrong: u64,
    /// Wrong shadow decisions per million shadow rays.
    pub wrong_per_million: f64,
}

impl ChartSummary {
    /// A point for every culling policy of every run in which wrong decisions were looked for.
    pub(crate) fn new(runs: &[Summary]) -> Self {
        let experiments = names(runs);
        let points = runs.iter().zip(&experiments).flat_map(|(run, name)| points(run, name));
        let points: Vec<Point> = points.collect();
        let mut policies: Vec<String> = Vec::new();
        for point in &points {
            if !policies.contains(&point.policy) {
                policies.push(point.policy.clone());
            }
        }
        Self { schema: SCHEMA, experiments, policies, points }
    }

    /// The data as a table.
    pub(crate) fn grid(&self) -> Grid {
        const HEAD: [&str; 8] =
            ["run", "policy", "frames", "nodes saved", "triangles saved", "accesses saved", "wrong", "wrong a million"];
        let row = |point: &Point| {
            vec![
                point.experiment.clone(),
                point.policy.clone(),
                point.frames.to_string(),
                or_absent(point.traversal_saved, percent),
                or_absent(point.intersection_saved, percent),
                or_absent(point.accesses_saved, percent),
                exact(point.wrong),
                short(point.wrong_per_million),
            ]
        };
        Grid { head: HEAD.map(Into::into).to_vec(), names: 2, rows: self.points.iter().map(row).collect() }
    }
}

/// The runs' names; a repeated name gets a number.
fn names(runs: &[Summary]) -> Vec<String> {
    let name = |(at, run): (usize, &Summary)| {
        let before = runs[..at].iter().filter(|other| other.experiment == run.experiment).count();
        if before == 0 { run.experiment.clone() } else { format!("{} ({})", run.experiment, before + 1) }
    };
    runs.iter().enumerate().map(name).collect()
}

fn points<'a>(run: &'a Summary, experiment: &'a str) -> impl Iterator<Item = Point> + use<'a> {
    let baseline = run.baseline.as_deref();
    let off = baseline.and_then(|name| run.policies.get(name));
    let culling = run.policies.iter().filter(move |&(name, _)| baseline != Some(name));
    culling.filter_map(move |(name, policy)| point(run, experiment, name, policy, off?))
}

fn point(run: &Summary, experiment: &str, name: &str, policy: &PolicySummary, off: &PolicySummary) -> Option<Point> {
    let rays = policy.counts.shadow_rays;
    let wrong = policy.counts.wrong().filter(|_| rays > 0)?;
    Some(Point {
        experiment: experiment.to_owned(),
        scene: run.scene.name.clone(),
        frames: policy.frames.len(),
        policy: name.to_owned(),
        traversal_saved: policy.traversal_saved.mean,
        intersection_saved: policy.intersection_saved.mean,
        accesses_saved: policy.accesses_saved(off),
        wrong,
        wrong_per_million: wrong as f64 * 1e6 / rays as f64,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::run::tests::sample;

    #[test]
    fn every_policy_but_the_baseline_has_a_point_a_run() {
        let runs = [sample::sample(&[0, 2]).summary, sample::sample(&[0, 2]).summary];
        let chart = ChartSummary::new(&runs);
        assert_eq!(chart.policies, ["published", "last_occluder"]);
        assert_eq!(chart.points.len(), 4);
        let first = &chart.experiments[0];
        assert_eq!(chart.experiments[1], format!("{first} (2)"), "two runs of a name are told apart");
        assert_eq!(chart.points[2].experiment, chart.experiments[1]);
        let (point, policy) = (&chart.points[0], &runs[0].policies.get("published").unwrap());
        assert_eq!(point.traversal_saved, policy.traversal_saved.mean);
        assert_eq!(point.wrong_per_million, point.wrong as f64 * 1e6 / policy.counts.shadow_rays as f64);
        let off = runs[0].policies.get("off").unwrap();
        assert_eq!(off.accesses_saved(off), Some(0.0));
    }
}
