//! Predicts a machine of many cores from scale models with few.
//!
//! A model has `n` of the `N` cores and a share n/N of shared resources ([`MachineSpec::scale_model`]), and replays
//! one of every N/n pixels. So each of its cores has the same load and the same shared resources as a core of the
//! large machine, and the model takes about as many cycles; its bytes count N/n times.

mod law;

use std::path::Path;

use rayon::prelude::*;

use super::progress;
use crate::machine::kinds::Kind;
use crate::machine::{MachineSpec, SpecError};
use crate::replay::{Fidelity, Replay, RunError, StreamFile, Thinned, energy_by_model};
use crate::report::extrapolate::{Extrapolation, Figures, ScaleModel};
use crate::stats::MachineStats;
use crate::stream::{Header, StreamReader, Structure};

/// Units whose operations measure how much of the stream's work a model replayed.
const WORK: [Kind; 3] = [Kind::Traversal, Kind::List, Kind::Intersection];

/// The input of an extrapolation.
pub(crate) struct Task<'a> {
    /// The large machine.
    pub machine: &'a MachineSpec,
    /// Cores of its models; if empty, those of [`usual`].
    pub models: &'a [u64],
    /// The fidelity level of the models' replays.
    pub fidelity: Fidelity,
    /// Whether the large machine is replayed by `Event` too.
    pub checks: bool,
}

/// Predicts the figures of a large machine for the stream at `path`.
///
/// # Errors
/// The machine has no such models, the level cannot replay them, or a replay fails.
pub(crate) fn extrapolate(task: &Task<'_>, path: &Path) -> Result<Extrapolation, RunError> {
    let Task { machine, fidelity, checks, .. } = *task;
    check_level(fidelity)?;
    let models = models(task)?;
    let header = StreamReader::open(path)?.header().clone();
    let all = machine.cores.get();
    let bound = Job { machine, share: 1, fidelity: Fidelity::Bound };
    let truth = checks.then_some(Job { machine, share: 1, fidelity: Fidelity::Event });
    let scaled = models.iter().rev().map(|model| Job { machine: model, share: all / model.cores.get(), fidelity });
    // The longest job first.
    let jobs: Vec<Job<'_>> = truth.into_iter().chain([bound]).chain(scaled).collect();
    let bar = progress::bar("replaying", jobs.len(), "machines");
    let run = |job: &Job<'_>| job.run(&header, path).inspect(|_| bar.inc(1));
    let mut found = jobs.par_iter().map(run).collect::<Result<Vec<MachineStats>, RunError>>()?.into_iter();
    drop(bar);
    let truth = if checks { found.next() } else { None };
    let whole = found.next().expect("the bound is one of the jobs");
    let measured = models.iter().zip(found.rev());
    let scaled: Vec<ScaleModel> =
        measured.map(|(model, stats)| stands_for(model, machine, header.structure, &stats, &whole)).collect();
    Ok(summary(task, &header, scaled, &whole, truth.as_ref()))
}

/// Refuses levels that do not simulate a whole stream.
fn check_level(fidelity: Fidelity) -> Result<(), SpecError> {
    match fidelity {
        Fidelity::Profile | Fidelity::Event | Fidelity::Cycle => Ok(()),
        Fidelity::Bound | Fidelity::Sampled { .. } | Fidelity::Auto { .. } => Err(SpecError::new(format!(
            "`{fidelity}` does not replay scale models, each of which has a share of the pixels: Profile, Event and \
             Cycle do"
        ))),
    }
}

/// The models of the large machine, the smallest first.
fn models(task: &Task<'_>) -> Result<Vec<MachineSpec>, SpecError> {
    let Task { machine, models, .. } = *task;
    let all = machine.cores.get();
    let mut cores = if models.is_empty() { usual(all) } else { models.to_vec() };
    cores.sort_unstable();
    cores.dedup();
    if cores.len() < 2 || all < 3 {
        return Err(SpecError::new(format!(
            "{} of {all} cores: two models or more make a law, each with a number of cores below {all} that divides it",
            machine.name
        )));
    }
    cores.into_iter().map(|cores| machine.scale_model(cores)).collect()
}

/// Cores of the default models of a machine with `all` cores: 1 and 2 up to 4 cores; else 2 and 4, or, from 48 cores
/// on, all / 16 and twice that.
fn usual(all: u64) -> Vec<u64> {
    let few = if all <= 4 { 1 } else { (all / 16).max(2) };
    vec![few, 2 * few]
}

/// A replay.
struct Job<'a> {
    machine: &'a MachineSpec,
    /// The number of pixels that one replayed pixel represents.
    share: u64,
    fidelity: Fidelity,
}

impl Job<'_> {
    fn run(&self, header: &Header, path: &Path) -> Result<MachineStats, RunError> {
        let replay = Replay::new(self.machine, header)?.fidelity(self.fidelity);
        let file = StreamFile(path);
        replay.run(&Thinned { source: &file, share: self.share })
    }
}

/// Scales a model's figures to the `large` machine. Its pixels may have more or less work than the others, so figures
/// are scaled by the operations of the `whole` stream.
fn stands_for(
    model: &MachineSpec,
    large: &MachineSpec,
    structure: Structure,
    stats: &MachineStats,
    whole: &MachineStats,
) -> ScaleModel {
    let share = (large.cores.get() / model.cores.get()) as f64;
    let of = |stats: &MachineStats, unit: Kind| stats.operations.get(unit.names().0).copied().unwrap_or(0);
    let work = |stats: &MachineStats| WORK.iter().map(|&unit| of(stats, unit)).sum::<u64>() as f64;
    let more = if work(stats) > 0.0 { work(whole) / (work(stats) * share) } else { 1.0 };
    let figures = Figures {
        cycles: stats.cycles.0 as f64 * more,
        l2_bytes: stats.moved_l2().0 as f64 * share * more,
        dram_bytes: stats.moved("dram").0 as f64 * share * more,
    };
    let joules = energy_by_model(large, structure, stats, share * more, more).map(|energy| energy.joules);
    ScaleModel { cores: model.cores.get(), rays: stats.rays, figures, joules }
}

fn summary(
    task: &Task<'_>,
    header: &Header,
    models: Vec<ScaleModel>,
    whole: &MachineStats,
    truth: Option<&MachineStats>,
) -> Extrapolation {
    let machine = task.machine;
    let cores = machine.cores.get();
    let least = whole.bounds.unwrap_or_default();
    let frames = header.frames.len().saturating_sub(header.warmup.len()).max(1) as f64;
    let told = |figure: &dyn Fn(&ScaleModel) -> Option<f64>, least: u64| {
        let points: Option<Vec<(u64, f64)>> = models.iter().map(|model| Some((model.cores, figure(model)?))).collect();
        points.map(|points| law::predict(&points, cores, least))
    };
    let predict = |figure: fn(&Figures<f64>) -> f64, least: u64| {
        told(&|model| Some(figure(&model.figures)), least).expect("each model has all figures")
    };
    let predicted = Figures {
        cycles: predict(|of| of.cycles, least.cycles.least.0),
        l2_bytes: predict(|of| of.l2_bytes, least.l2_bytes.least.0),
        dram_bytes: predict(|of| of.dram_bytes, least.dram_bytes.least.0),
    };
    let checked = truth.map(|stats| Figures {
        cycles: stats.cycles.0,
        l2_bytes: stats.moved_l2().0,
        dram_bytes: stats.moved("dram").0,
    });
    Extrapolation {
        scene: header.scene.clone(),
        policy: header.policy.clone(),
        machine: machine.name.clone(),
        cores,
        dram: machine.dram.to_string(),
        fidelity: task.fidelity.to_string(),
        rays: whole.rays,
        rays_an_entry: whole.rays as f64 / frames / machine.pool() as f64,
        rays_per_second: whole.rays as f64 / predicted.cycles.value * machine.clock_mhz.get() as f64 * 1e6,
        joules: told(&|model| model.joules, 0),
        models,
        predicted,
        checked,
        checked_joules: truth.and_then(|stats| stats.energy.as_ref()).map(|energy| energy.joules),
    }
}
