//! Runs an experiment: traces each frame for all policies, replays their streams on all machines, and compares
//! pictures with the reference renderer. The results make a report.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant, SystemTime};

use super::changed::changed;
use super::frame_reuse::{Failed, FrameReuses};
use super::frames::Replayed;
use super::load::Experiment;
use super::progress;
use super::replay::{Finished, Replays};
use super::split::Role;
use super::validation::{self, Validated, Words};
use crate::culling::Policy;
use crate::machine::MachineSpec;
use crate::named::Named;
use crate::reference::Reference;
use crate::replay::{RunError, are_units_idle, with_other_units};
use crate::report::ReportError;
use crate::report::run::pictures::{Image, PictureInfo};
use crate::report::run::{
    Asked, FrameResult, LightWrong, MachineRun, MachineSummary, OverTime, PolicySummary, RunFiles, SCHEMA,
    SceneSummary, Summary,
};
use crate::report::split::Split;
use crate::stats::{FrameReuse, MachineStats};
use crate::stream::{Header, Item, Step, Totals};
use crate::tracer::{LaneFrame, Tracer, WrongDecisions};

/// Why a run ended without a result.
#[derive(Debug, thiserror::Error)]
pub(crate) enum RunFailure {
    /// A machine failed.
    #[error("machine `{machine}` on the stream of `{policy}`")]
    Machine {
        /// The machine's name.
        machine: String,
        /// The policy's name.
        policy: String,
        /// What happened.
        source: Box<RunError>,
    },
    /// A stream's records do not match the tracer's counts: an error in the simulator.
    #[error("frame {frame}, policy `{policy}`: the stream holds {recorded:?}, the tracer counted {counted:?}")]
    Counts {
        /// The frame.
        frame: u32,
        /// The policy's name.
        policy: String,
        /// The counts from the records.
        recorded: Box<Totals>,
        /// The tracer's own counts.
        counted: Box<Totals>,
    },
    /// A picture of the report cannot be made: an error in the simulator.
    #[error(transparent)]
    Picture(#[from] ReportError),
    /// Stopped before the first frame was done.
    #[error("stopped before the first frame was done")]
    Stopped,
}

/// Where wall time goes.
#[derive(Clone, Copy, Debug, Default)]
struct Clock {
    trace: Duration,
    reference: Duration,
    /// Time spent waiting for machines that are slower than the tracer.
    machines: Duration,
}

/// Runs the experiment, without machines if `machines` is false. When `stop` becomes true, the run ends with the
/// current frame, and the report has the frames done.
pub(crate) fn run(experiment: &Experiment, machines: bool, stop: &AtomicBool) -> Result<RunFiles, RunFailure> {
    let begin = Instant::now();
    let scene = &experiment.scene;
    let first = scene.animation.frame(experiment.frames[0]);
    let tracer = Tracer::new(scene, &first, experiment.spec.resolution, experiment.spec.tracer);
    let reference = Reference::new(scene);
    let mut policies = experiment.policies();
    let headers = headers(experiment, &tracer, &policies);
    let mut gathered = Gathered::new(experiment);
    let mut clock = Clock::default();
    let bar = progress::bar("tracing", experiment.frames.len(), "frames");

    let none = Named::<MachineSpec>::default();
    let machines = if machines { &experiment.machines } else { &none };
    let (finished, reuse) = std::thread::scope(|scope| {
        let mut replays = Replays::default();
        let reuses = FrameReuses::start(scope, experiment, machines, &headers);
        // The policies are compared with each other.
        let fidelity = experiment.spec.fidelity.compared();
        for (_, machine) in machines.iter() {
            for (policy, header) in headers.iter().enumerate() {
                for role in roles(experiment, machine, policy) {
                    replays.start(scope, (machine, role), fidelity, policy, header.clone());
                }
            }
        }
        for (index, &number) in experiment.frames.iter().enumerate() {
            if stop.load(Ordering::Relaxed) {
                break;
            }
            let frame = scene.animation.frame(number);
            let validated = experiment.spec.validate.takes(index);
            let words = validated.then(|| latch(&policies, scene.primitive_count()));
            let replayed = experiment.replayed.contains(number);
            let mut recorded = vec![Totals::default(); policies.len()];
            let (traced, waited) = (Instant::now(), clock.machines);
            let lanes = tracer.frame(&frame, &mut policies, |policy, item| {
                count(&mut recorded[policy], &item);
                if !replayed {
                    return Ok(());
                }
                let sent = Instant::now();
                reuses.send(policy, number, &item);
                let result = replays.send(policy, &item);
                clock.machines += sent.elapsed();
                result
            });
            clock.trace += traced.elapsed() - (clock.machines - waited);
            // `finish` returns the error of a machine that has stopped.
            let Ok(lanes) = lanes else { break };
            check(experiment, number, &recorded, &lanes)?;
            let compared = Instant::now();
            let validated = words
                .map(|words| (validation::validate(experiment, &reference, &frame, tracer.offset(), &lanes), words));
            gathered.add(experiment, number, &lanes, validated);
            if replayed && !experiment.replayed.measures(number) {
                gathered.warmup.push(number);
            } else if replayed {
                gathered.measured.push(number);
                gathered.totals.iter_mut().zip(&recorded).for_each(|(all, &frame)| *all += frame);
            }
            clock.reference += compared.elapsed();
            bar.inc(1);
        }
        bar.set_message("machines");
        let waiting = Instant::now();
        let finished = (replays.finish(), reuses.finish());
        clock.machines += waiting.elapsed();
        Ok::<_, RunFailure>(finished)
    })?;
    drop(bar);
    if gathered.frames.is_empty() && finished.iter().all(|run| run.result.is_ok()) {
        return Err(RunFailure::Stopped);
    }
    gathered.report(experiment, &headers, (finished, reuse), clock, begin)
}

/// The roles in which `machine` replays the stream of policy `policy`. Where the units are idle without culling, the
/// split's baseline needs no replay of its own.
fn roles(experiment: &Experiment, machine: &MachineSpec, policy: usize) -> impl Iterator<Item = Role> {
    let split = experiment.spec.split && experiment.spec.fidelity.knows_all_placements();
    let other = match policy == experiment.off() {
        true => (!are_units_idle(machine)).then_some(Role::WithoutUnit),
        false => Some(Role::FreeWords),
    };
    std::iter::once(Role::AsItIs).chain(other.filter(|_| split))
}

fn headers(experiment: &Experiment, tracer: &Tracer<'_>, policies: &[Box<dyn Policy>]) -> Vec<Header> {
    let Replayed { frames, warmup } = &experiment.replayed;
    let inputs = experiment.inputs();
    experiment
        .policy_names()
        .zip(policies)
        .map(|(name, policy)| Header {
            warmup: warmup.clone(),
            ..tracer.header(name, policy.as_ref(), frames.clone(), &inputs)
        })
        .collect()
}

fn latch(policies: &[Box<dyn Policy>], primitives: usize) -> Vec<Words> {
    policies.iter().map(|policy| Words::latch(policy.as_ref(), primitives)).collect()
}

/// Adds the records of a stream's item to the counts.
fn count(recorded: &mut Totals, item: &Item) {
    match item {
        Item::Frame(_) => {}
        Item::Rays(chunk) => chunk.rays().for_each(|ray| recorded.count(&ray)),
        Item::End { policy, .. } => recorded.count_policy(Step::unpack_all(policy)),
    }
}

/// Compares the counts of the records with the tracer's own.
fn check(experiment: &Experiment, frame: u32, recorded: &[Totals], lanes: &[LaneFrame]) -> Result<(), RunFailure> {
    for ((policy, recorded), lane) in experiment.policy_names().zip(recorded).zip(lanes) {
        if *recorded != lane.totals {
            return Err(RunFailure::Counts {
                frame,
                policy: policy.to_owned(),
                recorded: Box::new(*recorded),
                counted: Box::new(lane.totals),
            });
        }
    }
    Ok(())
}

/// How and where the program was started.
fn made() -> Named<String> {
    let quoted = |word: String| if word.contains(char::is_whitespace) { format!("'{word}'") } else { word };
    let words = std::env::args_os().map(|word| quoted(word.to_string_lossy().into_owned()));
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let mut made: Named<String> = Named::default();
    made.insert("command line", words.collect::<Vec<_>>().join(" "));
    made.insert("date", humantime::format_rfc3339_seconds(SystemTime::now()).to_string());
    #[cfg(unix)]
    made.insert("host", rustix::system::uname().nodename().to_string_lossy().into_owned());
    made.insert("cores", cores.to_string());
    made
}

/// Rays that a machine replayed, warm-up frames included.
fn replayed_rays(stats: &MachineStats) -> u64 {
    let all = stats.frames.iter().map(|frame| frame.rays).sum();
    if stats.frames.is_empty() { stats.rays } else { all }
}

/// A policy's results in a frame by the tracer's counts, without the reference renderer.
pub(super) fn frame_result(frame: u32, lane: &LaneFrame) -> FrameResult {
    FrameResult {
        frame,
        totals: lane.totals,
        occlusion_tests: lane.occlusion_tests,
        false_dark: Some(lane.wrong.iter().map(|wrong| wrong.false_dark).sum()),
        false_lit: Some(lane.wrong.iter().map(|wrong| wrong.false_lit).sum()),
        compared_rays: None,
        numeric_differences: None,
        psnr: None,
    }
}

/// The results of the frames done.
struct Gathered {
    frames: Vec<u32>,
    /// The frames that the machines measured, and their warm-up frames.
    measured: Vec<u32>,
    warmup: Vec<u32>,
    /// By policy, the counts of the measured frames.
    totals: Vec<Totals>,
    /// By policy, then frame.
    results: Vec<Vec<FrameResult>>,
    /// By policy, then light.
    wrong: Vec<Vec<WrongDecisions>>,
    /// Pictures of the first frame that was validated.
    first: Vec<(PictureInfo, Image)>,
    /// Pictures of the validated frame with the most wrong pixels, if any is wrong.
    worst: Vec<(PictureInfo, Image)>,
    worst_wrong: u64,
}

impl Gathered {
    fn new(experiment: &Experiment) -> Self {
        let policies = experiment.spec.policies.len();
        Self {
            frames: Vec::new(),
            measured: Vec::new(),
            warmup: Vec::new(),
            totals: vec![Totals::default(); policies],
            results: vec![Vec::new(); policies],
            wrong: vec![vec![WrongDecisions::default(); experiment.scene.light_count]; policies],
            first: Vec::new(),
            worst: Vec::new(),
            worst_wrong: 0,
        }
    }

    fn add(
        &mut self,
        experiment: &Experiment,
        frame: u32,
        lanes: &[LaneFrame],
        validated: Option<(Validated, Vec<Words>)>,
    ) {
        self.frames.push(frame);
        for (policy, lane) in lanes.iter().enumerate() {
            let comparison = validated.as_ref().map(|(validated, _)| &validated.policies[policy].0);
            self.results[policy].push(FrameResult {
                compared_rays: comparison.map(|comparison| comparison.all_lights().asked),
                numeric_differences: comparison.map(|comparison| comparison.all_lights().numeric_differences),
                psnr: comparison.map(validation::psnr),
                ..frame_result(frame, lane)
            });
            for (all, here) in self.wrong[policy].iter_mut().zip(&lane.wrong) {
                all.false_dark += here.false_dark;
                all.false_lit += here.false_lit;
            }
        }
        let Some((validated, words)) = validated else { return };
        let all = validated.policies.iter().map(|(comparison, _)| comparison.all_lights());
        let wrong = all.map(|counts| counts.false_dark + counts.false_lit).sum();
        if self.first.is_empty() {
            self.first = validated.pictures(experiment, lanes, &words);
        } else if wrong > self.worst_wrong {
            self.worst = validated.pictures(experiment, lanes, &words);
            self.worst_wrong = wrong;
        }
    }

    /// What each culling policy saved and cost on `machine`.
    fn split(
        &self,
        experiment: &Experiment,
        (machine, headers): (&MachineSpec, &[Header]),
        measured: &[(usize, Role, MachineStats)],
    ) -> Named<Split> {
        let off = experiment.off();
        let of = |policy: usize, role: Role| {
            measured.iter().find(|it| (it.0, it.1) == (policy, role)).map(|(.., stats)| stats)
        };
        let removed = |plain| with_other_units(&Role::WithoutUnit.machine(machine), &headers[off], plain);
        let without = match are_units_idle(machine) {
            true => of(off, Role::AsItIs).map(removed),
            false => of(off, Role::WithoutUnit).cloned(),
        };
        let split = |policy: usize| {
            let all = [without.as_ref()?, of(policy, Role::FreeWords)?, of(policy, Role::AsItIs)?];
            Some((headers[policy].policy.clone(), Split::new(all, &self.totals[policy])))
        };
        (0..headers.len()).filter(|&policy| policy != off).filter_map(split).collect()
    }

    fn report(
        self,
        experiment: &Experiment,
        headers: &[Header],
        (finished, reuse): (Vec<Finished>, Result<Named<FrameReuse>, Failed>),
        clock: Clock,
        begin: Instant,
    ) -> Result<RunFiles, RunFailure> {
        let names: Vec<&str> = experiment.policy_names().collect();
        let mut wall_seconds = Named::default();
        let mut speeds = Named::default();
        let mut stage = |name: String, wall: Duration, rays: Option<u64>| {
            if let Some(rays) = rays.filter(|_| !wall.is_zero()) {
                speeds.insert(name.as_str(), rays as f64 / wall.as_secs_f64());
            }
            wall_seconds.insert(name, wall.as_secs_f64());
        };
        let off = &self.results[experiment.off()];
        let rays = off.iter().map(|frame| frame.totals).map(|it| it.primary_rays + it.secondary_rays + it.shadow_rays);
        stage("trace".to_owned(), clock.trace, Some(rays.sum()));
        stage("reference".to_owned(), clock.reference, None);
        stage("machines".to_owned(), clock.machines, None);

        let mut machines: Named<MachineSummary> = Named::default();
        let mut measured: BTreeMap<String, Vec<(usize, Role, MachineStats)>> = BTreeMap::new();
        let mut over_time = OverTime::new();
        for Finished { policy, machine, role, result } in finished {
            let replayed = result.map_err(|source| RunFailure::Machine {
                machine: machine.clone(),
                policy: names[policy].to_owned(),
                source: Box::new(source),
            })?;
            stage(
                format!("{machine}, {}, {}", names[policy], role.name()),
                replayed.wall,
                Some(replayed_rays(&replayed.stats)),
            );
            measured.entry(machine.clone()).or_default().push((policy, role, replayed.stats.clone()));
            if role != Role::AsItIs {
                continue;
            }
            if !replayed.over_time.is_empty() {
                over_time.insert((machine.clone(), names[policy].to_owned()), replayed.over_time);
            }
            let mut summary = machines.get(&machine).cloned().unwrap_or_else(|| MachineSummary {
                fidelity: experiment.spec.fidelity.to_string(),
                frames: self.measured.clone(),
                warmup: self.warmup.clone(),
                policies: Named::default(),
                split: Named::default(),
                reuse: None,
            });
            let totals = &self.totals[policy];
            let rays = totals.primary_rays + totals.secondary_rays + totals.shadow_rays;
            let asked = Asked { frames: self.measured.len(), rays };
            let asked = (asked.frames > 0).then_some(asked);
            summary.policies.insert(names[policy], MachineRun::new(replayed.stats, asked));
            machines.insert(machine, summary);
        }
        let failed = |Failed { machine, policy, source }| RunFailure::Machine { machine, policy, source };
        let reuse = reuse.map_err(failed)?;
        let machines: Named<MachineSummary> = machines
            .iter()
            .map(|(name, machine)| {
                let stats = measured.get(name).map_or(&[][..], Vec::as_slice);
                let spec = experiment.machines.get(name).expect("results are of the experiment's machines");
                let split = self.split(experiment, (spec, headers), stats);
                (name, MachineSummary { split, reuse: reuse.get(name).cloned(), ..machine.clone() })
            })
            .collect();
        stage("total".to_owned(), begin.elapsed(), None);

        let mut provenance: Named<String> = Named::default();
        provenance.insert("umbrasim", env!("CARGO_PKG_VERSION").to_owned());
        if let Some(commit) = option_env!("UMBRASIM_COMMIT") {
            provenance.insert("commit", commit.to_owned());
        }
        for header in headers {
            provenance.insert(format!("input hash of `{}`", header.policy), format!("{:016x}", header.input_hash));
        }
        for (number, notice) in experiment.scene.origin.notices.iter().enumerate() {
            provenance.insert(format!("note {} of the scene", number + 1), notice.clone());
        }
        if self.frames.len() < experiment.frames.len() {
            let done = format!("{} of {} frames", self.frames.len(), experiment.frames.len());
            provenance.insert("stopped early", done);
        }

        let policies = names.iter().zip(&self.results).zip(&self.wrong).map(|((&name, results), wrong)| {
            let lights = wrong.iter().enumerate().map(|(light, wrong)| LightWrong {
                light: light as u32,
                false_dark: wrong.false_dark,
                false_lit: wrong.false_lit,
            });
            (name, PolicySummary::new(results, lights.collect(), Some(off)))
        });
        let summary = Summary {
            schema: SCHEMA,
            experiment: experiment.spec.name.clone(),
            scene: SceneSummary {
                name: experiment.scene.name.clone(),
                triangles_static: experiment.scene.statics.len() as u64,
                triangles_dynamic: experiment.scene.dynamic_count as u64,
                lights: experiment.scene.light_count as u64,
            },
            policies: policies.collect(),
            frames: self.frames,
            resolution: experiment.spec.resolution,
            baseline: Some(names[experiment.off()].to_owned()),
            machines,
            pictures: Vec::new(),
            provenance,
            changed: changed(experiment),
            made: made(),
            wall_seconds,
            simulated_rays_per_wall_second: speeds,
        };
        let pictures: Vec<_> = self.first.into_iter().chain(self.worst).collect();
        Ok(RunFiles { over_time, ..RunFiles::new(summary, experiment.as_run(), &pictures)? })
    }
}
