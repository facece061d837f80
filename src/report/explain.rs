//! What every number of a report means: statistics are declared here once, and `umbrasim explain` tells of them.

use serde_json::Value;

use super::grid::{Grid, drawn};

/// A number of `summary.json`, or a column of `frames.csv`.
#[derive(Clone, Copy, Debug)]
pub struct Statistic {
    /// Its path in `summary.json`; `*` stands for a name of the experiment's, a part of the machine, or a class of traffic.
    /// What is declared of a policy is there of all its frames together and of each (`policies.*.frames.*`), and what is declared of
    /// what a policy saved and paid on a machine (`machines.*.split.*`) is there of each point of a sweep (`points.*`).
    pub name: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// What it is.
    pub about: &'static str,
}

const fn stat(name: &'static str, unit: &'static str, about: &'static str) -> Statistic {
    Statistic { name, unit, about }
}

/// All of them.
pub const STATISTICS: &[Statistic] = &[
    stat("schema", "version", "version of the names in this file and of their meanings"),
    stat("scene.triangles_static", "triangles", "triangles that stay"),
    stat("scene.triangles_dynamic", "triangles", "triangles that can move"),
    stat("scene.lights", "lights", "lights"),
    stat("frames.*", "frame number", "the frames that were traced, in order"),
    stat("resolution.width", "pixels", "width of the pictures"),
    stat("resolution.height", "pixels", "height of the pictures"),
    stat("pictures.*.frame", "frame number", "the frame that a picture shows"),
    stat("pictures.*.kind.*.light", "number", "the light whose decisions a picture shows"),
    stat("wall_seconds.*", "s", "wall time of a stage of the run; differs from run to run"),
    stat(
        "simulated_rays_per_wall_second.*",
        "rays/s",
        "the simulator's own speed: rays traced or replayed a second of wall time; differs from run to run",
    ),
    stat("policies.*.frame", "frame number", "the frame that these counts are of"),
    stat("policies.*.primary_rays", "rays", "rays from the camera: one a pixel"),
    stat("policies.*.secondary_rays", "rays", "reflected and refracted rays"),
    stat(
        "policies.*.shadow_rays",
        "rays",
        "shadow rays that there are without culling: one a hit and light that asks for it",
    ),
    stat("policies.*.shadow_rays_skipped", "rays", "shadow rays whose answer was known: nothing was traced"),
    stat("policies.*.shadow_rays_dynamic_only", "rays", "shadow rays traced among dynamic triangles only"),
    stat("policies.*.occlusion_tests", "tests", "primary rays tested against a neighbour pixel's primitive"),
    stat("policies.*.occlusion_tests_per_pixel", "tests/pixel", "occlusion_tests / primary_rays"),
    stat("policies.*.node_visits", "visits", "nodes fetched by primary and secondary rays"),
    stat("policies.*.triangle_tests", "tests", "triangles tested by primary and secondary rays"),
    stat("policies.*.shadow_node_visits", "visits", "nodes fetched by shadow rays"),
    stat("policies.*.shadow_triangle_tests", "tests", "triangles tested by shadow rays"),
    stat("policies.*.list_reads", "reads", "entries of the kd-tree's primitive lists read by any ray or policy"),
    stat(
        "policies.*.policy_node_visits",
        "visits",
        "nodes fetched by the policy itself (shaft queries, searches below a node)",
    ),
    stat(
        "policies.*.policy_triangle_tests",
        "tests",
        "triangles tested by the policy itself, occlusion tests included",
    ),
    stat("policies.*.policy_reads", "accesses", "reads of the policy's stores: mode words, counters, occluder ids"),
    stat(
        "policies.*.policy_writes",
        "accesses",
        "writes of the policy's stores, reads with a write after them included",
    ),
    stat("policies.*.false_dark", "rays", "shadow rays decided dark that, traced without culling, find the light"),
    stat("policies.*.false_lit", "rays", "shadow rays decided lit that, traced without culling, are stopped"),
    stat("policies.*.compared_rays", "rays", "shadow rays of primary hits that the reference renderer traced too"),
    stat(
        "policies.*.numeric_differences",
        "rays",
        "those of compared_rays on which tracer (f32, nothing culled) and reference renderer (f64) differ: rounding, no decision",
    ),
    stat(
        "policies.*.traversal_saved",
        "share",
        "of a frame: 1 - (shadow_node_visits + policy_node_visits) / the baseline's shadow_node_visits",
    ),
    stat("policies.*.traversal_saved.mean", "share", "mean of traversal_saved over the frames"),
    stat("policies.*.traversal_saved.max", "share", "the most of any frame"),
    stat("policies.*.traversal_saved.max_frame", "frame number", "the first frame that saved that much"),
    stat("policies.*.traversal_saved.total", "share", "the same over the rays of all frames together"),
    stat(
        "policies.*.intersection_saved",
        "share",
        "of a frame: 1 - (shadow_triangle_tests + policy_triangle_tests - occlusion_tests) / the baseline's shadow_triangle_tests",
    ),
    stat("policies.*.intersection_saved.mean", "share", "mean of intersection_saved over the frames"),
    stat("policies.*.intersection_saved.max", "share", "the most of any frame"),
    stat("policies.*.intersection_saved.max_frame", "frame number", "the first frame that saved that much"),
    stat("policies.*.intersection_saved.total", "share", "the same over the rays of all frames together"),
    stat("policies.*.psnr.decibel", "dB", "peak signal-to-noise ratio of the picture against the reference renderer's"),
    stat("policies.*.psnr_db", "dB", "psnr as a column of frames.csv; `inf` where no pixel differs"),
    stat("policies.*.lights.*.light", "number", "a light"),
    stat("policies.*.lights.*.false_dark", "rays", "false_dark towards this light"),
    stat("policies.*.lights.*.false_lit", "rays", "false_lit towards this light"),
    stat("machines.*.frames.*", "frame number", "the frames that the machine replayed, in order"),
    stat(
        "machines.*.policies.*.cycles",
        "cycles",
        "from the first ray to the last request served, of the machine's clock",
    ),
    stat("machines.*.policies.*.clock_mhz", "MHz", "the machine's clock"),
    stat("machines.*.policies.*.rays", "rays", "rays replayed, skipped ones not counted"),
    stat("machines.*.policies.*.rays_per_second", "rays/s", "rays / cycles x clock: simulated time, not wall time"),
    stat(
        "machines.*.policies.*.bytes.*.*",
        "B",
        "bytes moved between a level and the one above it (towards the units), a class of traffic",
    ),
    stat(
        "machines.*.policies.*.caches.*.*.accesses",
        "accesses",
        "lines asked of a kind of cache: hits + half_misses + misses + passed_writes",
    ),
    stat("machines.*.policies.*.caches.*.*.hits", "accesses", "the line was there"),
    stat("machines.*.policies.*.caches.*.*.half_misses", "accesses", "the line was on its way already"),
    stat("machines.*.policies.*.caches.*.*.misses", "accesses", "the line was fetched from the level below"),
    stat(
        "machines.*.policies.*.caches.*.*.passed_writes",
        "accesses",
        "the line was not there, and a write that allocates none (`no_allocate`) went down to the level below",
    ),
    stat(
        "machines.*.policies.*.caches.*.*.bank_conflicts",
        "cycles",
        "an access to an L1 with `banks` waited, since its bank had made another in the cycle",
    ),
    stat(
        "machines.*.policies.*.caches.*.*.write_backs",
        "lines",
        "dirty lines of the class that were displaced and written down",
    ),
    stat(
        "machines.*.policies.*.hit_rate.*.*",
        "share",
        "hits / accesses of a kind of cache and a class; a half miss is no hit",
    ),
    stat(
        "machines.*.policies.*.units.*.busy",
        "cycles",
        "an operation occupied the entry of the pipeline; summed over the units of the kind",
    ),
    stat(
        "machines.*.policies.*.units.*.pipeline",
        "cycles",
        "no operation began: all rays of the unit are inside its pipeline",
    ),
    stat("machines.*.policies.*.units.*.memory", "cycles", "no operation began: a ray waits for data of the cache"),
    stat(
        "machines.*.policies.*.units.*.blocked",
        "cycles",
        "no operation began: a neighbour cannot take what is ready for it",
    ),
    stat(
        "machines.*.policies.*.units.*.intake",
        "cycles",
        "no operation began: the unit took as many rays as its width allows, and others wait in front of it",
    ),
    stat(
        "machines.*.policies.*.units.*.starved",
        "cycles",
        "no operation began: no ray is in the unit, and none waits in front of it",
    ),
    stat("machines.*.policies.*.unit_counts.*", "units", "instances of a kind: its causes sum to cycles times this"),
    stat("machines.*.policies.*.utilization.*", "share", "busy / (cycles x unit_counts) of a kind of unit"),
    stat("machines.*.policies.*.queues.*.entries", "entries", "put into the queues in front of all parts of a kind"),
    stat(
        "machines.*.policies.*.queues.*.waited",
        "cycles",
        "that entries stood in these queues: over entries the mean wait, over the run's cycles the mean number that stood there",
    ),
    stat("machines.*.policies.*.latency.*.rays", "rays", "traced rays of a kind whose latency is known"),
    stat(
        "machines.*.policies.*.latency.*.cycles",
        "cycles",
        "from being handed over to being done, policy steps included; summed over the rays of the kind",
    ),
    stat(
        "machines.*.policies.*.latency.*.unloaded",
        "cycles",
        "what these rays take at least, alone and with every line at hand, without policy steps",
    ),
    stat("machines.*.policies.*.latency.*.most", "cycles", "the longest latency of a ray of the kind"),
    stat("machines.*.policies.*.dram.reads", "commands", "lines read"),
    stat("machines.*.policies.*.dram.writes", "commands", "lines written"),
    stat("machines.*.policies.*.dram.row_hits", "commands", "column commands that found their row open"),
    stat(
        "machines.*.policies.*.dram.row_misses",
        "commands",
        "column commands whose bank was closed: an activate went before",
    ),
    stat(
        "machines.*.policies.*.dram.row_conflicts",
        "commands",
        "column commands for which another row had to be closed",
    ),
    stat("machines.*.policies.*.dram.refreshes", "commands", "refreshes given, all channels together"),
    stat("machines.*.policies.*.dram_row_hit_rate", "share", "row_hits / (row_hits + row_misses + row_conflicts)"),
    stat(
        "machines.*.policies.*.dram_peak_bytes_per_cycle",
        "B/cycle",
        "what all channels can move at their peak; absent if nothing limits it",
    ),
    stat(
        "machines.*.policies.*.accuracy.estimated.cycles",
        "share",
        "half the width of the 95 % interval of the cycles, over the estimate",
    ),
    stat(
        "machines.*.policies.*.accuracy.estimated.dram_bytes",
        "share",
        "half the width of the 95 % interval of the DRAM's bytes, over the estimate",
    ),
    stat(
        "machines.*.policies.*.accuracy.estimated.l2_bytes",
        "share",
        "half the width of the 95 % interval of the bytes between L1s and L2, over the estimate",
    ),
    stat("machines.*.policies.*.accuracy.estimated.rate", "share", "windows that were measured, of all"),
    stat(
        "machines.*.policies.*.half_widths.*",
        "as the figure",
        "half the width of the 95 % interval of the figure with this path",
    ),
    stat("machines.*.policies.*.needs.target", "share", "the error that was asked for"),
    stat("machines.*.policies.*.needs.pilot_share", "share", "pixels of the pilot, of all; as many were held back"),
    stat("machines.*.policies.*.needs.parts.*.cycles", "share", "change of the pilot's cycles without the part"),
    stat(
        "machines.*.policies.*.needs.parts.*.l2_bytes",
        "share",
        "change of the pilot's bytes between L1s and L2 without the part",
    ),
    stat(
        "machines.*.policies.*.needs.parts.*.dram_bytes",
        "share",
        "change of the pilot's DRAM bytes without the part",
    ),
    stat(
        "machines.*.policies.*.needs.models.*.error",
        "share",
        "largest error of the model's cycles and bytes on the pilot; of a sample, half its widest interval",
    ),
    stat("machines.*.policies.*.needs.models.*.held_back", "share", "the same on what was held back"),
    stat("machines.*.policies.*.bounds.cycles.least", "cycles", "no machine of the spec can take less on this stream"),
    stat("machines.*.policies.*.bounds.cycles.most", "cycles", "everything missed, one thing after another"),
    stat("machines.*.policies.*.bounds.l2_bytes.least", "B", "every line once from the L2 for each kind of unit"),
    stat("machines.*.policies.*.bounds.l2_bytes.most", "B", "every access misses, every write is written back"),
    stat("machines.*.policies.*.bounds.dram_bytes.least", "B", "every line once from the DRAM"),
    stat(
        "machines.*.policies.*.bounds.dram_bytes.most",
        "B",
        "every access misses, every write is fetched and written back",
    ),
    stat(
        "machines.*.policies.*.oracle.cycles",
        "cycles",
        "the least that is left if the answers of all shadow rays are known for nothing",
    ),
    stat(
        "machines.*.policies.*.oracle.dram_bytes",
        "B",
        "the least that is left if the answers of all shadow rays are known for nothing",
    ),
    stat(
        "machines.*.split.*.cycles.*",
        "cycles",
        "without culling (0), with the policy and words that cost nothing (1), as it is (2)",
    ),
    stat("machines.*.split.*.dram.*", "B", "DRAM bytes of the same three replays"),
    stat(
        "machines.*.split.*.saved",
        "B",
        "DRAM bytes that culling saves if words cost nothing, its own occlusion tests counted in",
    ),
    stat("machines.*.split.*.words", "B", "DRAM bytes of mode words, counters and occluder ids"),
    stat(
        "machines.*.split.*.interference",
        "B",
        "DRAM bytes of other classes that words drove out of caches; words + interference - saved is the change",
    ),
    stat(
        "machines.*.split.*.extra_misses",
        "accesses",
        "misses of other classes, in all caches, that words that cost nothing do not cause",
    ),
    stat(
        "machines.*.split.*.word_hit_rate",
        "share",
        "hits / accesses of words, counters and ids in the first cache that they meet",
    ),
    stat(
        "machines.*.split.*.shadow_rays",
        "rays",
        "shadow rays that there are without culling, in the frames replayed",
    ),
    stat(
        "machines.*.split.*.culled",
        "share",
        "those of them that were skipped or traced among dynamic triangles only",
    ),
    stat("machines.*.split.*.bytes_per_ray", "B/ray", "DRAM bytes a ray of the replay without culling"),
    stat(
        "machines.*.split.*.break_even",
        "share",
        "shadow rays that must be culled to save what words cost, at bytes_per_ray: (words + interference) / (bytes_per_ray x shadow_rays)",
    ),
    stat("points.*.bytes.*", "B", "of a sweep's point: DRAM bytes of a class of traffic, as it is"),
    stat(
        "points.*.hit_rate.*.*",
        "share",
        "of a sweep's point: hits / accesses of a kind of cache and a class, as it is",
    ),
    stat("machines.*.policies.*.dram_utilization", "share", "bytes moved / (dram_peak_bytes_per_cycle x cycles)"),
];

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
    fn parts(&self) -> impl DoubleEndedIterator<Item = &'static str> {
        self.name.split('.')
    }

    /// Whether this is the declaration of the number at `path`.
    fn declares(&self, path: &[String]) -> bool {
        let (mut own, mut path) = (self.name, path);
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
    let declarations = |path: &[String]| STATISTICS.iter().filter(|statistic| statistic.declares(path)).count();
    found.into_iter().filter(|(path, _)| declarations(path) != 1).map(|(path, _)| path.join(".")).collect()
}

/// What the statistics mean that end with `name`, or all of them, with their values in `report` if there is one; `Err` says
/// what else is there when nothing is called so.
pub fn explain(name: Option<&str>, report: Option<&Value>) -> Result<String, String> {
    let meant = |statistic: &&Statistic| name.is_none_or(|name| statistic.is_meant(name));
    let meant: Vec<_> = STATISTICS.iter().filter(meant).collect();
    if meant.is_empty() {
        let name = name.unwrap_or_default();
        let similar =
            STATISTICS.iter().filter(|statistic| statistic.name.contains(name)).map(|statistic| statistic.name);
        let similar: Vec<_> = similar.collect();
        let hint = if similar.is_empty() { String::new() } else { format!("; there are {}", similar.join(", ")) };
        return Err(format!("no statistic is called `{name}`{hint} (`umbrasim explain` lists all)"));
    }
    let heads = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect();
    let row = |it: &&Statistic| vec![it.name.to_owned(), it.unit.to_owned(), it.about.to_owned()];
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

    #[test]
    fn every_number_of_a_report_is_declared_once_and_every_declaration_is_of_one() {
        let sample = concat!(env!("CARGO_MANIFEST_DIR"), "/reports/sample");
        let text = std::fs::read_to_string(format!("{sample}/summary.json")).unwrap();
        let summary = serde_json::from_str(&text).unwrap();
        assert_eq!(undeclared(&summary), Vec::<String>::new());
        let mut found = Vec::new();
        numbers(&summary, &mut Vec::new(), &mut found);
        // The written sample is of an exact rung; what estimates add is in the one made for tests.
        let estimated = serde_json::to_value(crate::report::run::tests::sample::sample(&[0]).summary).unwrap();
        numbers(&estimated, &mut Vec::new(), &mut found);
        let sweep = serde_json::to_value(crate::report::run::tests::sample::sweep()).unwrap();
        assert_eq!(undeclared(&sweep), Vec::<String>::new());
        numbers(&sweep, &mut Vec::new(), &mut found);
        let csv = std::fs::read_to_string(format!("{sample}/frames.csv")).unwrap();
        let columns: Vec<_> =
            csv.lines().next().unwrap().split(',').skip(1).map(|name| format!("policies.*.{name}")).collect();
        for column in &columns {
            assert!(STATISTICS.iter().any(|statistic| statistic.name == column), "{column}");
        }
        for statistic in STATISTICS {
            let is_there =
                found.iter().any(|(path, _)| statistic.declares(path)) || columns.iter().any(|it| it == statistic.name);
            assert!(is_there, "{} is declared, and no number is called so", statistic.name);
        }
    }

    #[test]
    fn a_name_means_what_ends_with_it() {
        let names = |asked: &str| {
            let meant = STATISTICS.iter().filter(|statistic| statistic.is_meant(asked));
            meant.map(|statistic| statistic.name).collect::<Vec<_>>()
        };
        assert_eq!(names("row_hits"), ["machines.*.policies.*.dram.row_hits"]);
        assert_eq!(names("bytes.dram.mode_word"), ["machines.*.policies.*.bytes.*.*"]);
        assert_eq!(names("false_dark"), ["policies.*.false_dark", "policies.*.lights.*.false_dark"]);
        let error = explain(Some("row_hit"), None).unwrap_err();
        assert!(error.contains("`row_hit`; there are machines.*.policies.*.dram.row_hits"), "{error}");
    }
}
