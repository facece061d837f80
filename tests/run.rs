//! Whole runs: the same bytes on any number of threads, the names that other tools read, and the commands beside `run`.

mod common;

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Stdio};
use std::time::{Duration, Instant};

use serde_json::Value;

use common::{Desk, EXPERIMENT, ROOT, shared};
use umbrasim::experiment::{self, Experiment, Overrides};

fn config(file: &str) -> PathBuf {
    Path::new(ROOT).join("configs").join(file)
}

fn configs(folder: &str) -> Vec<PathBuf> {
    let mut files: Vec<_> = fs::read_dir(config(folder)).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    files
}

/// A run of the quick start, small, in a folder of its own.
fn quickstart(threads: &str) -> Desk {
    quickstart_with(&["--threads", threads])
}

/// The same with options.
fn quickstart_with(options: &[&str]) -> Desk {
    let desk = Desk::new();
    let config = config("experiments/quickstart.ron");
    let size = ["--resolution", "64x64", "--frames", "0..4", "--out", "report"];
    desk.succeed(&[&["run", config.to_str().unwrap()], &size[..], options].concat());
    desk
}

fn json(text: impl AsRef<[u8]>) -> Value {
    serde_json::from_slice(text.as_ref()).unwrap()
}

fn summary(desk: &Desk) -> Value {
    json(fs::read(desk.path("report/summary.json")).unwrap())
}

/// Files of a report by their names in it.
fn report(desk: &Desk) -> BTreeMap<PathBuf, Vec<u8>> {
    let of = |(path, bytes): (PathBuf, _)| (path.strip_prefix(desk.path("report")).unwrap().to_owned(), bytes);
    desk.contents().into_iter().filter(|(path, _)| path.starts_with(desk.path("report"))).map(of).collect()
}

#[test]
fn every_number_is_declared_and_can_be_explained() {
    let desk = quickstart("2");
    assert_eq!(umbrasim::report::explain::undeclared(&summary(&desk)), Vec::<String>::new(), "declare them in OTHERS");
    let told = desk.succeed(&["explain", "row_hits", "--report", "report"]);
    let folded = told.split_whitespace().collect::<Vec<_>>().join(" ");
    assert!(folded.contains("column commands that found their row open"), "{told}");
    let hits = &summary(&desk)["machines"]["small"]["policies"]["Off"]["dram"]["row_hits"];
    assert!(told.contains("machines.small.policies.Off.dram.row_hits") && told.contains(&hits.to_string()), "{told}");
}

/// The page knows no machine's fields: the sizes that it tells must be those that a machine has with its switch on.
#[test]
fn the_page_tells_the_sizes_that_machines_have() {
    let page = fs::read_to_string(quickstart("2").path("report/index.html")).unwrap();
    let traffic = umbrasim::machine::MachineSpec::default().traffic;
    let told = format!("rays and hits: {} and {} B a ray", traffic.ray_bytes.get(), traffic.hit_bytes.get());
    assert!(page.contains(&told), "the page does not say: {told}");
}

/// Without a register, shadow-cache units are idle without culling, and the split's baseline is the replay as it is. A
/// register is written out at every end of frame: the baseline has a replay of its own, without the unit. Samples
/// have equal windows in both, but covariates are chosen by the unit's options: their estimates are as close as their
/// intervals of some per cent allow. Pools of 16 rays make windows small.
#[test]
fn a_split_begins_with_the_machine_without_its_unit() {
    for (fidelity, tolerance) in [("Event", 1e-9), ("Sampled(engine: Event, rate: 0.5)", 1e-3)] {
        let summaries = [&[][..], &["--set", "shadow_cache.register=8"]].map(|options| {
            summary(&quickstart_with(
                &[&["--set", &format!("fidelity={fidelity}"), "--set", "dispatcher.rays=16"], options].concat(),
            ))
        });
        let [idle, register] = &summaries;
        let stage = |summary: &Value| summary["wall_seconds"].get("small, Off, no unit").is_some();
        assert_eq!([stage(idle), stage(register)], [false, true]);
        for machine in ["small", "desktop"] {
            let baseline =
                |summary: &Value, figure: &str| summary["machines"][machine]["split"]["Published"][figure][0].as_f64();
            let off = &idle["machines"][machine]["policies"]["Off"];
            assert_eq!(baseline(idle, "cycles"), off["cycles"].as_f64());
            // Samples have no energy.
            let figures = ["cycles", "dram", "joules"].into_iter().take(if fidelity == "Event" { 3 } else { 2 });
            for figure in figures {
                let all = summaries.each_ref().map(|summary| baseline(summary, figure));
                let [Some(derived), Some(replayed)] = all else { panic!("{fidelity}, {machine}, {figure}: {all:?}") };
                assert!(
                    (derived / replayed - 1.0).abs() < tolerance,
                    "{fidelity}, {machine}, {figure}: {derived} {replayed}"
                );
            }
        }
    }
}

#[test]
fn every_config_loads() {
    let machines = configs("machines");
    let experiments = configs("experiments");
    assert!(machines.len() >= 2 && experiments.len() >= 5, "{machines:?} {experiments:?}");
    for file in machines {
        let machine = experiment::read_machine(&file).unwrap();
        assert_eq!(Some(machine.name.as_str()), file.file_stem().and_then(|name| name.to_str()));
    }
    let mut scenes = configs("scenes");
    for file in experiments {
        if file.ends_with("paper_table.ron") {
            let _: umbrasim::experiment::paper::PaperSpec = umbrasim::ron_file::read(&file).unwrap();
            continue;
        }
        if file.ends_with("identities.ron") {
            let _: umbrasim::experiment::identities::IdentitiesSpec = umbrasim::ron_file::read(&file).unwrap();
            continue;
        }
        let text = fs::read_to_string(&file).unwrap();
        if text.contains("experiments: [") {
            // A comparison of rungs: its experiments are loaded by themselves too.
            if Path::new(ROOT).join("../shared/scenes").exists() || !text.contains("kitchen") {
                assert!(experiment::pareto::Comparison::load(&file, None).unwrap().rungs.len() > 2);
            }
            continue;
        }
        // A sweep names an experiment, which names the scene.
        let named = text.split("experiment: \"").nth(1).and_then(|rest| rest.split('"').next());
        let scene = named.map_or(text.clone(), |named| fs::read_to_string(config("experiments").join(named)).unwrap());
        let scene = scene.split("../scenes/").nth(1).and_then(|rest| rest.split('"').next()).unwrap();
        scenes.retain(|other| !other.ends_with(scene));
        let needs = fs::read_to_string(config("scenes").join(scene)).unwrap();
        if needs.contains("shared/scenes/") && !Path::new(ROOT).join("../shared/scenes").exists() {
            println!("skipped: {} needs ../shared/scenes, which is absent", file.display());
            continue;
        }
        if named.is_some() {
            assert!(experiment::sweep::machine_count(&file).unwrap() > 2);
            continue;
        }
        let experiment = Experiment::load(&file, Overrides::default()).unwrap();
        assert_eq!(Some(experiment.spec.name.as_str()), file.file_stem().and_then(|name| name.to_str()));
    }
    // Scenes that no experiment names.
    for file in scenes {
        let spec: umbrasim::scene::spec::SceneSpec = umbrasim::ron_file::read(&file).unwrap();
        spec.load(file.parent().unwrap()).unwrap();
    }
}

#[test]
fn the_same_bytes_on_any_number_of_threads() {
    let [one, two] = ["1", "2"].map(quickstart);
    let [mut left, mut right] = [&one, &two].map(summary);
    for summary in [&mut left, &mut right] {
        let made = summary.as_object_mut().unwrap().remove("made").unwrap();
        assert!(made["command line"].as_str().unwrap().contains("quickstart") && made["cores"].is_string(), "{made}");
        for timing in ["wall_seconds", "simulated_rays_per_wall_second"] {
            let timings = summary.as_object_mut().unwrap().remove(timing).unwrap();
            assert!(timings.as_object().unwrap().values().all(|time| time.as_f64().unwrap() > 0.0), "{timings}");
        }
    }
    assert_eq!(serde_json::to_string(&left).unwrap(), serde_json::to_string(&right).unwrap());
    let [left, right] = [&one, &two].map(report);
    let names = |files: &BTreeMap<PathBuf, Vec<u8>>| files.keys().cloned().collect::<Vec<_>>();
    assert_eq!(names(&left), names(&right));
    let mut pictures = 0;
    for (name, bytes) in &left {
        // The page shows wall times and holds the summary's numbers.
        if name == Path::new("summary.json") || name == Path::new("index.html") {
            continue;
        }
        assert!(*bytes == right[name], "{}", name.display());
        pictures += usize::from(name.extension().is_some_and(|kind| kind == "png" || kind == "svg"));
    }
    assert!(pictures >= 8, "{:?}", names(&left));
    assert!(left.contains_key(Path::new("frames.csv")) && left.contains_key(Path::new("config.ron")));
    stable_names(&summary(&one));
    redrawn(&one);
}

/// The names of `summary.json` that other tools read.
fn stable_names(summary: &Value) {
    let has = |value: &Value, names: &str| {
        for name in names.split(' ') {
            assert!(value.get(name).is_some(), "`{name}` is missing in {value}");
        }
    };
    let object = |value: &Value| value.as_object().unwrap().clone();
    has(summary, "schema scene frames resolution policies machines wall_seconds");
    has(&summary["scene"], "name triangles_static triangles_dynamic lights");
    assert_eq!(summary["frames"], serde_json::json!([0, 1, 2, 3]));
    assert_eq!(object(&summary["policies"]).keys().collect::<Vec<_>>(), ["Off", "Published"]);
    let counts = "primary_rays shadow_rays shadow_rays_skipped shadow_rays_dynamic_only occlusion_tests_per_pixel \
                  shadow_node_visits shadow_triangle_tests traversal_saved intersection_saved false_dark false_lit \
                  numeric_differences";
    for (name, policy) in object(&summary["policies"]) {
        has(&policy, counts);
        for saved in ["traversal_saved", "intersection_saved"] {
            has(&policy[saved], "mean max max_frame total");
            let off = name == "Off";
            assert_eq!(policy[saved]["total"] == 0.0, off, "{name} {saved}");
        }
        assert_eq!(policy["frames"].as_array().unwrap().len(), 4);
        for frame in policy["frames"].as_array().unwrap() {
            has(frame, "frame");
            has(frame, counts);
            assert_eq!(frame["primary_rays"], 64 * 64);
        }
        let sum: u64 = policy["frames"].as_array().unwrap().iter().map(|it| it["shadow_rays"].as_u64().unwrap()).sum();
        assert_eq!(policy["shadow_rays"], sum);
    }
    assert_eq!(object(&summary["machines"]).keys().collect::<Vec<_>>(), ["small", "desktop"]);
    for (_, machine) in object(&summary["machines"]) {
        has(&machine, "fidelity policies");
        for (_, run) in object(&machine["policies"]) {
            has(&run, "cycles rays_per_second bytes hit_rate utilization");
            has(&run, "frames milliseconds_per_frame frames_per_second energy");
            has(&run["energy"], "joules low high by");
            let frames = run["frames"].as_array().unwrap();
            assert!(frames.iter().all(|frame| frame["energy"]["joules"].as_f64().unwrap() > 0.0));
            let measured = || frames.iter().filter(|frame| frame["warmup"] == false);
            assert_eq!((frames.len(), measured().count()), (4, 3));
            for (level, classes) in object(&run["bytes"]) {
                let total: u64 = object(&classes).values().map(|bytes| bytes.as_u64().unwrap()).sum();
                let sum: u64 = measured().map(|frame| frame["bytes"][&level].as_u64().unwrap()).sum();
                assert_eq!(total, sum, "{level}");
            }
            let cycles: u64 = measured().map(|frame| frame["cycles"].as_u64().unwrap()).sum();
            assert_eq!(run["cycles"], cycles);
            assert!(run["cycles"].as_u64().unwrap() > 0 && run["rays_per_second"].as_f64().unwrap() > 0.0);
            assert!(run["bytes"]["dram"]["node"].as_u64().unwrap() > 0, "{}", run["bytes"]);
            let rates = object(&run["hit_rate"]).into_values().flat_map(|classes| object(&classes).into_values());
            let shares: Vec<_> = rates.chain(object(&run["utilization"]).into_values()).collect();
            assert!(shares.len() > 4 && shares.iter().all(|share| (0.0..=1.0).contains(&share.as_f64().unwrap())));
        }
    }
}

/// `plot` draws the same again.
fn redrawn(desk: &Desk) {
    let before = report(desk);
    let drawn = |name: &&PathBuf| name.extension().is_some_and(|kind| kind == "svg" || kind == "html");
    for name in before.keys().filter(drawn) {
        fs::remove_file(desk.path("report").join(name)).unwrap();
    }
    desk.succeed(&["plot", "report"]);
    assert!(report(desk) == before, "the plots or the page are not the same when drawn again");
}

#[test]
fn a_replay_measures_what_the_run_did() {
    let desk = Desk::with_experiment();
    desk.succeed(&["run", "tiny.ron", "--out", "report"]);
    let summary = summary(&desk);
    for policy in ["Off", "Published"] {
        desk.succeed(&["trace", "tiny.ron", "-o", "x.rays", "--policy", policy]);
        let printed = desk.succeed(&["replay", "x.rays", "--machine", "small.ron", "--json", "x.json"]);
        assert!(printed.contains(policy), "{printed}");
        let replayed = json(fs::read(desk.path("x.json")).unwrap());
        let run = &summary["machines"]["small"]["policies"][policy];
        let replayed = replayed.as_object().unwrap();
        assert!(replayed.len() > 4);
        for (name, measured) in replayed {
            assert_eq!(measured, &run[name], "{policy}: {name}");
        }
    }
}

#[test]
fn a_sampled_replay_is_the_same_on_any_number_of_threads() {
    let desk = Desk::new();
    let (stream, machine) = (Path::new(ROOT).join("traces/quickstart.rays"), config("machines/small.ron"));
    let by = |threads: &str| {
        let replay = ["replay", stream.to_str().unwrap(), "--machine", machine.to_str().unwrap(), "--json", "x.json"];
        let sampled = ["--fidelity", "Sampled(engine: Profile, rate: 0.6)", "--threads", threads];
        desk.succeed(&[&replay[..], &sampled].concat());
        json(fs::read(desk.path("x.json")).unwrap())
    };
    assert_eq!(by("1"), by("3"));
}

#[test]
fn a_sweep_goes_on_where_it_was_and_ends_with_the_same_bytes() {
    let desk = Desk::with_experiment();
    let sweep =
        r#"(experiment: "tiny.ron", vary: {"shadow_cache.layout": [Beside, Dense], "shadow_cache.count": [2]})"#;
    desk.put("sweep.ron", sweep);
    let printed = desk.succeed(&["sweep", "sweep.ron", "--out", "s"]);
    assert!(printed.contains("layout: Beside") && printed.contains("count: 2"), "{printed}");
    let is_point = |line: &str| line.starts_with("small") && line.contains("layout: Dense");
    assert!(!printed.lines().any(is_point), "the machine has it already:\n{printed}");
    let files = ["sweep.csv", "summary.json", "plots/sweep.svg", "index.html"];
    let read = || files.map(|name| fs::read(desk.path("s").join(name)).unwrap());
    let before = read();
    let lost = fs::read_dir(desk.path("s/points")).unwrap().next().unwrap().unwrap().path();
    fs::remove_file(&lost).unwrap();
    desk.succeed(&["sweep", "sweep.ron", "--out", "s"]);
    assert!(lost.exists() && read() == before);
}

#[test]
fn inspect_tells_what_the_tracer_counted() {
    let desk = Desk::with_experiment();
    desk.succeed(&["run", "tiny.ron", "--out", "report"]);
    desk.succeed(&["trace", "tiny.ron", "-o", "x.rays", "--policy", "Published"]);
    let inspected = json(desk.succeed(&["inspect", "x.rays", "--json"]));
    let traced = &summary(&desk)["policies"]["Published"]["frames"];
    let frames = inspected["frames"].as_array().unwrap();
    assert_eq!(frames.len(), 4);
    for (inspected, traced) in frames.iter().zip(traced.as_array().unwrap()) {
        for (name, total) in inspected["totals"].as_object().unwrap() {
            assert_eq!(total, &traced[name], "{name}");
        }
    }
    assert_eq!(inspected["header"]["policy"], "Published");
    let text = desk.succeed(&["inspect", "x.rays"]);
    assert!(text.contains("Published") && text.contains("16x16"), "{text}");
}

#[test]
fn validate_prints_numbers_and_can_write_a_report() {
    let desk = Desk::with_experiment();
    let text = desk.succeed(&["validate", "tiny.ron"]);
    for word in ["Off", "Published", "numeric", "wrong shadow decisions in all frames: 0 of 704"] {
        assert!(text.contains(word), "`{word}` is not in:\n{text}");
    }
    assert!(!desk.path("report").exists() && !desk.path("reports").exists());
    desk.succeed(&["validate", "tiny.ron", "--out", "report"]);
    assert!(desk.path("report/index.html").exists());
    assert_eq!(summary(&desk)["machines"], serde_json::json!({}));
}

#[test]
fn the_kitchen_runs_small() {
    if shared("bart/kitchen/aff/kitchen.aff").is_none() {
        return;
    }
    let desk = Desk::new();
    let config = config("experiments/bart_kitchen.ron");
    let size = ["--resolution", "48x48", "--frames", "0..64:16", "--out", "report"];
    desk.succeed(&[&["run", config.to_str().unwrap()], &size[..]].concat());
    let summary = summary(&desk);
    assert_eq!(summary["frames"], serde_json::json!([0, 16, 32, 48]));
    assert_eq!(summary["scene"]["triangles_static"], 103_343);
    assert_eq!(summary["policies"]["Off"]["primary_rays"], 4 * 48 * 48);
    for wrong in ["false_dark", "false_lit", "shadow_rays_skipped", "shadow_rays_dynamic_only"] {
        assert_eq!(summary["policies"]["Off"][wrong], 0, "{wrong}");
    }
    assert!(summary["policies"]["Published"]["shadow_rays_dynamic_only"].as_u64().unwrap() > 0);
}

/// Starts the program and sends it a Ctrl-C once `ready` says so.
#[cfg(target_os = "linux")]
fn interrupt(desk: &Desk, args: &[&str], ready: impl Fn() -> bool) -> std::process::Output {
    let mut program = std::process::Command::new(assert_cmd::cargo::cargo_bin("umbrasim"));
    program.args(args).current_dir(desk.path("")).stdout(Stdio::piped()).stderr(Stdio::piped());
    let child: Child = program.spawn().unwrap();
    let began = Instant::now();
    // Time of the processor for some frames, however busy the machine is.
    while !(catches_interrupts(child.id()) && ready() && ticks(child.id()) > 70) {
        assert!(began.elapsed() < Duration::from_secs(60), "the program is not ready for Ctrl-C");
        std::thread::sleep(Duration::from_millis(20));
    }
    let kill = std::process::Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap();
    assert!(kill.success());
    child.wait_with_output().unwrap()
}

/// Hundredths of a second of processor time that a process took; see proc(5).
#[cfg(target_os = "linux")]
fn ticks(process: u32) -> u64 {
    let stat = fs::read_to_string(format!("/proc/{process}/stat")).unwrap_or_default();
    let fields = stat.rsplit(')').next().unwrap_or_default().split_whitespace();
    fields.skip(11).take(2).filter_map(|field| field.parse::<u64>().ok()).sum()
}

/// Whether a process handles SIGINT, which is signal 2, by itself.
#[cfg(target_os = "linux")]
fn catches_interrupts(process: u32) -> bool {
    let status = fs::read_to_string(format!("/proc/{process}/status")).unwrap_or_default();
    let caught = status.lines().find_map(|line| line.strip_prefix("SigCgt:"));
    caught.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok()).is_some_and(|mask| mask >> 1 & 1 == 1)
}

#[test]
#[cfg(target_os = "linux")]
fn ctrl_c_ends_a_run_with_a_report_of_the_frames_done() {
    let desk = Desk::with_experiment();
    desk.put_changed("tiny.ron", EXPERIMENT, "0..4", "0..1000000");
    let output = interrupt(&desk, &["run", "tiny.ron", "--out", "report"], || true);
    let errors = common::error_text(&output);
    assert_eq!(output.status.code(), Some(1), "{:?}: {errors}", output.status);
    assert!(errors.contains("stopping after this frame"), "{errors}");
    let summary = summary(&desk);
    let frames = summary["frames"].as_array().unwrap().len();
    assert!(frames > 0 && frames < 1_000_000);
    assert_eq!(summary["policies"]["Published"]["frames"].as_array().unwrap().len(), frames);
    assert_eq!(summary["provenance"]["stopped early"], format!("{frames} of 1000000 frames"));
    assert!(summary["machines"]["small"]["policies"]["Off"]["cycles"].as_u64().unwrap() > 0);
    let page = fs::read_to_string(desk.path("report/index.html")).unwrap();
    assert!(page.contains(&format!("{frames} of 1000000 frames")));
}

#[test]
#[cfg(target_os = "linux")]
fn ctrl_c_ends_a_trace_without_a_file() {
    let desk = Desk::with_experiment();
    let before = desk.contents();
    let output = interrupt(&desk, &["trace", "tiny.ron", "-o", "x.rays", "--frames", "0..100000"], || {
        fs::read_dir(desk.path("")).unwrap().count() > before.len()
    });
    let errors = common::error_text(&output);
    assert_eq!(output.status.code(), Some(1), "{:?}: {errors}", output.status);
    assert!(errors.contains("error: stopped before all frames were traced"), "{errors}");
    assert!(desk.contents() == before, "a file was left");
}
