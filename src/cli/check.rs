//! `check`: configs tried without a run.

use std::path::{Path, PathBuf};
use std::time::Duration;

use anyhow::{Context, Result, bail};
use clap::Args;

use super::config_path::any_config_path;
use super::outcome::Outcome;
use super::print::print;
use crate::console::{note, tell, warn};
use crate::experiment::{self, Experiment, Overrides, identities, paper, pareto, run, sweep, warnings};
use crate::fields::{Root, kind_of};
use crate::output::signals;
use crate::quantity::Resolution;
use crate::report::format::{counted, exact, short};
use crate::report::paragraph;
use crate::ron_file;

/// The longer side of the small picture, in pixels.
const SIDE: u32 = 48;

/// Check config files without running them: rays, memory and time
///
/// The kind of each file is found by itself, and everything that it names is read. Of an experiment, one small picture
/// is traced and replayed, which tells about how many rays the whole takes, and how long.
#[derive(Args)]
pub(super) struct Check {
    /// Configs of any kind: files, or names of shipped ones
    #[arg(required = true, value_name = "FILE")]
    files: Vec<PathBuf>,
}

impl Check {
    pub(super) fn run(self) -> Result<Outcome> {
        let mut wrong = Vec::new();
        for file in &self.files {
            match any_config_path(file).and_then(|path| check(&path)) {
                Ok(text) => print(paragraph(&format!("{}: {text}", file.display())))?,
                Err(error) => wrong.push(error),
            }
        }
        let last = wrong.pop();
        wrong.iter().for_each(|error| tell(format_args!("error: {error:#}")));
        last.map_or(Ok(Outcome::Done), Err)
    }
}

fn check(file: &Path) -> Result<String> {
    let Some(kind) = kind_of(&ron_file::text(file)?) else {
        let kinds = Root::ALL.map(Root::title).join(", ");
        bail!(
            "{}: the names at its top tell no kind of config; known are {kinds}. A first line such as \
             `#![type = \"umbrasim::Machine\"]` tells it",
            file.display()
        );
    };
    let told = match kind {
        Root::Experiment => {
            let experiment = Experiment::load(file, Overrides::default())?;
            warnings::warnings(&experiment, true).iter().for_each(warn);
            let estimate = estimate(file, &experiment).context("a small picture of the first frame")?;
            format!("{}; {estimate}", experiment.need())
        }
        Root::Machine => {
            let machine = experiment::read_machine(file)?;
            warnings::of_machine(file).iter().for_each(warn);
            let peak = machine.dram.peak_bytes_per_cycle(machine.clock_mhz.get());
            let peak = peak.map(|bytes| bytes * machine.clock_mhz.get() as f64 / 1000.0);
            let peak = peak.map_or("any".into(), |peak| format!("up to {peak:.1} GB/s"));
            let megabytes = machine.footprint().div_ceil(1_000_000);
            format!("`{}`, {peak} of DRAM traffic; about {megabytes} MB of memory", machine.name)
        }
        Root::Scene => {
            let (_, scene) = experiment::read_scene(file)?;
            scene.origin.notices.iter().for_each(|notice| note(format!("note: {notice}")));
            format!(
                "`{}`, {} static and {} dynamic triangles, {}, {}",
                scene.name,
                exact(scene.statics.len() as u64),
                exact(scene.dynamic_count as u64),
                counted(scene.light_count, "light"),
                counted(scene.frame_count as usize, "frame"),
            )
        }
        Root::Sweep => {
            let machines = counted(sweep::machine_count(file)?, "machine");
            let budget = sweep::budget(file)?.map(|replays| format!(" of a space, {}", counted(replays, "replay")));
            machines + &budget.unwrap_or_default()
        }
        Root::Pareto => counted(pareto::Comparison::load(file, None)?.replays(), "replay"),
        Root::Identities => counted(identities::Table::load(file, &[])?.rows(), "row"),
        Root::PaperTable => counted(paper::Table::load(file)?.readings(), "reading"),
        Root::Dram => {
            let part = experiment::read_dram_part(file)?;
            format!("`{}`, {} MHz", part.name, part.clock_mhz)
        }
    };
    Ok(format!("{}; {told}", kind.title()))
}

/// Processor time that the process has taken; none where the system does not tell it.
fn processor_time() -> Option<Duration> {
    #[cfg(unix)]
    {
        let time = rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime);
        Duration::try_from(time).ok()
    }
    #[cfg(not(unix))]
    None
}

/// How many rays the experiment traces without culling, and how long it takes, from a small picture of its first frame.
fn estimate(file: &Path, whole: &Experiment) -> Result<String> {
    let Resolution { width, height } = whole.spec.resolution;
    let longer = width.max(height);
    let side = |side: u32| (side * SIDE.min(longer)).div_ceil(longer).max(1);
    let resolution = Resolution { width: side(width), height: side(height) };
    let first = whole.frames.first().copied().unwrap_or_default();
    let frames = format!("{first}..{}", first + 1).parse().map_err(anyhow::Error::msg)?;
    let small =
        Overrides { frames: Some(frames), resolution: Some(resolution), warmup: Some(0), ..Overrides::default() };
    let begin = processor_time();
    let small = run::run(&Experiment::load(file, small)?, true, &signals::stop_flag())?.summary;
    if small.sees_nothing() {
        warn("no ray of the camera met a surface that asks a light: is it turned away, or in a wall?");
    }
    let pixels = whole.spec.resolution.pixels() as f64 / resolution.pixels() as f64;
    let off = small.policies.iter().find(|(name, _)| small.baseline.as_deref() == Some(*name));
    let rays = off.map_or(0, |(_, off)| off.counts.primary_rays + off.counts.secondary_rays + off.counts.shadow_rays);
    let frames = whole.frames.len() as f64;
    // Stages take time with the pixels of the frames that they are made for. Their shares are those of wall time, and
    // the whole is processor time, which other programs leave alone.
    let wall = |name: &str| small.wall_seconds.get(name).copied().unwrap_or_default();
    let all: f64 = ["trace", "reference", "machines"].into_iter().map(wall).sum();
    let spent = processor_time().zip(begin).map_or(all, |(end, begin)| (end - begin).as_secs_f64());
    let stage = |name: &str, frames: f64| wall(name) / all.max(f64::MIN_POSITIVE) * spent * pixels * frames;
    let validated = (0..whole.frames.len()).filter(|&at| whole.spec.validate.takes(at)).count() as f64;
    let seconds =
        stage("trace", frames) + stage("reference", validated) + stage("machines", whole.replayed.frames.len() as f64);
    let time = humantime::format_duration(Duration::from_secs(seconds.ceil() as u64));
    Ok(format!(
        "about {} rays without culling, about {time} of processor time (from one frame of {resolution})",
        short(rays as f64 * pixels * frames)
    ))
}
