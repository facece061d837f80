//! Shards of a sweep: whoever makes the points, the report has the same bytes.

use std::collections::BTreeSet;
use std::fs;
use std::process::Command;

use super::common::{Desk, error_text};

/// A sweep of 13 machines: 39 points.
const SWEEP: &str = "(experiment: \"tiny.ron\", frames: \"0..2\",
    vary: {\"clock_mhz\": [310, 320, 330, 340, 350, 360], \"traversal.rays\": [1, 2, 3, 5, 6, 7]})";

/// A desk with the sweep `w.ron`, which one process has made in `one`.
fn desk() -> Desk {
    let desk = Desk::with_experiment();
    desk.put("w.ron", SWEEP);
    desk.succeed(&["sweep", "w.ron", "--out", "one"]);
    desk
}

/// The files of a report, with their names.
fn report(desk: &Desk, folder: &str) -> Vec<(String, Vec<u8>)> {
    let list = fs::read_to_string(desk.path(folder).join(".report-files")).unwrap();
    let files = list.lines().skip(1).map(|file| (file.to_owned(), fs::read(desk.path(folder).join(file)).unwrap()));
    files.collect()
}

fn collect(desk: &Desk, folder: &str, others: &[&str]) {
    desk.succeed(&[&["sweep", "w.ron", "--out", folder, "--collect"], others].concat());
    assert!(report(desk, "one").iter().any(|(file, _)| file == "sweep.csv"));
    assert!(report(desk, folder) == report(desk, "one"), "{folder} differs");
}

/// Names of the points in a folder.
fn points(desk: &Desk, folder: &str) -> Vec<String> {
    let entries = fs::read_dir(desk.path(folder).join("points")).unwrap();
    let mut names: Vec<String> = entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

/// Three shards work at once in one folder. One of them is killed over and over, and one runs twice.
#[test]
fn shards_in_one_folder_that_are_killed_end_with_the_same_bytes() {
    let desk = desk();
    let shard = |number: u32| desk.spawn(&["sweep", "w.ron", "--out", "s", "--shard", &format!("{number}/3")]);
    let others = [2, 3, 3].map(shard);
    for round in 1..4 {
        let mut killed = shard(1);
        std::thread::sleep(std::time::Duration::from_millis(60 * round));
        killed.kill().unwrap();
        killed.wait().unwrap();
    }
    for mut other in others.into_iter().chain([shard(1)]) {
        assert!(other.wait().unwrap().success());
    }
    collect(&desk, "s", &[]);
    assert_eq!(points(&desk, "s"), points(&desk, "one"));
    let names = |folder: &str| fs::read_dir(desk.path(folder)).unwrap().count();
    assert_eq!((names("s/streams"), names("s/shards")), (2, 3));
}

#[test]
fn shards_in_folders_of_their_own_are_merged_and_what_is_missing_is_told() {
    let desk = desk();
    for number in 1..4 {
        let told = desk.succeed(&["sweep", "w.ron", "--out", &format!("s{number}"), "--shard", &format!("{number}/3")]);
        assert_eq!(told, format!("shard {number}/3: 13 points are in s{number}\n"));
    }
    let collected = |others: &[&str]| {
        let args = [&["sweep", "w.ron", "--out", "all", "--collect"], others].concat();
        desk.program(&args).output().unwrap()
    };
    let output = collected(&["s1", "s3"]);
    assert_eq!(output.status.code(), Some(1));
    let told = "error: 13 of 39 points are missing. To make them:\numbrasim sweep w.ron --shard 2/3 --out s1\n";
    assert_eq!(error_text(&output), told);

    // A point of another build.
    let file = desk.path("s2/points").join(&points(&desk, "s2")[0]);
    let text = fs::read_to_string(&file).unwrap();
    let build = text.lines().find(|line| line.contains("\"build\"")).unwrap();
    fs::write(&file, text.replace(build, "  \"build\": \"0123456789abcdef\",")).unwrap();
    let output = collected(&["s1", "s2", "s3"]);
    assert_eq!(output.status.code(), Some(2));
    let told = error_text(&output);
    assert!(told.contains("1 of 39 points are of build 0123456789abcdef, such as s2/points/"), "{told}");
    assert!(!desk.path("all/sweep.csv").exists());

    // The shard makes that one again.
    let output = desk.program(&["sweep", "w.ron", "--out", "s2", "--shard", "2/3"]).output().unwrap();
    let told = error_text(&output);
    assert!(told.contains("s2/points: 1 points are of another build and are made again"), "{told}");
    assert!(told.contains("shard 2/3: 13 points, 12 kept, 1 to make"), "{told}");
    collect(&desk, "all", &["s1", "s2", "s3"]);
}

#[test]
fn a_plan_lists_every_point_once_and_shards_cost_the_same() {
    let desk = desk();
    let csv = desk.succeed(&["sweep", "w.ron", "--plan", "-"]);
    desk.succeed(&["sweep", "w.ron", "--plan", "plan.jsonl"]);
    let lines = fs::read_to_string(desk.path("plan.jsonl")).unwrap();
    let listed: Vec<serde_json::Value> = lines.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert_eq!((csv.lines().count(), listed.len()), (40, 39));
    assert_eq!(csv.lines().next(), Some("index,machine,policy,role,clock_mhz,traversal.rays,identity,cost"));
    let last = listed.last().unwrap();
    assert_eq!((&last["role"], &last["fields"]["traversal.rays"]), (&"as it is".into(), &7.into()));
    let name = |point: &serde_json::Value| format!("{}.json", point["identity"].as_str().unwrap());
    let mut names: Vec<String> = listed.iter().map(name).collect();
    names.sort();
    assert_eq!(names, points(&desk, "one"));

    let costs: Vec<u64> = (1..=5)
        .map(|number| {
            let folder = format!("p{number}");
            desk.succeed(&["sweep", "w.ron", "--out", &folder, "--shard", &format!("{number}/5")]);
            let mine = points(&desk, &folder);
            let cost = |point: &serde_json::Value| point["cost"].as_u64().unwrap();
            listed.iter().filter(|point| mine.contains(&name(point))).map(cost).sum()
        })
        .collect();
    let all: u64 = listed.iter().map(|point| point["cost"].as_u64().unwrap()).sum();
    assert_eq!(costs.iter().sum::<u64>(), all);
    assert!(costs.iter().all(|cost| cost.abs_diff(all / 5) <= all / 39), "{costs:?} of {all}");
}

/// Every level replays a sweep with what was saved and paid, and its points stand beside those of other levels.
#[test]
fn a_sweep_takes_every_level() {
    let desk = Desk::with_experiment();
    let vary = "vary: {\"shadow_cache.place\": [L2], \"shadow_cache.register\": [4]}";
    desk.put("w.ron", &format!("(experiment: \"tiny.ron\", frames: \"0..3\", fidelity: Profile, {vary})"));
    let words = |level: Option<&str>| {
        let option = level.map(|level| ["--fidelity", level]);
        let option: &[&str] = option.as_ref().map_or(&[], |it| &it[..]);
        desk.succeed(&[&["sweep", "w.ron", "--out", "s"], option].concat());
        let summary = fs::read(desk.path("s/summary.json")).unwrap();
        let summary: serde_json::Value = serde_json::from_slice(&summary).unwrap();
        assert_eq!(summary["fidelity"], level.unwrap_or("Profile"));
        let points = summary["points"].as_array().unwrap();
        assert_eq!(points.len(), 3);
        points.iter().map(|point| point["words"].as_u64().unwrap()).collect::<Vec<_>>()
    };
    let profile = words(None);
    let event = words(Some("Event"));
    assert!(
        profile.iter().zip(&event).all(|(ours, theirs)| ours.abs_diff(*theirs) * 10 <= *theirs),
        "{profile:?} {event:?}"
    );
    words(Some("Auto(error: 0.1)"));
    // Baselines are told to half of the error, all others to that over the root of two.
    let target = |name: &String| {
        let text = fs::read_to_string(desk.path("s/points").join(name)).unwrap();
        let point: serde_json::Value = serde_json::from_str(&text).unwrap();
        let target = point["measured"]["stats"]["choice"]["target"].as_f64()?;
        Some((target * 10_000.0).round() as u64)
    };
    let targets: BTreeSet<u64> = points(&desk, "s").iter().filter_map(target).collect();
    assert_eq!(targets, [500, 707].into());
    assert_eq!(words(Some("Profile")), profile);
    let mut program = desk.program(&["sweep", "w.ron", "--out", "s", "--fidelity", "Cycle", "--target-error", "1%"]);
    let told = error_text(&program.output().unwrap());
    assert!(told.contains("w.ron: `Cycle` is not sampled: a target error goes with"), "{told}");
}

/// What `sbatch` does with an array, on this machine: every element at once.
const SBATCH: &str = r#"
last=$(sed -n 's/^#SBATCH --array=1-\([0-9]*\)$/\1/p' "$1")
for element in $(seq "$last"); do SLURM_ARRAY_TASK_ID=$element SLURM_CPUS_PER_TASK=1 bash "$1" & done
for job in $(jobs -p); do wait "$job" || exit 1; done
"#;

#[test]
fn emitted_scripts_run_all_shards() {
    let desk = desk();
    desk.succeed(&["sweep", "w.ron", "--out", "array", "--emit", "slurm", "w.sbatch", "--shards", "5"]);
    let run = |program: &str, args: &[&str], variable: (&str, &str)| {
        let output = Command::new(program).current_dir(desk.path("")).args(args).env(variable.0, variable.1).output();
        let output = output.unwrap();
        assert!(output.status.success(), "{}", error_text(&output));
        String::from_utf8(output.stdout).unwrap()
    };
    let told = run("bash", &["-c", SBATCH, "sbatch", "w.sbatch"], ("LC_ALL", "C"));
    assert_eq!(told.matches(" points are in ").count(), 5, "{told}");
    collect(&desk, "array", &[]);

    // HyperQueue reads options of `hq submit` from lines before the first command.
    desk.succeed(&["sweep", "w.ron", "--out", "queue", "--emit", "hq", "w.sh", "--shards", "2"]);
    let script = fs::read_to_string(desk.path("w.sh")).unwrap();
    let options: Vec<&str> = script.lines().take_while(|line| line.starts_with('#')).collect();
    for option in ["#!/bin/bash", "#HQ --array=1-2", "#HQ --cpus=1", "#HQ --name=w"] {
        assert!(options.contains(&option), "{script}");
    }
    for task in ["1", "2"] {
        run("bash", &["w.sh"], ("HQ_TASK_ID", task));
    }
    collect(&desk, "queue", &[]);

    desk.succeed(&["sweep", "w.ron", "--out", "rules", "--emit", "snakemake", "Snakefile"]);
    let rules = fs::read_to_string(desk.path("Snakefile")).unwrap();
    assert!(rules.contains("\nSHARDS = 39\n"), "{rules}");
}
