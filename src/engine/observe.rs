//! A run that somebody watches: what its DRAM is asked for and does, cycle by cycle, checked against the timing of its
//! part.

use std::io;

use super::contract::Engine;
use super::error::RunError;
use super::feed::Feed;
use super::tally::Tally;
use crate::engine::source::FrameCounts;
use crate::machine::MachineSpec;
use crate::memory::dram::command::{ChannelLog, LoggedCommand, LoggedRequest};
use crate::memory::dram::legality::TimingChecker;
use crate::stream::Item;

/// Is told what the channels of a DRAM are asked for and do: requests in the order of time, and commands too; in the
/// same clock that of the lower channel first.
pub trait DramObserver {
    /// A request came to channel `channel`.
    fn request(&mut self, channel: usize, request: LoggedRequest) -> io::Result<()>;

    /// Channel `channel` was given a command, which is legal.
    fn command(&mut self, channel: usize, command: LoggedCommand) -> io::Result<()>;
}

/// Runs `engine` on `feed` while `observer` is told; the number of cycles.
pub(super) fn run(
    engine: &mut dyn Engine,
    machine: &MachineSpec,
    feed: &mut dyn Feed,
    observer: &mut dyn DramObserver,
) -> Result<u64, RunError> {
    engine.logs().into_iter().for_each(ChannelLog::keep);
    let checker = TimingChecker::new(&machine.dram, machine.line_bytes.get());
    let checkers = vec![checker; machine.dram.channels.size()];
    let mut observed = Observed { feed, checkers, observer, requests: Vec::new(), commands: Vec::new() };
    let cycles = engine.run(&mut observed)?;
    let last = machine.dram.clocks(machine.clock_mhz.get()).first(cycles) - 1;
    for (channel, checker) in observed.checkers.into_iter().enumerate() {
        checker.finish(last).map_err(|violation| RunError::Illegal { channel, violation })?;
    }
    Ok(cycles)
}

/// A feed with an observer of the DRAM.
struct Observed<'a> {
    feed: &'a mut dyn Feed,
    checkers: Vec<TimingChecker>,
    observer: &'a mut dyn DramObserver,
    /// Of one cycle, with their channels.
    requests: Vec<(usize, LoggedRequest)>,
    commands: Vec<(usize, LoggedCommand)>,
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

    fn frame_counted(&mut self, tally: &Tally) {
        self.feed.frame_counted(tally);
    }

    fn hears(&self) -> bool {
        true
    }

    fn heard(&mut self, logs: &mut [&mut ChannelLog]) -> Result<(), RunError> {
        for (channel, log) in logs.iter_mut().enumerate() {
            let (requests, commands) = log.drain();
            self.requests.extend(requests.map(|request| (channel, request)));
            self.commands.extend(commands.map(|command| (channel, command)));
        }
        // A cycle can have several clocks.
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
}

#[cfg(test)]
mod tests {
    use super::super::whole::Whole;
    use super::*;
    use crate::memory::dram::command::Command;

    struct Nobody;

    impl DramObserver for Nobody {
        fn request(&mut self, _: usize, _: LoggedRequest) -> io::Result<()> {
            Ok(())
        }

        fn command(&mut self, _: usize, _: LoggedCommand) -> io::Result<()> {
            Ok(())
        }
    }

    /// Gives two activates of one bank, the second 101 clocks after the first; the default part's tRC is 102.
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
        let error = run(&mut Wrong(ChannelLog::default()), &machine, &mut feed, &mut Nobody).unwrap_err();
        let told = "channel 0 of the DRAM, clock 106: `rc` is violated, which allows it from clock 107 on";
        assert_eq!(error.to_string(), told);
    }
}
