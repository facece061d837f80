//! What every number of a report means, for `umbrasim explain`: counters from their declarations, others from a table.

use serde_json::Value;

use super::grid::{Grid, drawn};
use crate::counters::Counter;
use crate::stats::{CacheCounts, DramCounts, L1Counts, LatencyCounts, QueueCounts};
use crate::stream::Totals;

/// A number of `summary.json`, or a column of `frames.csv`.
#[derive(Clone, Debug)]
pub struct Statistic {
    /// Its path in `summary.json`; `*` stands for a name of the experiment's, a part of the machine, or a class of
    /// traffic. What is declared of a policy is there of all its frames together and of each (`policies.*.frames.*`),
    /// and what is declared of what a policy saved and paid on a machine (`machines.*.split.*`) is there of each point
    /// of a sweep (`points.*`).
    pub name: String,
    /// Its unit.
    pub unit: &'static str,
    /// What it is.
    pub about: &'static str,
}

/// The numbers that are no counters: name, unit, meaning.
const OTHERS: &[(&str, &str, &str)] = &[
    ("schema", "version", "version of the names in this file and of their meanings"),
    ("scene.triangles_static", "triangles", "triangles that stay"),
    ("scene.triangles_dynamic", "triangles", "triangles that can move"),
    ("scene.lights", "lights", "lights"),
    ("frames.*", "frame number", "the frames that were traced, in order"),
    ("resolution.width", "pixels", "width of the pictures"),
    ("resolution.height", "pixels", "height of the pictures"),
    ("pictures.*.frame", "frame number", "the frame that a picture shows"),
    ("pictures.*.kind.*.light", "number", "the light whose decisions a picture shows"),
    ("wall_seconds.*", "s", "wall time of a stage of the run; differs from run to run"),
    (
        "simulated_rays_per_wall_second.*",
        "rays/s",
        "the simulator's own speed: rays traced or replayed a second of wall time; differs from run to run",
    ),
    ("policies.*.frame", "frame number", "the frame that these counts are of"),
    ("policies.*.occlusion_tests", "tests", "primary rays tested against a neighbour pixel's primitive"),
    ("policies.*.occlusion_tests_per_pixel", "tests/pixel", "occlusion_tests / primary_rays"),
    ("policies.*.false_dark", "rays", "shadow rays decided dark that, traced without culling, find the light"),
    ("policies.*.false_lit", "rays", "shadow rays decided lit that, traced without culling, are stopped"),
    ("policies.*.compared_rays", "rays", "shadow rays of primary hits that the reference renderer traced too"),
    (
        "policies.*.numeric_differences",
        "rays",
        "those of compared_rays on which tracer (f32, nothing culled) and reference renderer (f64) differ: rounding, no decision",
    ),
    (
        "policies.*.traversal_saved",
        "share",
        "of a frame: 1 - (shadow_node_visits + policy_node_visits) / the baseline's shadow_node_visits",
    ),
    ("policies.*.traversal_saved.mean", "share", "mean of traversal_saved over the frames"),
    ("policies.*.traversal_saved.max", "share", "the most of any frame"),
    ("policies.*.traversal_saved.max_frame", "frame number", "the first frame that saved that much"),
    ("policies.*.traversal_saved.total", "share", "the same over the rays of all frames together"),
    (
        "policies.*.intersection_saved",
        "share",
        "of a frame: 1 - (shadow_triangle_tests + policy_triangle_tests - occlusion_tests) / the baseline's shadow_triangle_tests",
    ),
    ("policies.*.intersection_saved.mean", "share", "mean of intersection_saved over the frames"),
    ("policies.*.intersection_saved.max", "share", "the most of any frame"),
    ("policies.*.intersection_saved.max_frame", "frame number", "the first frame that saved that much"),
    ("policies.*.intersection_saved.total", "share", "the same over the rays of all frames together"),
    ("policies.*.psnr.decibel", "dB", "peak signal-to-noise ratio of the picture against the reference renderer's"),
    ("policies.*.psnr_db", "dB", "psnr as a column of frames.csv; `inf` where no pixel differs"),
    ("policies.*.lights.*.light", "number", "a light"),
    ("policies.*.lights.*.false_dark", "rays", "false_dark towards this light"),
    ("policies.*.lights.*.false_lit", "rays", "false_lit towards this light"),
    ("machines.*.frames.*", "frame number", "the frames that the machine measured, in order"),
    ("machines.*.warmup.*", "frame number", "the frames that it replayed before them: in no sum, mean or rate"),
    ("machines.*.policies.*.milliseconds_per_frame", "ms", "simulated time of a measured frame, the mean"),
    ("machines.*.policies.*.frames_per_second", "frames/s", "measured frames a second of simulated time"),
    (
        "machines.*.policies.*.rays_answered",
        "rays",
        "rays that the measured frames ask for: traced ones, and those whose answers are known",
    ),
    ("machines.*.policies.*.rays_answered_per_second", "rays/s", "rays_answered a second of simulated time"),
    ("machines.*.policies.*.dram_gigabytes_per_second", "GB/s", "bytes that the DRAM moved a second of simulated time"),
    ("machines.*.policies.*.dram_bytes_per_frame", "B", "bytes that the DRAM moved a measured frame, the mean"),
    ("machines.*.policies.*.joules_per_frame", "J", "energy.joules a measured frame"),
    ("machines.*.policies.*.joules_per_ray", "J", "energy.joules / rays_answered"),
    ("machines.*.policies.*.energy.joules", "J", "energy with typical constants: the sum of energy.by"),
    ("machines.*.policies.*.energy.low", "J", "the same with every constant at the low end of its range"),
    ("machines.*.policies.*.energy.high", "J", "the same with every constant at the high end of its range"),
    (
        "machines.*.policies.*.energy.by.*",
        "J",
        "energy of a part: operations, accesses, commands or time x its constant",
    ),
    ("machines.*.policies.*.energy.classes.*", "J", "energy of cache accesses and DRAM commands of a class of traffic"),
    ("machines.*.policies.*.frames.*.frame", "frame number", "the frame that these figures are of"),
    (
        "machines.*.policies.*.frames.*.warmup",
        "0 or 1",
        "a column of frames.csv: whether the frame warms caches and words up",
    ),
    (
        "machines.*.policies.*.frames.*.cycles",
        "cycles",
        "from the end of the frame replayed before to this frame's end",
    ),
    ("machines.*.policies.*.frames.*.rays", "rays", "rays of the frame that were replayed, skipped ones not counted"),
    ("machines.*.policies.*.frames.*.answered", "rays", "rays that the frame asks for, skipped ones among them"),
    ("machines.*.policies.*.frames.*.bytes.*", "B", "bytes moved between a level and the one above it in the frame"),
    ("machines.*.policies.*.frames.*.units.*.*", "cycles", "cycles of a kind of units by cause in the frame"),
    ("machines.*.policies.*.frames.*.energy.joules", "J", "energy of the frame with typical constants"),
    ("machines.*.policies.*.frames.*.energy.low", "J", "the same with every constant at the low end of its range"),
    ("machines.*.policies.*.frames.*.energy.high", "J", "the same with every constant at the high end of its range"),
    ("machines.*.policies.*.frames.*.energy.by.*", "J", "energy of a part in the frame"),
    ("machines.*.policies.*.frames.*.energy.classes.*", "J", "energy of a class of traffic in the frame"),
    ("machines.*.policies.*.cycles", "cycles", "from the first ray to the last request served, of the machine's clock"),
    ("machines.*.policies.*.clock_mhz", "MHz", "the machine's clock"),
    ("machines.*.policies.*.rays", "rays", "rays replayed, skipped ones not counted"),
    ("machines.*.policies.*.rays_per_second", "rays/s", "rays / cycles x clock: simulated time, not wall time"),
    (
        "machines.*.policies.*.bytes.*.*",
        "B",
        "bytes moved between a level and the one above it (towards the units), a class of traffic",
    ),
    (
        "machines.*.policies.*.hit_rate.*.*",
        "share",
        "hits / accesses of a kind of cache and a class; a half miss is no hit",
    ),
    (
        "machines.*.policies.*.units.*.busy",
        "cycles",
        "an operation occupied the entry of the pipeline; summed over the units of the kind",
    ),
    (
        "machines.*.policies.*.units.*.pipeline",
        "cycles",
        "no operation began: all rays of the unit are inside its pipeline",
    ),
    ("machines.*.policies.*.units.*.memory", "cycles", "no operation began: a ray waits for data of the cache"),
    (
        "machines.*.policies.*.units.*.blocked",
        "cycles",
        "no operation began: a neighbour cannot take what is ready for it",
    ),
    (
        "machines.*.policies.*.units.*.intake",
        "cycles",
        "no operation began: the unit took as many rays as its width allows, and others wait in front of it",
    ),
    (
        "machines.*.policies.*.units.*.starved",
        "cycles",
        "no operation began: no ray is in the unit, and none waits in front of it",
    ),
    (
        "machines.*.policies.*.operations.*",
        "operations",
        "operations that units of a kind began; several can begin in a cycle of a wide one",
    ),
    ("machines.*.policies.*.unit_counts.*", "units", "instances of a kind: its causes sum to cycles times this"),
    ("machines.*.policies.*.utilization.*", "share", "busy / (cycles x unit_counts) of a kind of unit"),
    ("machines.*.policies.*.dram_row_hit_rate", "share", "row_hits / (row_hits + row_misses + row_conflicts)"),
    (
        "machines.*.policies.*.dram_peak_bytes_per_cycle",
        "B/cycle",
        "what all channels can move at their peak; absent if nothing limits it",
    ),
    (
        "machines.*.policies.*.accuracy.estimated.cycles",
        "share",
        "half the width of the 95 % interval of the cycles, over the estimate",
    ),
    (
        "machines.*.policies.*.accuracy.estimated.dram_bytes",
        "share",
        "half the width of the 95 % interval of the DRAM's bytes, over the estimate",
    ),
    (
        "machines.*.policies.*.accuracy.estimated.l2_bytes",
        "share",
        "half the width of the 95 % interval of the bytes between L1s and L2, over the estimate",
    ),
    ("machines.*.policies.*.accuracy.estimated.rate", "share", "windows that were measured, of all"),
    (
        "machines.*.policies.*.half_widths.*",
        "as the figure",
        "half the width of the 95 % interval of the figure with this path",
    ),
    ("machines.*.policies.*.needs.target", "share", "the error that was asked for"),
    ("machines.*.policies.*.needs.pilot_share", "share", "pixels of the pilot, of all; as many were held back"),
    ("machines.*.policies.*.needs.parts.*.cycles", "share", "change of the pilot's cycles without the part"),
    (
        "machines.*.policies.*.needs.parts.*.l2_bytes",
        "share",
        "change of the pilot's bytes between L1s and L2 without the part",
    ),
    ("machines.*.policies.*.needs.parts.*.dram_bytes", "share", "change of the pilot's DRAM bytes without the part"),
    (
        "machines.*.policies.*.needs.models.*.error",
        "share",
        "largest error of the model's cycles and bytes on the pilot; of a sample, half its widest interval",
    ),
    ("machines.*.policies.*.needs.models.*.held_back", "share", "the same on what was held back"),
    ("machines.*.policies.*.bounds.cycles.least", "cycles", "no machine of the spec can take less on this stream"),
    ("machines.*.policies.*.bounds.cycles.most", "cycles", "everything missed, one thing after another"),
    ("machines.*.policies.*.bounds.l2_bytes.least", "B", "every line once from the L2 for each kind of unit"),
    ("machines.*.policies.*.bounds.l2_bytes.most", "B", "every access misses, every write is written back"),
    ("machines.*.policies.*.bounds.dram_bytes.least", "B", "every line once from the DRAM"),
    (
        "machines.*.policies.*.bounds.dram_bytes.most",
        "B",
        "every access misses, every write is fetched and written back",
    ),
    (
        "machines.*.policies.*.oracle.cycles",
        "cycles",
        "the least that is left if the answers of all shadow rays are known for nothing",
    ),
    (
        "machines.*.policies.*.oracle.dram_bytes",
        "B",
        "the least that is left if the answers of all shadow rays are known for nothing",
    ),
    (
        "machines.*.split.*.cycles.*",
        "cycles",
        "without culling (0), with the policy and words that cost nothing (1), as it is (2)",
    ),
    ("machines.*.split.*.dram.*", "B", "DRAM bytes of the same three replays"),
    (
        "machines.*.split.*.saved",
        "B",
        "DRAM bytes that culling saves if words cost nothing, its own occlusion tests counted in",
    ),
    ("machines.*.split.*.words", "B", "DRAM bytes of mode words, counters and occluder ids"),
    (
        "machines.*.split.*.interference",
        "B",
        "DRAM bytes of other classes that words drove out of caches; words + interference - saved is the change",
    ),
    (
        "machines.*.split.*.extra_misses",
        "accesses",
        "misses of other classes, in all caches, that words that cost nothing do not cause",
    ),
    (
        "machines.*.split.*.word_hit_rate",
        "share",
        "hits / accesses of words, counters and ids in the first cache that they meet",
    ),
    ("machines.*.split.*.shadow_rays", "rays", "shadow rays that there are without culling, in the frames replayed"),
    ("machines.*.split.*.culled", "share", "those of them that were skipped or traced among dynamic triangles only"),
    ("machines.*.split.*.bytes_per_ray", "B/ray", "DRAM bytes a ray of the replay without culling"),
    (
        "machines.*.split.*.break_even",
        "share",
        "shadow rays that must be culled to save what words cost, at bytes_per_ray: (words + interference) / (bytes_per_ray x shadow_rays)",
    ),
    ("points.*.bytes.*", "B", "of a sweep's point: DRAM bytes of a class of traffic, as it is"),
    ("points.*.hit_rate.*.*", "share", "of a sweep's point: hits / accesses of a kind of cache and a class, as it is"),
    (
        "designs.*.wrong_pixels",
        "pixels",
        "of a space's design: pixels whose shadows culling changed, in the measured frames",
    ),
    ("designs.*.cycles", "cycles", "of a space's design: cycles, measured if it was replayed, predicted otherwise"),
    ("designs.*.dram_bytes", "B", "of a space's design: bytes that the DRAM moved, measured or predicted"),
    ("designs.*.joules", "J", "of a space's design: energy with typical constants, measured or predicted"),
    ("designs.*.half_widths.*", "as the figure", "half the width of the 95 % interval of a figure that is predicted"),
    (
        "designs.*.foreseen.*.*",
        "as the figure",
        "what was predicted before the replay (0), and the 95 % interval (1, 2)",
    ),
    ("size.combinations", "combinations", "of a space: combinations of values for each machine of the experiment"),
    ("size.machines", "machines", "machines that were drawn of these"),
    ("size.left_out", "combinations", "combinations that were drawn and are no machines"),
    ("size.replays", "replays", "replays made or kept"),
    ("size.budget", "replays", "replays that the config allows"),
    ("size.passes", "passes", "passes over streams, for what is known of all designs"),
    ("size.unsure", "designs", "designs that may be on the front and were not replayed"),
    ("policies.*.pixels", "pixels", "of a space: pixels of the measured frames"),
    ("policies.*.wrong_pixels", "pixels", "those of them whose shadows the policy changed"),
    ("sensitivities.*.least.*", "share", "change of the mean of a figure with the value that has the least of it"),
    ("sensitivities.*.most.*", "share", "change of the mean of a figure with the value that has the most of it"),
    ("sensitivities.*.share", "share", "of the variance of the figure's logarithm: what the field alone explains"),
    (
        "accuracy.*.*.count",
        "designs",
        "designs that were predicted (foreseen), or left out of what predicted them, and replayed",
    ),
    ("accuracy.*.*.median", "share", "half of the errors are below this"),
    ("accuracy.*.*.ninth", "share", "nine of ten errors are below this"),
    ("accuracy.*.*.most", "share", "the largest error"),
    ("accuracy.*.*.within", "share", "predictions within 3 %"),
    ("accuracy.*.*.holds", "share", "predictions whose 95 % interval holds"),
    ("machines.*.policies.*.dram_utilization", "share", "bytes moved / (dram_peak_bytes_per_cycle x cycles)"),
];

/// The counters of a report by the path of their group: each is declared where it is counted.
const COUNTERS: &[(&str, &[Counter])] = &[
    ("policies.*", Totals::DECLARED),
    ("machines.*.policies.*.caches.*.*", CacheCounts::DECLARED),
    ("machines.*.policies.*.caches.*.*", L1Counts::DECLARED),
    ("machines.*.policies.*.queues.*", QueueCounts::DECLARED),
    ("machines.*.policies.*.latency.*", LatencyCounts::DECLARED),
    ("machines.*.policies.*.dram", DramCounts::DECLARED),
    ("machines.*.policies.*.frames.*.caches.*", CacheCounts::DECLARED),
    ("machines.*.policies.*.frames.*.dram", DramCounts::DECLARED),
];

/// All numbers of a report.
pub fn statistics() -> Vec<Statistic> {
    let others = OTHERS.iter().map(|&(name, unit, about)| Statistic { name: name.to_owned(), unit, about });
    let counters = COUNTERS.iter().flat_map(|&(path, counters)| counters.iter().map(move |counter| (path, counter)));
    let counters = counters.map(|(path, &Counter { name, unit, about })| Statistic {
        name: format!("{path}.{name}"),
        unit,
        about,
    });
    counters.chain(others).collect()
}

/// The numbers of a summary: each with its path.
fn numbers(value: &Value, path: &mut Vec<String>, found: &mut Vec<(Vec<String>, String)>) {
    let mut below = |name: String, value: &Value| {
        path.push(name);
        numbers(value, path, found);
        path.pop();
    };
    match value {
        Value::Number(number) => found.push((path.clone(), number.to_string())),
        Value::Array(values) => values.iter().enumerate().for_each(|(index, value)| below(index.to_string(), value)),
        Value::Object(fields) => fields.iter().for_each(|(name, value)| below(name.clone(), value)),
        Value::Null | Value::Bool(_) | Value::String(_) => {}
    }
}

impl Statistic {
    fn parts(&self) -> impl DoubleEndedIterator<Item = &str> {
        self.name.split('.')
    }

    /// Whether this is the declaration of the number at `path`.
    fn declares(&self, path: &[String]) -> bool {
        let (mut own, mut path) = (self.name.as_str(), path);
        if let (Some(of_split), [points, _, of_point @ ..]) = (own.strip_prefix("machines.*.split.*."), path)
            && points == "points"
        {
            (own, path) = (of_split, of_point);
        }
        let one_frame = path.len() > 4 && path[0] == "policies" && path[2] == "frames";
        let skipped = if one_frame { 2..4 } else { 0..0 };
        let mut path = path.iter().enumerate().filter(|(index, _)| !skipped.contains(index)).map(|(_, part)| part);
        own.split('.').all(|part| path.next().is_some_and(|found| part == "*" || part == found))
            && path.next().is_none()
    }

    /// Whether somebody who asks for `name`, a path or the end of one, means this.
    fn is_meant(&self, name: &str) -> bool {
        let asked: Vec<_> = name.split('.').collect();
        let own: Vec<_> = self.parts().collect();
        let Some(skipped) = own.len().checked_sub(asked.len()) else { return false };
        own[skipped] == asked[0] && own[skipped..].iter().zip(&asked).all(|(own, asked)| *own == "*" || own == asked)
    }
}

/// The numbers of a `summary.json` that are not declared once.
pub fn undeclared(summary: &Value) -> Vec<String> {
    let mut found = Vec::new();
    numbers(summary, &mut Vec::new(), &mut found);
    let statistics = statistics();
    let declarations = |path: &[String]| statistics.iter().filter(|statistic| statistic.declares(path)).count();
    found.into_iter().filter(|(path, _)| declarations(path) != 1).map(|(path, _)| path.join(".")).collect()
}

/// What the statistics mean that end with `name`, or all of them, with their values in `report` if there is one.
///
/// # Errors
/// Nothing is called so; the error says what else is there.
pub fn explain(name: Option<&str>, report: Option<&Value>) -> Result<String, String> {
    let meant = |statistic: &&Statistic| name.is_none_or(|name| statistic.is_meant(name));
    let statistics = statistics();
    let meant: Vec<_> = statistics.iter().filter(meant).collect();
    if meant.is_empty() {
        let name = name.unwrap_or_default();
        let names = statistics.iter().map(|statistic| statistic.name.as_str());
        let similar: Vec<_> = names.filter(|it| it.contains(name)).collect();
        let hint = if similar.is_empty() { String::new() } else { format!("; there are {}", similar.join(", ")) };
        return Err(format!("no statistic is called `{name}`{hint} (`umbrasim explain` lists all)"));
    }
    let heads = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect();
    let row = |it: &&Statistic| vec![it.name.clone(), it.unit.to_owned(), it.about.to_owned()];
    let about =
        Grid { head: heads(&["statistic", "unit", "what it is"]), names: 3, rows: meant.iter().map(row).collect() };
    let Some(report) = report else { return Ok(drawn(&about)) };
    let mut found = Vec::new();
    numbers(report, &mut Vec::new(), &mut found);
    let of_meant = found.into_iter().filter(|(path, _)| meant.iter().any(|statistic| statistic.declares(path)));
    let rows = of_meant.map(|(path, number)| vec![path.join("."), number]).collect();
    let values = Grid { head: heads(&["in the report", "value"]), names: 1, rows };
    Ok(format!("{}\n\n{}", drawn(&about), drawn(&values)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::run::frames_csv::frames_csv;

    #[test]
    fn every_number_of_a_report_is_declared_once_and_every_declaration_is_of_one() {
        let sample = concat!(env!("CARGO_MANIFEST_DIR"), "/reports/sample");
        let text = std::fs::read_to_string(format!("{sample}/summary.json")).unwrap();
        let summary = serde_json::from_str(&text).unwrap();
        assert_eq!(undeclared(&summary), Vec::<String>::new());
        let mut found = Vec::new();
        numbers(&summary, &mut Vec::new(), &mut found);
        // The written sample is of an exact rung; what estimates add is in the one made for tests.
        let estimated = crate::report::run::tests::sample::sample(&[0]).summary;
        let of_machines = frames_csv(&estimated).head;
        let estimated = serde_json::to_value(estimated).unwrap();
        assert_eq!(undeclared(&estimated), Vec::<String>::new());
        numbers(&estimated, &mut Vec::new(), &mut found);
        let sweep = serde_json::to_value(crate::report::run::tests::sample::sweep()).unwrap();
        assert_eq!(undeclared(&sweep), Vec::<String>::new());
        numbers(&sweep, &mut Vec::new(), &mut found);
        let space = serde_json::to_value(crate::report::run::tests::sample::space()).unwrap();
        assert_eq!(undeclared(&space), Vec::<String>::new());
        numbers(&space, &mut Vec::new(), &mut found);
        let csv = std::fs::read_to_string(format!("{sample}/frames.csv")).unwrap();
        let statistics = statistics();
        let columns: Vec<_> =
            csv.lines().next().unwrap().split(',').skip(1).map(|name| format!("policies.*.{name}")).collect();
        // A column of a machine is named as the number of the summary.
        let of_machine = |name: &str| {
            let (machine, path) = name.split_once('.').unwrap();
            let path = format!("machines.{machine}.policies.off.frames.0.{path}");
            path.split('.').map(str::to_owned).collect::<Vec<_>>()
        };
        for path in of_machines.iter().filter(|name| name.contains('.')).map(|name| of_machine(name)) {
            assert!(statistics.iter().any(|statistic| statistic.declares(&path)), "{path:?}");
            found.push((path, String::new()));
        }
        for column in columns.iter().filter(|name| name.matches('.').count() == 2) {
            assert!(statistics.iter().any(|statistic| statistic.name == *column), "{column}");
        }
        for statistic in &statistics {
            let is_there = found.iter().any(|(path, _)| statistic.declares(path)) || columns.contains(&statistic.name);
            assert!(is_there, "{} is declared, and no number is called so", statistic.name);
        }
    }

    #[test]
    fn a_name_means_what_ends_with_it() {
        let names = |asked: &str| {
            let meant = statistics().into_iter().filter(|statistic| statistic.is_meant(asked));
            meant.map(|statistic| statistic.name).collect::<Vec<_>>()
        };
        let row_hits = ["machines.*.policies.*.dram.row_hits", "machines.*.policies.*.frames.*.dram.row_hits"];
        assert_eq!(names("row_hits"), row_hits);
        assert_eq!(names("bytes.dram.mode_word"), ["machines.*.policies.*.bytes.*.*"]);
        assert_eq!(names("false_dark"), ["policies.*.false_dark", "policies.*.lights.*.false_dark"]);
        let error = explain(Some("row_hit"), None).unwrap_err();
        assert!(error.contains("`row_hit`; there are machines.*.policies.*.dram.row_hits"), "{error}");
    }
}
