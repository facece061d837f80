//! Replays a ray stream on a machine.

mod auto;
mod bound;
mod check;
mod cycle;
mod event;
mod feed;
mod fidelity;
mod frame_log;
mod gathering;
mod lines;
mod observe;
mod part_set;
mod profile;
mod retired;
pub(crate) mod sampling;
mod source;
mod tally;
#[cfg(test)]
mod tests;
mod unloaded;
mod work;

use std::io;

use self::bound::Bound;
use self::feed::{Feed, Whole};
pub use self::fidelity::{Fidelity, Sampled, Share};
pub use self::lines::LineStream;
pub use self::observe::DramObserver;
use self::profile::curves::{Curves, Heat};
use self::sampling::{Findings, Plan, Sampler};
use self::source::StreamFault;
use self::tally::Tally;
use self::work::known_to_profile;
use crate::machine::{MachineSpec, SpecError};
use crate::memory::dram::command::ChannelLog;
use crate::memory::dram::legality::Violation;
use crate::memory::dram::spec::Model;
use crate::stats::{Accuracy, MachineStats, ReuseLevel};
use crate::stream::{Header, Item};

/// Why a run ended without a result. `E` is the error of who reads the stream.
#[derive(Debug, thiserror::Error)]
pub enum RunError<E> {
    /// The machine cannot be built.
    #[error(transparent)]
    Spec(#[from] SpecError),
    /// The stream could not be read.
    #[error(transparent)]
    Source(E),
    /// The stream is wrong.
    #[error(transparent)]
    Stream(#[from] StreamFault),
    /// The machine replayed something else than the tracer recorded.
    #[error("frame {frame}: the machine replayed {machine} {what}, the tracer counted {tracer}")]
    Counts {
        /// The frame.
        frame: u32,
        /// What was counted.
        what: &'static str,
        /// The machine's count.
        machine: u64,
        /// The tracer's.
        tracer: u64,
    },
    /// An identity that holds for every run was violated: an error in the simulator.
    #[error("the run contradicts itself: {0}")]
    Invariant(String),
    /// The DRAM was given a command that its part forbids: an error in the simulator.
    #[error("channel {channel} of the DRAM, {violation}")]
    Illegal {
        /// The channel.
        channel: usize,
        /// What was violated.
        violation: Violation,
    },
    /// Whoever watches the run has failed.
    #[error(transparent)]
    Observer(io::Error),
    /// The fidelity takes several passes over a stream, and this one can be read once.
    #[error("a target error takes several passes over the stream, which can be read only once here")]
    Passes,
    /// No window was drawn.
    #[error(
        "none of the stream's {windows} windows of {pixels} pixels is in the sample of {rate} of them: a higher `rate` is needed"
    )]
    Sample {
        /// Windows of the stream.
        windows: usize,
        /// Pixels of a window.
        pixels: usize,
        /// The share that was asked for.
        rate: f64,
    },
    /// Nothing moves.
    #[error("nothing has moved up to cycle {cycle}:\n{queues}")]
    Deadlock {
        /// When it was noticed.
        cycle: u64,
        /// All queues.
        queues: String,
    },
}

impl RunError<std::convert::Infallible> {
    /// The error of a run whose items could not fail to be read.
    fn of_any_source<E>(self) -> RunError<E> {
        match self {
            RunError::Source(never) => match never {},
            RunError::Spec(error) => RunError::Spec(error),
            RunError::Stream(fault) => RunError::Stream(fault),
            RunError::Counts { frame, what, machine, tracer } => RunError::Counts { frame, what, machine, tracer },
            RunError::Invariant(what) => RunError::Invariant(what),
            RunError::Illegal { channel, violation } => RunError::Illegal { channel, violation },
            RunError::Observer(error) => RunError::Observer(error),
            RunError::Passes => RunError::Passes,
            RunError::Sample { windows, pixels, rate } => RunError::Sample { windows, pixels, rate },
            RunError::Deadlock { cycle, queues } => RunError::Deadlock { cycle, queues },
        }
    }
}

/// A way of replaying a stream.
trait Engine {
    /// Replays all items of `feed`; the number of cycles that it took.
    fn run<E>(&mut self, feed: &mut impl Feed<E>) -> Result<u64, RunError<E>>;

    /// What was counted in a run of `cycles`.
    fn tally(&self, cycles: u64) -> Tally;

    /// What each channel of the DRAM was asked for and given; none of an engine whose DRAM has no clock of its own.
    fn logs(&mut self) -> Vec<&mut ChannelLog>;
}

/// Replays `items`, a stream with the given header, on a machine. Memory is bounded: a chunk is dropped when all its rays are
/// done. The run's identities (counts as the tracer's, conservation of bytes between levels, one cause for every cycle
/// of every unit, bounds) are checked, and a violation is an error.
pub fn run<E>(
    machine: &MachineSpec,
    fidelity: Fidelity,
    header: &Header,
    items: impl Iterator<Item = Result<Item, E>>,
) -> Result<MachineStats, RunError<E>> {
    machine.check()?;
    machine.check_stream(header)?;
    match fidelity {
        Fidelity::Bound => bound::run(machine, header, items),
        Fidelity::Profile => {
            check_stores(machine)?;
            let stats = whole(&mut profile::Profile::new(machine, header), machine, header, items, None)?;
            Ok(MachineStats { accuracy: Accuracy::Bounded, ..stats })
        }
        Fidelity::Event => whole(&mut event::Event::new(machine, header), machine, header, items, None),
        Fidelity::Cycle => whole(&mut cycle::Cycle::new(machine, header), machine, header, items, None),
        Fidelity::Sampled { target_error: Some(_), .. } | Fidelity::Auto { .. } => Err(RunError::Passes),
        Fidelity::Sampled { engine, rate, seed, .. } => {
            check_sampled(engine, machine)?;
            if rate.get() == 1.0 {
                let all = Accuracy::Estimated { cycles: 0.0, l2_bytes: 0.0, dram_bytes: 0.0, rate: 1.0 };
                return Ok(MachineStats { accuracy: all, ..run(machine, engine.whole(), header, items)? });
            }
            let plan = Plan::new(rate.get(), machine, seed);
            let sampler = Sampler::new(engine, machine, header);
            let findings = Findings::of(&sampler, sampler.pass(&plan, 0, items)?);
            let windows = findings.population.windows;
            if findings.measured.is_empty() && windows > 0 {
                return Err(RunError::Sample { windows, pixels: plan.cut.window(), rate: rate.get() });
            }
            Ok(findings.estimate(machine, plan.draws.end))
        }
    }
}

/// Whose reuse is measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ReuseOf {
    /// All lines'.
    Everything,
    /// That of a share by a hash, and of so many of the hottest.
    Sample {
        /// The share.
        rate: Share,
        /// Lines that are in the sample whatever their hash.
        hot: usize,
    },
}

/// Replays a stream as [`Fidelity::Profile`] does and measures reuse distances on the way: what the machine measured, and misses of
/// caches of all sizes. `read` begins to read the stream: once, and for a sample once before that, to find the hottest lines.
pub fn reuse<E, I: Iterator<Item = Result<Item, E>>>(
    machine: &MachineSpec,
    of: ReuseOf,
    header: &Header,
    read: impl Fn() -> Result<I, E>,
) -> Result<(MachineStats, Vec<ReuseLevel>), RunError<E>> {
    machine.check()?;
    machine.check_stream(header)?;
    // Distances are those of all frames, and so are the figures beside them.
    let header = &Header { warmup: Vec::new(), ..header.clone() };
    check_stores(machine)?;
    let sample = match of {
        ReuseOf::Everything => None,
        ReuseOf::Sample { rate, hot } => {
            let mut heat = Heat::new(machine, header);
            for item in read().map_err(RunError::Source)? {
                heat.add(&item.map_err(RunError::Source)?);
            }
            Some((rate.get(), heat.hottest(hot)))
        }
    };
    let mut engine = profile::Profile::watched(machine, header, Curves::new(machine, sample));
    let stats = whole(&mut engine, machine, header, read().map_err(RunError::Source)?, None)?;
    Ok((MachineStats { accuracy: Accuracy::Bounded, ..stats }, engine.into_watch().levels()))
}

/// `Profile` knows few ways to access stores.
fn check_stores(machine: &MachineSpec) -> Result<(), SpecError> {
    if known_to_profile(machine) {
        return Ok(());
    }
    let what = "`Profile` knows `shadow_cache` with `place: Own`, `register: 0`, `frame_end: List` and `latched: Free` or `Wide` \
                only: with others, Event and Cycle are allowed";
    Err(SpecError::new(what))
}

/// A sample is replayed by a rung that knows the machine's way to access stores.
fn check_sampled(engine: Sampled, machine: &MachineSpec) -> Result<(), SpecError> {
    if engine == Sampled::Event { Ok(()) } else { check_stores(machine) }
}

/// As [`run`], of a stream that can be read more than once: `open` begins it at one of its frames, counted from 0. With a target error
/// more windows are measured, as many as it takes until the intervals of cycles and of the bytes of L2 and DRAM are within the target; where that would
/// take half of them or more, everything is replayed.
pub fn run_passes<E, I: Iterator<Item = Result<Item, E>>>(
    machine: &MachineSpec,
    fidelity: Fidelity,
    header: &Header,
    mut open: impl FnMut(usize) -> Result<I, E>,
) -> Result<MachineStats, RunError<E>> {
    machine.check()?;
    machine.check_stream(header)?;
    let mut open = |frame| open(frame).map_err(RunError::Source);
    match fidelity {
        Fidelity::Auto { error } => auto::auto(machine, error, header, &mut open),
        Fidelity::Sampled { engine, rate, seed, target_error: Some(target) } => {
            check_sampled(engine, machine)?;
            let plan = Plan::new(rate.get(), machine, seed);
            let (stats, is_enough) = sample_until(engine, machine, header, plan, (target, 0.5), &mut open)?;
            if is_enough {
                return Ok(stats);
            }
            run(machine, engine.whole(), header, open(0)?)
        }
        _ => run(machine, fidelity, header, open(0)?),
    }
}

/// Samples with more and more windows, as long as the target may be reached with at most `most` points a window; also whether it was.
fn sample_until<E, I: Iterator<Item = Result<Item, E>>>(
    engine: Sampled,
    machine: &MachineSpec,
    header: &Header,
    mut plan: Plan,
    (target, most): (Share, f64),
    open: &mut impl FnMut(usize) -> Result<I, RunError<E>>,
) -> Result<(MachineStats, bool), RunError<E>> {
    let sampler = Sampler::new(engine, machine, header);
    let keep = (most * plan.strata.length) as usize;
    let mut pass = sampler.pass(&plan, keep, open(0)?)?;
    let mut kept = std::mem::take(&mut pass.kept);
    let mut findings = Findings::of(&sampler, pass);
    loop {
        let stats = findings.estimate(machine, plan.draws.end);
        let is_enough = stats.accuracy.is_within(target.get());
        let next = plan.next_draws(stats.accuracy.widest(), target.get(), keep);
        let Some(draws) = next.filter(|_| !is_enough) else { return Ok((stats, is_enough)) };
        plan.draws = plan.draws.end..draws;
        let more = match kept.take(&plan.draws) {
            Some(jobs) => sampler.replay(jobs)?,
            None => {
                let pass = sampler.pass(&plan, keep, open(0)?)?;
                kept = pass.kept;
                pass.found
            }
        };
        findings.add(more);
    }
}

/// Replays everything, within the bounds of every machine.
fn whole<E>(
    engine: &mut impl Engine,
    machine: &MachineSpec,
    header: &Header,
    items: impl Iterator<Item = Result<Item, E>>,
    observer: Option<&mut dyn DramObserver>,
) -> Result<MachineStats, RunError<E>> {
    let mut bound = Bound::new(machine, header, false);
    let items = items.inspect(|item| item.iter().for_each(|item| bound.add(item)));
    let mut feed = Whole::new(machine, items);
    let whole = fed(engine, machine, &mut feed, observer)?.stats(machine);
    let frames = feed.frames;
    check::bounds(&whole, &bound.bounds(&[])).map_err(RunError::Invariant)?;
    let measured = frames.finish(whole, header).map_err(RunError::Invariant)?;
    Ok(MachineStats { bounds: Some(bound.bounds(&header.warmup)), ..measured })
}

/// As [`run`] with `Event` or `Cycle`, while `observer` is told what the DRAM is asked for and does. Every command is checked
/// against the timing of the DRAM's part, and a violation is an error.
///
/// # Errors
/// Other rungs are refused: their requests have no clocks that a DRAM of its own could be given.
pub fn run_observed<E>(
    machine: &MachineSpec,
    fidelity: Fidelity,
    header: &Header,
    items: impl Iterator<Item = Result<Item, E>>,
    observer: &mut dyn DramObserver,
) -> Result<MachineStats, RunError<E>> {
    machine.check()?;
    machine.check_stream(header)?;
    if machine.dram.model != Model::Banks {
        let what =
            "a DRAM with `model: Flat` has no clocks and commands that could be told: for these, Banks is allowed";
        return Err(SpecError::new(what).into());
    }
    match fidelity {
        Fidelity::Event => whole(&mut event::Event::new(machine, header), machine, header, items, Some(observer)),
        Fidelity::Cycle => whole(&mut cycle::Cycle::new(machine, header), machine, header, items, Some(observer)),
        other => {
            let what = format!(
                "`{other}` has no requests and commands of a DRAM at their clocks: for these, Event and Cycle are allowed"
            );
            Err(SpecError::new(what).into())
        }
    }
}

/// Replays `items`; what the run counted, its identities checked.
#[cfg(test)]
fn replay<E>(
    engine: &mut impl Engine,
    machine: &MachineSpec,
    items: impl Iterator<Item = Result<Item, E>>,
    observer: Option<&mut dyn DramObserver>,
) -> Result<Tally, RunError<E>> {
    fed(engine, machine, &mut Whole::new(machine, items), observer)
}

/// Replays all that `feed` gives; what the run counted, its identities checked.
fn fed<E>(
    engine: &mut impl Engine,
    machine: &MachineSpec,
    feed: &mut Whole<'_, impl Iterator<Item = Result<Item, E>>>,
    observer: Option<&mut dyn DramObserver>,
) -> Result<Tally, RunError<E>> {
    let cycles = match observer {
        None => engine.run(feed)?,
        Some(observer) => observe::run(engine, machine, feed, observer)?,
    };
    let tally = Tally { stores: feed.stores, ..engine.tally(cycles) };
    check::run(&tally, machine).map_err(RunError::Invariant)?;
    Ok(tally)
}

/// Cycles in which something must begin: more than any single wait of the machine, or two that follow one another, can take.
fn patience(spec: &MachineSpec) -> u64 {
    let caches = spec.l2.caches();
    let l2 = caches.iter().map(|(_, cache)| cache.latency.get());
    let units = [
        spec.dispatcher.latency.get(),
        spec.dispatcher.shading_cycles.get(),
        spec.traversal.latency.get(),
        spec.list.latency.get(),
        spec.intersection.latency.get(),
        spec.division.latency.get(),
        spec.shadow_cache.latency.get(),
        l2.max().unwrap_or(0),
    ];
    let part = &spec.dram.part;
    let dram = match spec.dram.model {
        Model::Banks => {
            let clocks = part.timing.around_refresh(part.burst_clocks.get()) + part.timing.cl.get();
            spec.dram.clocks(spec.clock_mhz.get()).cycle_after(clocks)
        }
        Model::Flat { latency, .. } => latency.get(),
    };
    100_000 + 2 * units.iter().sum::<u64>() + 2 * dram
}
