//! Observed runs. An observer receives the requests and commands of the DRAM, checked against the timing of its part;
//! what the units do in each cycle; and the run's counts at intervals.

use std::io;

use super::contract::Engine;
use super::error::RunError;
use super::feed::{CycleEnd, Feed};
use super::snapshot::Snapshot;
use super::tally::Tally;
use crate::engine::source::FrameCounts;
use crate::machine::MachineSpec;
use crate::memory::dram::command::{ChannelLog, LoggedCommand, LoggedRequest};
use crate::memory::dram::legality::TimingChecker;
use crate::stats::{Cause, MachineStats};
use crate::stream::Item;

/// Watches a run. The default methods request nothing and ignore what they receive.
pub trait Observer {
    /// Whether [`Observer::request`] and [`Observer::command`] are to be called.
    fn wants_dram(&self) -> bool {
        false
    }

    /// Channel `channel` received a request. Requests are in the order of clocks, and of channels within a clock.
    ///
    /// # Errors
    /// The observer fails, which ends the run.
    fn request(&mut self, _channel: usize, _request: LoggedRequest) -> io::Result<()> {
        Ok(())
    }

    /// Channel `channel` issued a command, which is legal. Commands come in the same order as requests.
    ///
    /// # Errors
    /// See [`Observer::request`].
    fn command(&mut self, _channel: usize, _command: LoggedCommand) -> io::Result<()> {
        Ok(())
    }

    /// Number of cycles after which [`Observer::counted`] is to be called; the interval restarts with every frame.
    fn interval(&self) -> Option<u64> {
        None
    }

    /// Receives the counts of the run so far, at the end of an interval of `frame` or of the frame itself.
    ///
    /// # Errors
    /// See [`Observer::request`].
    fn counted(&mut self, _frame: u32, _stats: MachineStats) -> io::Result<()> {
        Ok(())
    }

    /// The frame of which every cycle is reported to [`Observer::cycle`].
    fn watched_frame(&self) -> Option<u32> {
        None
    }

    /// Cycle `now` of the run has passed.
    ///
    /// # Errors
    /// See [`Observer::request`].
    fn cycle(&mut self, _now: u64, _seen: &Seen<'_>) -> io::Result<()> {
        Ok(())
    }
}

/// The state of a machine's parts in a cycle, in the order of [`super::Places`].
#[derive(Clone, Copy, Debug)]
pub struct Seen<'a> {
    /// The cause of each unit's cycle.
    pub units: &'a [Cause],
    /// Number of entries of each queue at the cycle's end.
    pub queues: &'a [u32],
    /// Number of misses under way in each cache at the cycle's end.
    pub misses: &'a [u32],
}

/// Runs `engine` on `feed`, a stream of `frames`, and reports to `observer`. Returns the number of cycles.
pub(super) fn run(
    engine: &mut dyn Engine,
    machine: &MachineSpec,
    frames: &[u32],
    feed: &mut dyn Feed,
    observer: &mut dyn Observer,
) -> Result<u64, RunError> {
    let wants_dram = observer.wants_dram();
    if wants_dram {
        engine.logs().into_iter().for_each(ChannelLog::keep);
    }
    let checker = TimingChecker::new(&machine.dram, machine.line_bytes.get());
    let mut observed = Observed {
        feed,
        machine,
        frames,
        checkers: vec![checker; machine.dram.channels.size()],
        observer,
        wants_dram,
        requests: Vec::new(),
        commands: Vec::new(),
        counted_to: 0,
        looked_to: 0,
        before: engine.snapshot(0),
        causes: Vec::new(),
    };
    let cycles = engine.run(&mut observed)?;
    observed.count(&engine.tally(cycles))?;
    if wants_dram {
        let last = machine.dram.clocks(machine.clock_mhz.get()).first(cycles) - 1;
        for (channel, checker) in observed.checkers.into_iter().enumerate() {
            checker.finish(last).map_err(|violation| RunError::Illegal { channel, violation })?;
        }
    }
    Ok(cycles)
}

/// Wraps a feed, and reports to an observer.
struct Observed<'a> {
    feed: &'a mut dyn Feed,
    machine: &'a MachineSpec,
    /// Numbers of the frame that is replayed and of those after it.
    frames: &'a [u32],
    checkers: Vec<TimingChecker>,
    observer: &'a mut dyn Observer,
    wants_dram: bool,
    /// Requests and commands of one cycle, each with its channel.
    requests: Vec<(usize, LoggedRequest)>,
    commands: Vec<(usize, LoggedCommand)>,
    /// The first cycle not yet counted for the observer, and the first cycle not yet shown to it.
    counted_to: u64,
    looked_to: u64,
    /// State of the parts at the end of the cycle before `looked_to`.
    before: Snapshot,
    causes: Vec<Cause>,
}

impl Observed<'_> {
    /// The frame that is replayed. What the machine does after the last frame's end counts for the last frame.
    fn frame(&self) -> u32 {
        self.frames.first().copied().unwrap_or_default()
    }

    fn is_watched(&self) -> bool {
        self.observer.watched_frame() == Some(self.frame())
    }

    fn count(&mut self, tally: &Tally) -> Result<(), RunError> {
        if self.observer.interval().is_some() && tally.cycles > self.counted_to {
            self.counted_to = tally.cycles;
            let stats = tally.stats(self.machine);
            self.observer.counted(self.frame(), stats).map_err(RunError::Observer)?;
        }
        Ok(())
    }

    /// The last cycle of the current interval.
    fn interval_end(&self) -> Option<u64> {
        self.observer.interval().map(|interval| self.counted_to.saturating_add(interval.max(1) - 1))
    }

    fn show(&mut self, now: u64, seen: Snapshot) -> Result<(), RunError> {
        seen.causes_since(&self.before, &mut self.causes).map_err(RunError::Invariant)?;
        let Snapshot { queues, misses, .. } = &seen;
        let seen_now = Seen { units: &self.causes, queues, misses };
        self.observer.cycle(now, &seen_now).map_err(RunError::Observer)?;
        (self.before, self.looked_to) = (seen, now + 1);
        Ok(())
    }
}

impl Feed for Observed<'_> {
    fn next(&mut self) -> Result<Option<Item>, RunError> {
        self.feed.next()
    }

    fn frame_over(&mut self, counts: &FrameCounts) -> Result<(), RunError> {
        self.feed.frame_over(counts)
    }

    fn wants_frame(&self) -> bool {
        self.feed.wants_frame()
    }

    fn frame_counted(&mut self, tally: &Tally) -> Result<(), RunError> {
        self.feed.frame_counted(tally)?;
        if let [_, others @ ..] = self.frames
            && !others.is_empty()
        {
            self.count(tally)?;
            self.counted_to = tally.cycles;
            (self.frames, self.looked_to, self.before) = (others, tally.cycles, Snapshot::of(tally));
        }
        Ok(())
    }

    fn hears(&self) -> bool {
        self.wants_dram
    }

    fn heard(&mut self, logs: &mut [&mut ChannelLog]) -> Result<(), RunError> {
        for (channel, log) in logs.iter_mut().enumerate() {
            let (requests, commands) = log.drain();
            self.requests.extend(requests.map(|request| (channel, request)));
            self.commands.extend(commands.map(|command| (channel, command)));
        }
        // A cycle can have several DRAM clocks.
        self.requests.sort_by_key(|(_, request)| request.clock);
        self.commands.sort_by_key(|(_, command)| command.clock);
        for (channel, request) in self.requests.drain(..) {
            self.observer.request(channel, request).map_err(RunError::Observer)?;
        }
        for (channel, command) in self.commands.drain(..) {
            self.checkers[channel].check(command).map_err(|violation| RunError::Illegal { channel, violation })?;
            self.observer.command(channel, command).map_err(RunError::Observer)?;
        }
        Ok(())
    }

    fn looks(&self) -> bool {
        self.observer.interval().is_some() || self.observer.watched_frame().is_some()
    }

    fn look_at(&self) -> u64 {
        let watched = self.is_watched().then_some(self.looked_to);
        watched.into_iter().chain(self.interval_end()).min().unwrap_or(u64::MAX)
    }

    fn looked(&mut self, now: u64, end: CycleEnd<'_>) -> Result<(), RunError> {
        if self.is_watched() {
            self.show(now, (end.snapshot)())?;
        }
        if self.interval_end() == Some(now) {
            self.count(&(end.tally)())?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::super::whole::Whole;
    use super::*;
    use crate::memory::dram::command::Command;

    struct Nobody;

    impl Observer for Nobody {
        fn wants_dram(&self) -> bool {
            true
        }
    }

    /// Issues two activates to one bank, the second 101 clocks after the first; the default part's tRC is 102.
    struct Wrong(ChannelLog);

    impl Engine for Wrong {
        fn run(&mut self, feed: &mut dyn Feed) -> Result<u64, RunError> {
            for (clock, command) in [
                (5, Command::Activate { bank: 0, row: 0 }),
                (73, Command::Precharge { bank: 0 }),
                (106, Command::Activate { bank: 0, row: 1 }),
            ] {
                self.0.give(clock, command);
                feed.heard(&mut [&mut self.0])?;
            }
            Ok(200)
        }

        fn tally(&self, _: u64) -> Tally {
            Default::default()
        }

        fn logs(&mut self) -> Vec<&mut ChannelLog> {
            vec![&mut self.0]
        }
    }

    #[test]
    fn an_illegal_command_ends_the_run_with_its_numbers() {
        let machine = MachineSpec::default();
        let mut items = std::iter::empty();
        let mut feed = Whole::new(&machine, &mut items);
        let error = run(&mut Wrong(ChannelLog::default()), &machine, &[], &mut feed, &mut Nobody).unwrap_err();
        let told = "channel 0 of the DRAM, clock 106: `rc` is violated, which allows it from clock 107 on";
        assert_eq!(error.to_string(), told);
    }
}
