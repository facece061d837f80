//! `check`: checks configs without a run.

use std::path::{Path, PathBuf};
use std::time::Duration;

use anyhow::{Context, Result, bail};
use clap::Args;

use super::config_path::{any_config_path, record};
use super::outcome::Outcome;
use super::print::print;
use crate::console::{note, tell, warn};
use crate::experiment::{self, Experiment, Overrides, identities, paper, pareto, run, sweep, warnings};
use crate::fields::{Root, kind_of};
use crate::output::signals;
use crate::quantity::Resolution;
use crate::report::format::{counted, exact, short};
use crate::report::paragraph;
use crate::report::run::Summary;
use crate::ron_file;

/// The longer side of the larger small picture, in pixels.
const SIDE: u32 = 64;

/// Check config files without running them: rays, memory and time
///
/// The kind of each file is found by itself, and everything that it names is read. Of an experiment, small
/// pictures are traced and replayed, which tell about how many rays the whole takes, and how long.
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
    let text = ron_file::text(file)?;
    if let Some(record) = record(file, &text) {
        return Err(record);
    }
    let Some(kind) = kind_of(&text) else {
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
            let estimate = estimate(file, &experiment).context("small pictures of the first frame")?;
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

/// Processor time of the process; `None` where the system does not report it.
fn processor_time() -> Option<Duration> {
    #[cfg(unix)]
    {
        let time = rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime);
        Duration::try_from(time).ok()
    }
    #[cfg(not(unix))]
    None
}

/// The stages of a run whose time depends on its pictures.
const STAGES: [&str; 3] = ["trace", "reference", "machines"];

/// A small picture of an experiment's first frame.
struct Small {
    pixels: f64,
    summary: Summary,
    /// Seconds of processor time of each of [`STAGES`].
    seconds: [f64; STAGES.len()],
}

impl Small {
    /// Traces, checks and replays a picture whose longer side has at most `side` pixels.
    fn of(file: &Path, whole: &Experiment, side: u32) -> Result<Self> {
        let Resolution { width, height } = whole.spec.resolution;
        let longer = width.max(height);
        let shorten = |length: u32| (length * side.min(longer)).div_ceil(longer).max(1);
        let resolution = Resolution { width: shorten(width), height: shorten(height) };
        let first = whole.frames.first().copied().unwrap_or_default();
        let frames = format!("{first}..{}", first + 1).parse().map_err(anyhow::Error::msg)?;
        let overrides =
            Overrides { frames: Some(frames), resolution: Some(resolution), warmup: Some(0), ..Overrides::default() };
        let begin = processor_time();
        let summary = run::run(&Experiment::load(file, overrides)?, true, &signals::stop_flag())?.summary;
        // Wall time gives the stages' shares; their sum is processor time, which does not depend on other programs.
        let wall = STAGES.map(|name| summary.wall_seconds.get(name).copied().unwrap_or_default());
        let all: f64 = wall.iter().sum();
        let spent = processor_time().zip(begin).map_or(all, |(end, begin)| (end - begin).as_secs_f64());
        let seconds = wall.map(|wall| wall / all.max(f64::MIN_POSITIVE) * spent);
        Ok(Self { pixels: resolution.pixels() as f64, summary, seconds })
    }
}

/// The number of rays that the experiment traces without culling, and its processor time, from small pictures of its
/// first frame.
///
/// A stage takes a fixed time, and a time per pixel of each of its frames. Two picture sizes separate the two.
fn estimate(file: &Path, whole: &Experiment) -> Result<String> {
    let (smaller, small) = (Small::of(file, whole, SIDE / 2)?, Small::of(file, whole, SIDE)?);
    if small.summary.sees_nothing() {
        warn("no ray of the camera met a surface that asks a light: is it turned away, or in a wall?");
    }
    let pixels = whole.spec.resolution.pixels() as f64;
    let off = small.summary.policies.iter().find(|(name, _)| small.summary.baseline.as_deref() == Some(*name));
    let rays = off.map_or(0, |(_, off)| off.counts.primary_rays + off.counts.secondary_rays + off.counts.shadow_rays);
    let validated = (0..whole.frames.len()).filter(|&at| whole.spec.validate.takes(at)).count();
    let frames = [whole.frames.len(), validated, whole.replayed.frames.len()];
    let stage = |at: usize| {
        let [less, more] = [&smaller, &small].map(|it| it.seconds[at]);
        let apart = small.pixels - smaller.pixels;
        let a_pixel = if apart > 0.0 { ((more - less) / apart).max(0.0) } else { more / small.pixels };
        (more - a_pixel * small.pixels).max(0.0) + a_pixel * pixels * frames[at] as f64
    };
    let seconds: f64 = (0..STAGES.len()).map(stage).sum();
    let time = humantime::format_duration(Duration::from_secs(seconds.ceil() as u64));
    Ok(format!(
        "about {} rays without culling, about {time} of processor time (from small pictures of one frame)",
        short(rays as f64 / small.pixels * pixels * whole.frames.len() as f64)
    ))
}
