//! Instructions per step of a ray at each fidelity level, counted by valgrind's cachegrind: the same on any machine
//! under any load.
//!
//! `cargo bench --bench instructions` prints a table. It fails if a run costs over 5 % more than
//! `benches/instructions.csv` says. With the environment variable `UMBRASIM_BLESS` set, it rewrites the file. Without
//! valgrind it prints that it skips the measurement.

use std::error::Error;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, Stdio};

use serde::{Deserialize, Serialize};
use serde_json::Value;

/// Allowed excess of a run over the file, as a share.
const MOST_OVER: f64 = 0.05;

/// A counted run.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct Count {
    run: String,
    machine: String,
    instructions: u64,
}

/// The levels and machines of the counted replays; reading and tracing are counted too.
const REPLAYS: [(&str, &str); 6] = [
    ("Event", "small"),
    ("Event", "desktop"),
    ("Event", "tni_engine"),
    ("Cycle", "small"),
    ("Profile", "small"),
    ("Bound", "small"),
];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).to_owned()
}

/// Instructions of a program run with these arguments.
fn instructions(arguments: &[&str]) -> Result<u64, Box<dyn Error>> {
    let run = Command::new("valgrind")
        .args(["--tool=cachegrind", "--cache-sim=no", "--cachegrind-out-file=/dev/null"])
        .arg(env!("CARGO_BIN_EXE_umbrasim"))
        .args(arguments)
        .args(["--threads", "1"])
        .current_dir(root())
        .output()?;
    let told = String::from_utf8_lossy(&run.stderr);
    if !run.status.success() {
        return Err(format!("umbrasim {} fails:\n{told}", arguments.join(" ")).into());
    }
    let counted = told.lines().find_map(|line| line.split_once("I refs:").or_else(|| line.split_once("I   refs:")));
    let (_, number) = counted.ok_or_else(|| format!("valgrind tells no count:\n{told}"))?;
    Ok(number.trim().replace(',', "").parse()?)
}

/// Steps of all rays of the recorded quickstart, including the policy's accesses.
fn steps() -> Result<u64, Box<dyn Error>> {
    let inspected = Command::new(env!("CARGO_BIN_EXE_umbrasim"))
        .args(["inspect", "--json", "traces/quickstart.rays"])
        .current_dir(root())
        .output()?;
    let inspected: Value = serde_json::from_slice(&inspected.stdout)?;
    let of_steps = |name: &str| !name.contains("rays");
    let frames = inspected["frames"].as_array().ok_or("the inspection has no frames")?;
    let totals = frames.iter().filter_map(|frame| frame["totals"].as_object()).flatten();
    Ok(totals.filter(|(name, _)| of_steps(name)).filter_map(|(_, count)| count.as_u64()).sum())
}

fn counts() -> Result<Vec<Count>, Box<dyn Error>> {
    let mut counts = Vec::new();
    let mut add = |run: &str, machine: &str, arguments: &[&str]| -> Result<(), Box<dyn Error>> {
        counts.push(Count { run: run.into(), machine: machine.into(), instructions: instructions(arguments)? });
        Ok(())
    };
    add("inspect", "", &["inspect", "--json", "traces/quickstart.rays"])?;
    for (level, machine) in REPLAYS {
        let file = format!("configs/machines/{machine}.ron");
        add(level, machine, &["replay", "traces/quickstart.rays", "--machine", &file, "--fidelity", level])?;
    }
    let folder = tempfile::tempdir()?;
    let stream = folder.path().join("stream.rays");
    let stream = stream.to_str().ok_or("the temporary folder has a name that is no text")?;
    let size = ["--frames", "0..2", "--resolution", "48x48", "--policy", "Published", "-o", stream];
    add("trace", "", &[&["trace", "configs/experiments/quickstart.ron"], &size[..]].concat())?;
    Ok(counts)
}

fn main() -> Result<ExitCode, Box<dyn Error>> {
    if Command::new("valgrind").arg("--version").stdout(Stdio::null()).status().is_err() {
        println!("skipped: valgrind is absent, instructions are not counted");
        return Ok(ExitCode::SUCCESS);
    }
    let file = root().join("benches/instructions.csv");
    let counts = counts()?;
    if std::env::var_os("UMBRASIM_BLESS").is_some() {
        let mut written = csv::Writer::from_path(&file)?;
        counts.iter().try_for_each(|count| written.serialize(count))?;
        written.flush()?;
    }
    let known: Vec<Count> = csv::Reader::from_reader(fs::File::open(&file)?).deserialize().collect::<Result<_, _>>()?;
    let steps = steps()?;
    println!("{:<10} {:<12} {:>15} {:>10} {:>10}", "run", "machine", "instructions", "a step", "change");
    let mut is_over = false;
    for Count { run, machine, instructions } in &counts {
        let before = known.iter().find(|count| count.run == *run && count.machine == *machine);
        let before = before.ok_or_else(|| format!("{} has no count of {run} {machine}", file.display()))?;
        let change = *instructions as f64 / before.instructions as f64 - 1.0;
        let a_step = *instructions as f64 / steps as f64;
        println!("{run:<10} {machine:<12} {instructions:>15} {a_step:>10.0} {:>+9.1} %", 100.0 * change);
        is_over |= change > MOST_OVER;
    }
    println!("of {steps} steps in traces/quickstart.rays (`trace` records others)");
    if is_over {
        println!("a run costs over {:.0} % more than {} says", 100.0 * MOST_OVER, file.display());
    }
    Ok(ExitCode::from(u8::from(is_over)))
}
