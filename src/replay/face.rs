//! The replay of a stream by a machine.

use super::fidelity::{Fidelity, OnePass};
use super::together::Together;
use crate::engine::whole::whole;
use crate::engine::{self, Estimate, Exact, Level, Observer, ReuseOf, RunError, Source};
use crate::machine::{MachineSpec, SpecError};
use crate::memory::dram::spec::Model;
use crate::sampling::{self, Cut};
use crate::stats::{MachineStats, ReuseLevel};
use crate::stream::{Header, Item, StreamError};

/// A machine that fits a stream, and the fidelity level of the replay.
#[derive(Clone, Copy, Debug)]
pub struct Replay<'a, F = Fidelity> {
    machine: &'a MachineSpec,
    header: &'a Header,
    fidelity: F,
    /// How samples cut the stream.
    cut: Cut,
}

impl<'a> Replay<'a> {
    /// The replay of a stream with `header` by `machine`, at the level [`Fidelity::Event`].
    ///
    /// # Errors
    /// The machine cannot be built, or does not fit the stream.
    pub fn new(machine: &'a MachineSpec, header: &'a Header) -> Result<Self, SpecError> {
        machine.check()?;
        machine.check_stream(header)?;
        Ok(Self { machine, header, fidelity: Fidelity::Event, cut: Cut::new(machine) })
    }
}

impl<'a, F> Replay<'a, F> {
    /// The same with samples cut as `cut` says. Samples of the same frames with the same cut have the same windows, and
    /// can be compared ([`MachineStats::half_width_of_ratio`]).
    pub(crate) fn cut(self, cut: Cut) -> Self {
        Self { cut, ..self }
    }

    /// The same at another level: a [`Fidelity`], a [`OnePass`] or an [`Exact`] one.
    pub fn fidelity<G>(self, fidelity: G) -> Replay<'a, G> {
        Replay { machine: self.machine, header: self.header, fidelity, cut: self.cut }
    }

    /// Replays the stream by [`Level::Profile`] and estimates roughly the cost of each of `machines`. They may differ
    /// from this one in sizes, numbers and times.
    ///
    /// # Errors
    /// The run fails.
    pub fn estimates(&self, source: &dyn Source, machines: &[MachineSpec]) -> Result<Vec<Estimate>, RunError> {
        engine::estimates(self.machine, self.header, source, machines)
    }

    /// Replays the stream by [`Level::Profile`] and measures reuse distances. Returns the machine's statistics, and
    /// misses of caches of all sizes. A sample of lines takes another pass, which finds the hottest lines.
    ///
    /// # Errors
    /// `Profile` refuses the machine, or the run fails.
    pub fn reuse(&self, of: ReuseOf, source: &dyn Source) -> Result<(MachineStats, Vec<ReuseLevel>), RunError> {
        engine::reuse(self.machine, of, self.header, source)
    }

    /// Measures reuse distances of a sample of the lines in one frame, `items`, as if the frame were repeated.
    ///
    /// # Errors
    /// See [`Replay::reuse`].
    pub(crate) fn reuse_of_frame(
        &self,
        items: &mut dyn Iterator<Item = Result<Item, StreamError>>,
    ) -> Result<Vec<ReuseLevel>, RunError> {
        engine::reuse_of_frame(self.machine, self.header, items)
    }
}

impl Replay<'_, Fidelity> {
    /// Replays the stream in as many passes as the fidelity needs.
    ///
    /// # Errors
    /// The level refuses the machine, the stream cannot be read, or an invariant is violated.
    pub fn run(&self, source: &dyn Source) -> Result<MachineStats, RunError> {
        let Self { machine, header, fidelity, cut } = *self;
        match fidelity {
            Fidelity::Auto { .. } | Fidelity::Sampled { target_error: Some(_), .. } => {
                let mut verdicts = Together { header, fidelity, cut, baseline: None }.sample(&[machine], source)?;
                verdicts.pop().expect("one machine, one verdict")?.stats(machine, header, source)
            }
            Fidelity::Sampled { engine, rate, seed, target_error: None } => {
                self.fidelity(OnePass::Sampled { engine, rate, seed }).run(source.open(0)?)
            }
            Fidelity::Bound => self.whole(Level::Bound, source),
            Fidelity::Profile => self.whole(Level::Profile, source),
            Fidelity::Event => self.whole(Level::Event, source),
            Fidelity::Cycle => self.whole(Level::Cycle, source),
        }
    }

    fn whole(&self, level: Level, source: &dyn Source) -> Result<MachineStats, RunError> {
        self.fidelity(OnePass::Whole(level)).run(source.open(0)?)
    }
}

impl Replay<'_, OnePass> {
    /// Replays `items`.
    ///
    /// # Errors
    /// See [`Replay::<Fidelity>::run`](Replay#method.run).
    pub fn run(&self, items: impl IntoIterator<Item = Result<Item, StreamError>>) -> Result<MachineStats, RunError> {
        let Self { machine, header, fidelity, cut } = *self;
        let mut items = items.into_iter();
        match fidelity {
            OnePass::Whole(level) => whole(level, machine, header, &mut items, None),
            OnePass::Sampled { engine, rate, seed } => {
                sampling::sample(engine, cut, (rate, seed), machine, header, &mut items)
            }
        }
    }
}

impl<'a> Replay<'a, Exact> {
    /// The same, observed by `observer`. Every DRAM command that it receives is checked against the timing of the
    /// DRAM's part.
    ///
    /// # Errors
    /// The observer needs DRAM commands, and the DRAM's model has none.
    pub fn observe<'o>(self, observer: &'o mut dyn Observer) -> Result<Observed<'a, 'o>, SpecError> {
        if self.machine.dram.model == Model::Banks || !observer.wants_dram() {
            return Ok(Observed { replay: self, observer });
        }
        let what =
            "a DRAM with `model: Flat` has no clocks and commands that could be told: for these, Banks is allowed";
        Err(SpecError::new(what))
    }
}

/// An observed replay.
pub struct Observed<'a, 'o> {
    replay: Replay<'a, Exact>,
    observer: &'o mut dyn Observer,
}

impl Observed<'_, '_> {
    /// Replays `items`.
    ///
    /// # Errors
    /// The observer fails, a DRAM command is illegal, or another invariant is violated.
    pub fn run(self, items: impl IntoIterator<Item = Result<Item, StreamError>>) -> Result<MachineStats, RunError> {
        let Replay { machine, header, fidelity, .. } = self.replay;
        whole(fidelity.into(), machine, header, &mut items.into_iter(), Some(self.observer))
    }
}
