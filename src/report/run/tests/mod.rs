//! Tests of a run's report, and of features that all reports share.

pub(crate) mod sample;

use std::collections::{BTreeMap, BTreeSet};

use std::fs;
use std::path::{Path, PathBuf};

use self::sample::{frame, over_time, sample};
use super::*;
use crate::named::Named;
use crate::output::{FolderError, ResultsFolder};
use crate::quantity::Cycle;
use crate::report::error::ReportError;
use crate::report::writer::{self, SUMMARY_FILE};
use crate::stats::{Accuracy, MachineStats, Residual, Residuals};
use crate::stream::Totals;

/// A directory for a test, and the path of a report in it.
fn place() -> (tempfile::TempDir, PathBuf) {
    let dir = tempfile::tempdir().unwrap();
    let target = dir.path().join("reports/sample");
    (dir, target)
}

/// Writes a report to `target`.
fn write(target: &Path, report: &RunFiles) -> Result<PathBuf, ReportError> {
    writer::write(&ResultsFolder::claim(target)?, report)
}

/// Redraws the report at `target`.
fn drawn_again(target: &Path) -> Result<PathBuf, ReportError> {
    redraw(&ResultsFolder::claim(target)?)
}

/// All files below a directory, with their bytes.
fn files(dir: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut found = BTreeMap::new();
    for entry in fs::read_dir(dir).unwrap() {
        let path = entry.unwrap().path();
        let name = PathBuf::from(path.file_name().unwrap());
        if path.is_dir() {
            found.extend(files(&path).into_iter().map(|(below, bytes)| (name.join(below), bytes)));
        } else {
            found.insert(name, fs::read(&path).unwrap());
        }
    }
    found
}

/// The paths of all keys; names from the experiment are replaced by `NAME`.
fn keys(value: &serde_json::Value, path: &str, found: &mut BTreeSet<String>) {
    const BY_NAME: [&str; 7] =
        [".policies", ".machines", ".split", ".provenance", ".made", ".wall_seconds", "per_wall_second"];
    match value {
        serde_json::Value::Object(map) => {
            let named = BY_NAME.iter().any(|end| path.ends_with(end));
            for (key, value) in map {
                keys(value, &format!("{path}.{}", if named { "NAME" } else { key }), found);
            }
        }
        serde_json::Value::Array(items) => items.iter().for_each(|item| keys(item, &format!("{path}[]"), found)),
        _ => {
            found.insert(path.into());
        }
    }
}

#[test]
fn a_change_between_samples_of_other_windows_is_as_sure_as_both() {
    let mut summary = sample(&[0]).summary;
    let rows = super::terminal::machines(&summary).rows;
    // Each run's cycles are known within 1 %, its bytes within 2 %; the ratios are 0.89 and 1.3.
    assert!(rows[0][3].ends_with("\u{b1} 1.8 %") && rows[0][5].contains('\u{b1}'), "{rows:?}");
    // Samples of the same windows have the same errors, so the change is known better than either run.
    let point = |at: usize| Residual { place: at as f64, stratum: at / 2, weight: 1.0, errors: [0.001 * at as f64; 3] };
    let points = (0..16).map(point).collect();
    let residuals = Residuals { window_pixels: 512, seed: 0, freedom: [8.0; 3], points, change: None };
    for machine in summary.machines.values_mut() {
        machine.policies.values_mut().for_each(|run| run.stats.residuals = Some(residuals.clone()));
    }
    let rows = super::terminal::machines(&summary).rows;
    assert!(rows[0][3].ends_with("\u{b1} 0.0 %"), "{rows:?}");
}

#[test]
fn no_run_is_silent_about_its_error() {
    let sampled = Accuracy::Estimated { cycles: 0.01, l2_bytes: 0.5, dram_bytes: 0.0312, rate: 0.1 };
    let all = [Accuracy::Exact, sampled, Accuracy::Bounded, Accuracy::Unknown];
    let all = all.map(|accuracy| tables::error(&accuracy));
    assert_eq!(all, ["exact", "\u{b1} 1.0, 3.1 %", "within bounds", "unknown"]);
}

/// The difference of two bounds bounds nothing, and a level whose error is not known is named.
#[test]
fn a_verdict_claims_what_its_level_knows() {
    let verdicts = |fidelity: &str, accuracy: Accuracy| {
        let mut summary = sample(&[0, 16]).summary;
        let told =
            |run: &MachineRun| MachineRun { stats: MachineStats { accuracy, ..run.stats.clone() }, ..run.clone() };
        let of_machine = |machine: &MachineSummary| MachineSummary {
            fidelity: fidelity.into(),
            policies: machine.policies.iter().map(|(name, run)| (name, told(run))).collect(),
            ..machine.clone()
        };
        summary.machines = summary.machines.iter().map(|(name, machine)| (name, of_machine(machine))).collect();
        let page = page::page(&summary, "", &[], &[]).unwrap();
        let (_, finding) = page.split_once("<p class=\"finding\">").unwrap();
        [verdict(&summary).unwrap(), finding.split("</p>").next().unwrap().to_owned()]
    };
    for text in verdicts("Event", Accuracy::Exact) {
        assert!(text.contains("less time on small") && !text.contains("error unknown"), "{text}");
    }
    let by_profile = [Accuracy::Bounded, Accuracy::Unknown].map(|accuracy| verdicts("Profile", accuracy));
    for text in by_profile.into_iter().flatten() {
        assert!(text.contains("less time on small by Profile, error unknown"), "{text}");
    }
    for text in verdicts("Bound", Accuracy::Bounded) {
        assert!(!text.contains("time on"), "{text}");
    }
}

#[test]
fn the_names_in_the_summary_stay() {
    let (_dir, target) = place();
    write(&target, &sample(&[0, 16])).unwrap();
    let value = serde_json::from_slice(&fs::read(target.join(SUMMARY_FILE)).unwrap()).unwrap();
    let mut found = BTreeSet::new();
    keys(&value, "", &mut found);
    insta::assert_snapshot!(found.into_iter().collect::<Vec<_>>().join("\n"));
}

#[test]
fn a_summary_survives_its_file_in_the_experiments_order() {
    let summary = sample(&[0, 16]).summary;
    let text = serde_json::to_string(&summary).unwrap();
    let read: Summary = serde_json::from_str(&text).unwrap();
    assert_eq!(serde_json::to_string(&read).unwrap(), text);
    let names: Vec<&str> = read.policies.iter().map(|(name, _)| name).collect();
    assert_eq!(names, ["off", "published", "last_occluder"]);
}

#[test]
fn energy_saved_and_paid_is_that_of_the_replays() {
    let summary = sample(&[0, 16]).summary;
    let (_, machine) = summary.machines.iter().next().unwrap();
    let joules = |policy: &str| machine.policies.get(policy).unwrap().stats.energy.as_ref().unwrap().joules;
    let split = machine.split.get("published").unwrap().joules.unwrap();
    assert_eq!([split[0], split[2]], [joules("off"), joules("published")]);
    let table = super::tables::split(machine);
    let names = ["energy", "energy saved", "energy paid"];
    assert_eq!(table.head[table.head.len() - 3..], names);
}

#[test]
fn saved_shares_follow_their_definition() {
    let with = |frame: u32, nodes: u64, tests: u64| FrameResult {
        frame,
        totals: Totals {
            primary_rays: 4,
            shadow_rays: 10,
            shadow_node_visits: nodes,
            shadow_triangle_tests: tests,
            // One shaft node; two occluders tested again; three occlusion tests.
            policy_node_visits: 1,
            policy_triangle_tests: 5,
            ..Totals::default()
        },
        occlusion_tests: 3,
        false_dark: Some(1),
        false_lit: None,
        compared_rays: None,
        numeric_differences: None,
        psnr: None,
    };
    let off = |frame: u32, nodes: u64, tests: u64| {
        let mut result = with(frame, nodes, tests);
        (result.totals.policy_node_visits, result.totals.policy_triangle_tests, result.occlusion_tests) = (0, 0, 0);
        result
    };
    let baseline = [off(0, 100, 50), off(7, 300, 50), off(9, 0, 0)];
    let policy = PolicySummary::new(&[with(0, 89, 43), with(7, 149, 8), with(9, 0, 0)], Vec::new(), Some(&baseline));
    let shares: Vec<_> = policy.frames.iter().map(|frame| (frame.traversal_saved, frame.intersection_saved)).collect();
    let near = |share: Option<f64>, wanted: f64| (share.unwrap() - wanted).abs() < 1e-12;
    assert!(near(shares[0].0, 0.1) && near(shares[0].1, 0.1), "{shares:?}");
    assert!(near(shares[1].0, 0.5) && near(shares[1].1, 0.8), "{shares:?}");
    assert_eq!(shares[2], (None, None));
    let saved = policy.traversal_saved;
    assert!(near(saved.mean, 0.3) && near(saved.max, 0.5), "{saved:?}");
    assert_eq!(saved.max_frame, Some(7));
    assert!(near(saved.total, 1.0 - (90.0 + 150.0 + 1.0) / 400.0), "{saved:?}");
    assert_eq!(policy.counts.occlusion_tests_per_pixel, Some(0.75));
    assert_eq!((policy.counts.false_dark, policy.counts.false_lit), (Some(3), None));

    let alone = PolicySummary::new(&[with(0, 89, 43)], Vec::new(), None);
    assert_eq!(alone.traversal_saved, Default::default());
    // If the baseline lacks some of the frames, there is no share over all frames.
    let partly = PolicySummary::new(&[with(0, 89, 43), with(8, 1, 1)], Vec::new(), Some(&baseline));
    assert_eq!((partly.frames[1].traversal_saved, partly.traversal_saved.total), (None, None));
}

#[test]
fn a_machine_that_did_nothing_has_no_rates() {
    let run = MachineRun::from(MachineStats::default());
    assert_eq!((run.rays_per_second, run.dram_row_hit_rate, run.dram_utilization), (None, None, None));
    let text = serde_json::to_string(&run).unwrap();
    assert_eq!(serde_json::from_str::<MachineRun>(&text).unwrap(), run);
}

#[test]
fn frames_csv_has_a_row_a_policy_and_frame() {
    let csv = String::from_utf8(frames_csv::frames_csv(&sample(&[0, 16]).summary).bytes().unwrap()).unwrap();
    insta::assert_snapshot!(csv);
}

#[test]
fn the_terminal_gets_a_screenful() {
    let text = terminal(&sample(&[0, 16]).summary);
    assert!(text.lines().count() <= 24, "{text}");
    assert!(text.lines().all(|line| line.chars().count() <= 80), "{text}");
    insta::assert_snapshot!(text);
}

/// Fails unless every tag is closed in order, every attribute is quoted and every `&` begins an entity.
fn assert_well_formed(svg: &str) {
    let mut open: Vec<&str> = Vec::new();
    let mut roots = 0;
    for piece in svg.split('<').skip(1) {
        let (tag, text) = piece.split_once('>').unwrap_or_else(|| panic!("an open tag: {piece}"));
        assert!(!text.contains('>'), "a stray bracket: {piece}");
        for entity in piece.split('&').skip(1) {
            let name = entity.split(';').next().unwrap();
            assert!(["lt", "gt", "amp", "quot", "apos", "#x27"].contains(&name), "a stray ampersand: {piece}");
        }
        if let Some(name) = tag.strip_prefix('/') {
            assert_eq!(open.pop(), Some(name), "closed out of order");
            continue;
        }
        let (name, attributes) = tag.split_once(' ').unwrap_or((tag, ""));
        roots += usize::from(open.is_empty());
        assert_eq!(attributes.matches('"').count(), 2 * attributes.matches("=\"").count(), "{piece}");
        if !attributes.ends_with('/') {
            open.push(name);
        }
    }
    assert!(open.is_empty() && roots == 1, "{open:?}");
}

#[test]
fn plots_are_well_formed_and_the_same_twice() {
    let mut summary = sample(&[0, 16, 48]).summary;
    let published = summary.policies.get("published").unwrap().clone();
    summary.policies.insert("a<b & \"c\"", published);
    let drawings = plots::draw(&summary, &over_time(&summary)).unwrap();
    let names: Vec<&str> = drawings.iter().map(|drawing| drawing.name.as_str()).collect();
    assert_eq!(
        names,
        [
            "saving",
            "wrong",
            "tradeoff",
            "times-small",
            "times-desktop",
            "diagram-small",
            "diagram-desktop",
            "utilization-small",
            "utilization-desktop",
            "over_time-small",
            "over_time-desktop",
            "split-small",
            "split-desktop",
            "bytes-small",
            "bytes-desktop",
            "hit_rates-small",
            "hit_rates-desktop",
            "reuse-small",
            "reuse-desktop",
            "dram_rows-small",
            "dram_rows-desktop"
        ]
    );
    for drawing in &drawings {
        assert_well_formed(&drawing.file);
        assert!(drawing.file.contains("published"), "{}", drawing.name);
        assert!(!drawing.data.rows.is_empty() && !drawing.title.is_empty(), "{}", drawing.name);
    }
    assert!(drawings[0].file.contains("a&lt;b &amp; &quot;c&quot;"));
    assert_eq!(plots::draw(&summary, &over_time(&summary)).unwrap(), drawings);
}

#[test]
fn a_run_with_little_data_is_drawn_too() {
    let mut report = sample(&[5]);
    report.summary.baseline = None;
    report.summary.machines = Named::default();
    report.summary.policies =
        [("published", PolicySummary::new(&[frame(5, 0.2, 0)], Vec::new(), None))].into_iter().collect();
    report.pictures.clear();
    let names: Vec<String> =
        plots::draw(&report.summary, &report.over_time).unwrap().into_iter().map(|drawing| drawing.name).collect();
    assert_eq!(names, ["wrong"]);
    let (_dir, target) = place();
    write(&target, &report).unwrap();
    assert!(fs::read_to_string(target.join("index.html")).unwrap().contains("nothing to compare"));
}

#[test]
fn the_page_has_every_part_and_needs_no_other_file() {
    let (_dir, target) = place();
    let report = sample(&[0, 16]);
    write(&target, &report).unwrap();
    let page = fs::read_to_string(target.join("index.html")).unwrap();
    for id in ["policies", "frames", "machine-1", "machine-2", "run"] {
        assert_eq!(page.matches(&format!("<section id=\"{id}\">")).count(), 1, "{id}");
    }
    let plots = plots::draw(&report.summary, &report.over_time).unwrap();
    assert_eq!(page.matches("<svg class=\"wide\"").count(), plots.len());
    assert_eq!(page.matches("<svg class=\"narrow\"").count(), plots.len());
    // Each reference once, one overlay per policy, and mode words.
    assert!(page.matches("href=\"data:image/png;base64,").count() > 1);
    assert_eq!(page.matches("<script>").count(), 1);
    assert!(!page.contains("src=\"http") && !page.contains("@import") && !page.contains("url("));
    assert!(include_str!("../../script.js").len() < 12_000);
    assert!(page.contains("kitchen &lt;sample&gt;") && page.contains("&lt;a comment&gt;"));
    assert!(page.contains(", most in frame 16"));
    assert!(page.contains("0123456789abcdef") && page.contains("wrong shadow decisions"));
}

#[test]
fn rays_that_are_culled_are_answered() {
    let stats = MachineStats { cycles: Cycle(1000), clock_mhz: 1.0, rays: 40, ..MachineStats::default() };
    let run = MachineRun::new(stats, Some(Asked { frames: 1, rays: 100 }));
    let rates = [run.rays_per_second, run.rays_answered_per_second].map(Option::unwrap);
    assert_eq!(rates.map(f64::round), [40_000.0, 100_000.0]);
}

#[test]
fn the_samples_page_is_small() {
    let page = fs::read(concat!(env!("CARGO_MANIFEST_DIR"), "/reports/sample/index.html")).unwrap();
    assert!(page.len() < 500_000, "{} bytes", page.len());
}

#[test]
fn the_same_run_gives_the_same_bytes_and_so_does_drawing_again() {
    let (_dir, target) = place();
    let report = sample(&[0, 16]);
    write(&target, &report).unwrap();
    let first = files(&target);
    assert!(first.len() > 15 && first.values().all(|bytes| !bytes.is_empty()));

    for (name, _) in first.iter().filter(|(name, _)| name.ends_with("index.html") || name.starts_with("plots")) {
        fs::remove_file(target.join(name)).unwrap();
    }
    drawn_again(&target).unwrap();
    assert_eq!(files(&target), first);

    write(&target, &report).unwrap();
    assert_eq!(files(&target), first);
    assert_eq!(fs::read_dir(target.parent().unwrap()).unwrap().count(), 1, "something was left beside the report");
}

#[test]
fn a_failure_leaves_the_place_as_it_was() {
    let (_dir, target) = place();
    let (summary, config, mut images) = sample::parts(&[0, 16]);
    images[3].1.pixels.pop();
    let error = RunFiles::new(summary, config, &images).unwrap_err();
    assert!(matches!(&error, ReportError::Picture { file, .. } if file.contains("words-light0")), "{error}");
    let mut report = sample(&[0, 16]);
    // A picture in a folder with the name of a file fails only after other files are written.
    report.pictures[3].0.file = "pictures/frame0000-reference.png/words.png".into();
    let error = write(&target, &report).unwrap_err();
    assert!(matches!(&error, ReportError::Write { path, .. } if path.starts_with(&target)), "{error}");
    assert!(!target.parent().unwrap().exists());

    write(&target, &sample(&[0])).unwrap();
    let earlier = files(&target);
    assert!(write(&target, &report).is_err());
    assert_eq!(files(&target), earlier);
    assert_eq!(fs::read_dir(target.parent().unwrap()).unwrap().count(), 1);
}

#[test]
fn what_is_no_report_is_not_overwritten() {
    let (dir, target) = place();
    fs::create_dir_all(&target).unwrap();
    write(&target, &sample(&[0])).expect("an empty directory is free");

    let file = dir.path().join("file");
    fs::write(&file, "mine").unwrap();
    let error = write(&file, &sample(&[0])).unwrap_err();
    assert!(matches!(error, ReportError::Folder(FolderError::Foreign { .. })), "{error}");
    assert_eq!(fs::read(&file).unwrap(), b"mine");
    let error = write(&file.join("below"), &sample(&[0])).unwrap_err();
    assert!(matches!(error, ReportError::Folder(FolderError::Foreign { .. })), "{error}");

    let folder = dir.path().join("folder");
    fs::create_dir(&folder).unwrap();
    fs::write(folder.join("thesis.tex"), "mine").unwrap();
    let error = write(&folder, &sample(&[0])).unwrap_err();
    assert!(error.to_string().contains("folder is not an umbrasim report"), "{error}");
    fs::write(folder.join(SUMMARY_FILE), "{\"title\": \"of a book\"}").unwrap();
    assert!(matches!(
        ResultsFolder::claim(&folder).map_err(ReportError::from),
        Err(ReportError::Folder(FolderError::Foreign { .. }))
    ));
    assert_eq!(files(&folder).len(), 2);
}

#[test]
fn a_broken_or_other_summary_is_not_drawn() {
    let (_dir, target) = place();
    assert!(matches!(drawn_again(&target), Err(ReportError::Read { .. })));
    write(&target, &sample(&[0, 16])).unwrap();
    let path = target.join(SUMMARY_FILE);
    let text = fs::read_to_string(&path).unwrap();
    let with = |from: &str, to: &str| {
        assert!(text.contains(from), "{from}");
        fs::write(&path, text.replacen(from, to, 1)).unwrap();
        let before = files(&target);
        let error = drawn_again(&target).unwrap_err();
        assert_eq!(files(&target), before, "drawn in spite of {error}");
        error
    };
    let error = with("\"schema\": 1", "\"schema\": 99");
    assert!(error.to_string().contains("has schema 99; this version reads schema 1"), "{error}");
    let error = with("\"schema\": 1,", "");
    assert!(
        matches!(&error, ReportError::Broken { source, .. } if source.to_string().contains("missing field `schema`"))
    );
    assert!(matches!(with("\"shadow_rays\":", "\"shadow_roys\":"), ReportError::Broken { .. }));
    assert!(matches!(with("}", ""), ReportError::Broken { .. }));
    let picture = "pictures/frame0000-published-render.png";
    assert!(matches!(with(picture, "../../../secret.png"), ReportError::Outside { .. }));
    assert!(matches!(with(picture, "pictures/none.png"), ReportError::Read { .. }));
}
