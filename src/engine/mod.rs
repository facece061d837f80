//! Replays a ray stream on a machine.

mod auto;
mod bound;
mod check;
mod crossing;
mod cycle;
mod dispatch;
mod event;
mod feed;
mod fidelity;
mod functional;
mod host;
mod lines;
mod observe;
mod part_set;
mod profile;
pub mod sampling;
mod tally;
#[cfg(test)]
mod tests;
mod wheel;
mod work;

use std::io;

use self::bound::Bound;
use self::feed::{Feed, Whole};
pub use self::fidelity::{Fidelity, Sampled, Share};
pub use self::lines::LineStream;
pub use self::observe::DramObserver;
use self::profile::curves::{Curves, Heat};
use self::sampling::{Findings, Plan, Sampler};
use self::tally::Tally;
use self::work::stores_as_recorded;
use crate::machine::source::{StoreWork, StreamFault};
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
        "none of the stream's {windows} windows of {pixels} pixels is in the sample, which has 2 in {stratum}: a higher `rate` is needed"
    )]
    Sample {
        /// Windows of the stream.
        windows: u64,
        /// Pixels of a window.
        pixels: usize,
        /// Windows a stratum.
        stratum: usize,
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
        Fidelity::Functional => {
            check_stores(machine)?;
            let stats = whole(&mut functional::Functional::new(machine, header), machine, header, items, None)?;
            Ok(MachineStats { accuracy: Accuracy::Bounded, ..stats })
        }
        Fidelity::Event => whole(&mut event::Event::new(machine, header), machine, header, items, None),
        Fidelity::Cycle => whole(&mut cycle::Cycle::new(machine, header), machine, header, items, None),
        Fidelity::Sampled { target_error: Some(_), .. } | Fidelity::Auto { .. } => Err(RunError::Passes),
        Fidelity::Sampled { engine, rate, corrected, seed, .. } => {
            check_sampled(engine, rate, corrected, machine)?;
            let plan = Plan::of(rate, corrected, machine, seed);
            if plan.rate() < 1.0 {
                let sampler = Sampler::new(engine, machine, header);
                let findings = Findings::of(&sampler, &plan, sampler.pass(&plan, 0, items)?);
                check_sample(&findings, &plan)?;
                return Ok(findings.estimate(&findings.totals(machine)));
            }
            if corrected.is_some() {
                return Err(RunError::Passes);
            }
            let all = Accuracy::Estimated { cycles: 0.0, l2_bytes: 0.0, dram_bytes: 0.0, rate: 1.0, corrected: None };
            Ok(MachineStats { accuracy: all, ..run(machine, engine.whole(), header, items)? })
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

/// Rungs without cycles know one way to access stores.
fn check_stores(machine: &MachineSpec) -> Result<(), SpecError> {
    if stores_as_recorded(machine) {
        return Ok(());
    }
    let what = "`Profile` and `Functional` know `shadow_cache` with `place: Own`, `register: 0` and `frame_end: List` only: with others, \
                Event and Cycle are allowed";
    Err(SpecError::new(what))
}

/// A sample is replayed by a rung that knows the machine's way to access stores, and corrected where that makes sense.
fn check_sampled(engine: Sampled, rate: Share, corrected: Option<Share>, machine: &MachineSpec) -> Result<(), SpecError> {
    match corrected {
        Some(_) if engine == Sampled::Event => {
            Err(SpecError::new("`corrected` is by Event: with `engine: Event`, nothing is to be corrected"))
        }
        Some(corrected) if corrected > rate => {
            let what = "`corrected` is the share of windows that Event replays too: at most `rate` is allowed";
            Err(SpecError::new(what))
        }
        _ if engine == Sampled::Event => Ok(()),
        _ => check_stores(machine),
    }
}

/// A sample of nothing is refused.
fn check_sample<E>(findings: &Findings, plan: &Plan) -> Result<(), RunError<E>> {
    let windows = findings.population.strata.iter().sum();
    if findings.measured.is_empty() && windows > 0 {
        return Err(RunError::Sample { windows, pixels: plan.cut.window(), stratum: plan.stratum });
    }
    Ok(())
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
    let Fidelity::Sampled { engine, rate, seed, corrected, target_error } = fidelity else {
        return match fidelity {
            Fidelity::Auto { error } => auto::auto(machine, error, header, &mut open),
            _ => run(machine, fidelity, header, open(0)?),
        };
    };
    check_sampled(engine, rate, corrected, machine)?;
    let mut plan = Plan::of(rate, corrected, machine, seed);
    let sampler = Sampler::new(engine, machine, header);
    if plan.rate() == 1.0 && corrected.is_some() {
        // Corrections hang on what both engines find in the same windows.
        plan.draws = plan.corrected.clone();
        let mut findings = Findings::of(&sampler, &plan, sampler.pass(&plan, 0, open(0)?)?);
        check_sample(&findings, &plan)?;
        findings.correct(&run(machine, engine.whole(), header, open(0)?)?);
        return Ok(findings.estimate(&findings.totals(machine)));
    }
    match target_error {
        Some(target) => {
            let (_, stats) = sample_until(&sampler, plan, (target, 0.5), &mut open)?;
            if stats.accuracy.is_within(target.get()) {
                return Ok(stats);
            }
            match corrected {
                None => run(machine, engine.whole(), header, open(0)?),
                Some(_) => run(machine, Fidelity::Event, header, open(0)?),
            }
        }
        None => run(machine, fidelity, header, open(0)?),
    }
}

/// Samples with more and more windows, as long as the target may be reached with at most the share `most` of them.
fn sample_until<E, I: Iterator<Item = Result<Item, E>>>(
    sampler: &Sampler<'_>,
    mut plan: Plan,
    (target, most): (Share, f64),
    open: &mut impl FnMut(usize) -> Result<I, RunError<E>>,
) -> Result<(Findings, MachineStats), RunError<E>> {
    let keep = (most * plan.stratum as f64) as usize;
    let mut pass = sampler.pass(&plan, keep, open(0)?)?;
    let mut kept = std::mem::take(&mut pass.kept);
    let mut findings = Findings::of(sampler, &plan, pass);
    let mut corrected = plan.corrected.len();
    loop {
        let totals = findings.totals(sampler.machine);
        let stats = findings.estimate(&totals);
        let next = if findings.tells() {
            plan.next(&Findings::targets(&totals), corrected, sampler.engine.cost_of_event(), target.get())
        } else {
            plan.doubled(corrected)
        };
        if stats.accuracy.is_within(target.get()) || next.draws.end as f64 / next.stratum as f64 > most {
            return Ok((findings, stats));
        }
        plan = next;
        corrected += plan.corrected.len();
        let more = match kept.take(&plan.draws) {
            Some(jobs) => sampler.replay(&plan, jobs)?,
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
    let tally = replay(engine, machine, items.inspect(|item| item.iter().for_each(|item| bound.add(item))), observer)?;
    let (stats, bounds) = (tally.stats(machine), bound.bounds());
    check::bounds(&stats, &bounds).map_err(RunError::Invariant)?;
    Ok(MachineStats { bounds: Some(bounds), ..stats })
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

fn replay<E>(
    engine: &mut impl Engine,
    machine: &MachineSpec,
    items: impl Iterator<Item = Result<Item, E>>,
    observer: Option<&mut dyn DramObserver>,
) -> Result<Tally, RunError<E>> {
    let mut feed = Whole { items, spec: &machine.shadow_cache, stores: StoreWork::default() };
    let cycles = match observer {
        None => engine.run(&mut feed)?,
        Some(observer) => observe::run(engine, machine, &mut feed, observer)?,
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
