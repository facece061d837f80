//! Checks a log of DRAM commands against the timing of its spec, by a table of its own: for tests of both engines.

use super::command::{Command, LoggedCommand};
use super::dram_timing::DramSpec;

/// What a rule is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Activate,
    Read,
    Write,
    Precharge,
    Refresh,
}

/// When an event is, of which a rule counts the clocks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Moment {
    Command,
    DataEnd,
}

/// Between `first` and `then`, in one bank or in any two of the channel, there are at least so many clocks.
#[derive(Clone, Copy, Debug)]
struct Rule {
    name: &'static str,
    first: Kind,
    from: Moment,
    then: Kind,
    same_bank: bool,
    clocks: u64,
}

fn table(spec: &DramSpec) -> Vec<Rule> {
    use Kind::{Activate, Precharge, Read, Refresh, Write};
    use Moment::{Command, DataEnd};
    let t = &spec.timing;
    [
        ("rc", Activate, Command, Activate, true, t.rc.get()),
        ("rrd", Activate, Command, Activate, false, t.rrd.get()),
        ("rp", Precharge, Command, Activate, true, t.rp.get()),
        ("rcd", Activate, Command, Read, true, t.rcd.get()),
        ("rcd", Activate, Command, Write, true, t.rcd.get()),
        ("ras", Activate, Command, Precharge, true, t.ras.get()),
        ("rtp", Read, Command, Precharge, true, t.rtp.get()),
        ("wr", Write, DataEnd, Precharge, true, t.wr.get()),
        ("wtr", Write, DataEnd, Read, false, t.wtr.get()),
        ("rfc", Refresh, Command, Activate, false, t.rfc.get()),
        ("rfc", Refresh, Command, Refresh, false, t.rfc.get()),
        ("rp", Precharge, Command, Refresh, false, t.rp.get()),
        ("rc", Activate, Command, Refresh, false, t.rc.get()),
    ]
    .map(|(name, first, from, then, same_bank, clocks)| Rule { name, first, from, then, same_bank, clocks })
    .into()
}

/// Something that is not allowed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Violation {
    /// When.
    pub cycle: u64,
    /// What was violated: a timing parameter, or `bus`, `state`, `command`.
    pub rule: &'static str,
}

#[derive(Clone, Copy, Debug)]
struct Event {
    kind: Kind,
    bank: Option<usize>,
    cycle: u64,
    data_end: u64,
}

/// Follows the commands of a channel.
struct Checker<'a> {
    spec: &'a DramSpec,
    rules: Vec<Rule>,
    machine_mhz: u64,
    /// The last event of each kind and bank.
    last: Vec<Event>,
    open: Vec<Option<u64>>,
    /// When the bus is free, in cycles times the DRAM's clock.
    bus_free: u64,
    line_clocks: u64,
    refreshes: u64,
    found: Vec<Violation>,
}

impl Checker<'_> {
    fn cycles(&self, clocks: u64) -> u64 {
        (clocks * self.machine_mhz).div_ceil(self.spec.clock_mhz.get())
    }

    fn due(&self) -> u64 {
        (self.refreshes + 1) * self.cycles(self.spec.timing.refi.get())
    }

    fn violated(&mut self, cycle: u64, rule: &'static str) {
        self.found.push(Violation { cycle, rule });
    }

    fn event(&mut self, kind: Kind, bank: Option<usize>, cycle: u64) {
        let same_bank = |event: &Event| event.bank == bank || bank.is_none();
        let broken: Vec<_> = self
            .rules
            .iter()
            .filter(|rule| rule.then == kind)
            .filter(|rule| {
                let events = self.last.iter().filter(|event| event.kind == rule.first);
                events.filter(|event| !rule.same_bank || same_bank(event)).any(|event| {
                    let from = if rule.from == Moment::DataEnd { event.data_end } else { event.cycle };
                    cycle < from || (cycle - from) * self.spec.clock_mhz.get() < rule.clocks * self.machine_mhz
                })
            })
            .map(|rule| rule.name)
            .collect();
        broken.into_iter().for_each(|rule| self.violated(cycle, rule));
        let data_end = match kind {
            Kind::Read => self.data(cycle, self.spec.timing.cl.get()),
            Kind::Write => self.data(cycle, self.spec.timing.cwl.get()),
            Kind::Activate | Kind::Precharge | Kind::Refresh => cycle,
        };
        self.last.retain(|event| event.kind != kind || event.bank != bank);
        self.last.push(Event { kind, bank, cycle, data_end });
    }

    /// Puts a line on the bus; the cycle in which it has passed.
    fn data(&mut self, cycle: u64, latency: u64) -> u64 {
        let clock = self.spec.clock_mhz.get();
        let first = cycle + self.cycles(latency);
        if self.bus_free >= (first + 1) * clock {
            self.violated(cycle, "bus");
        }
        self.bus_free = self.bus_free.max(first * clock) + self.line_clocks * self.machine_mhz;
        self.bus_free.div_ceil(clock)
    }

    fn command(&mut self, LoggedCommand { cycle, command }: LoggedCommand) {
        if cycle >= self.due() && !matches!(command, Command::PrechargeAll | Command::Refresh) {
            self.violated(cycle, "refi");
        }
        let legal_state = match command {
            Command::Activate { bank, .. } => self.open[bank].is_none(),
            Command::Read { bank, row } | Command::Write { bank, row } => self.open[bank] == Some(row),
            Command::Precharge { bank } => self.open[bank].is_some(),
            Command::PrechargeAll => self.open.iter().any(Option::is_some),
            Command::Refresh => self.open.iter().all(Option::is_none) && cycle >= self.due(),
        };
        if !legal_state {
            self.violated(cycle, "state");
        }
        match command {
            Command::Activate { bank, row } => {
                self.event(Kind::Activate, Some(bank), cycle);
                self.open[bank] = Some(row);
            }
            Command::Read { bank, .. } => self.event(Kind::Read, Some(bank), cycle),
            Command::Write { bank, .. } => self.event(Kind::Write, Some(bank), cycle),
            Command::Precharge { bank } => self.close(bank, cycle),
            Command::PrechargeAll => {
                let open: Vec<_> = (0..self.open.len()).filter(|&bank| self.open[bank].is_some()).collect();
                open.into_iter().for_each(|bank| self.close(bank, cycle));
            }
            Command::Refresh => {
                self.event(Kind::Refresh, None, cycle);
                self.refreshes += 1;
            }
        }
    }

    fn close(&mut self, bank: usize, cycle: u64) {
        self.event(Kind::Precharge, Some(bank), cycle);
        self.open[bank] = None;
    }
}

/// All violations in the log of a channel over a run of `cycles` of a machine, with lines of `line` bytes.
pub fn violations(
    spec: &DramSpec,
    machine_mhz: u64,
    line: u64,
    commands: &[LoggedCommand],
    cycles: u64,
) -> Vec<Violation> {
    let mut checker = Checker {
        spec,
        rules: table(spec),
        machine_mhz,
        last: Vec::new(),
        open: vec![None; spec.banks.size()],
        bus_free: 0,
        line_clocks: line / spec.burst_bytes.get() * spec.burst_clocks.get(),
        refreshes: 0,
        found: Vec::new(),
    };
    let mut before = None;
    for &command in commands {
        if before.is_some_and(|before| before >= command.cycle) {
            checker.violated(command.cycle, "command");
        }
        before = Some(command.cycle);
        checker.command(command);
    }
    // A refresh is late by at most the time that closing all rows takes.
    let t = &spec.timing;
    let close = [t.ras.get(), t.rtp.get(), t.cwl.get() + t.wr.get() + 2 * checker.line_clocks].into_iter().max();
    let late = checker.cycles(close.unwrap_or(0) + t.rc.get() + t.rp.get()) + 8;
    if checker.due() + late < cycles {
        checker.violated(cycles, "refi");
    }
    checker.found
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;
    use crate::memory::dram::Dram;
    use crate::memory::dram_timing::{Field, TimingSpec};
    use crate::memory::{PartId, Request, Wake};
    use crate::quantity::{Bytes, LineAddr};
    use crate::ranged::{PowerOfTwo, Within};
    use crate::stats::TrafficClass;

    const NAMES: [&str; 11] = ["cl", "cwl", "rcd", "rp", "ras", "rc", "rrd", "rtp", "wr", "wtr", "rfc"];

    /// Four banks, a line of 64 B in 4 clocks; all parameters `clocks`, but refreshes every 5000.
    fn spec(clocks: u64) -> DramSpec {
        let mut spec = DramSpec {
            banks: PowerOfTwo::new(4).unwrap(),
            burst_clocks: Within::new(2).unwrap(),
            mapping: vec![Field::Column(1), Field::Bank(2), Field::Column(4), Field::Row],
            ..DramSpec::default()
        };
        NAMES.iter().for_each(|name| set(&mut spec.timing, name, clocks));
        spec.timing.refi = Within::new(5000).unwrap();
        spec
    }

    fn set(timing: &mut TimingSpec, name: &str, clocks: u64) {
        let value = Within::new(clocks).unwrap();
        match name {
            "cl" => timing.cl = value,
            "cwl" => timing.cwl = value,
            "rcd" => timing.rcd = value,
            "rp" => timing.rp = value,
            "ras" => timing.ras = value,
            "rc" => timing.rc = Within::new(clocks).unwrap(),
            "rrd" => timing.rrd = value,
            "rtp" => timing.rtp = value,
            "wr" => timing.wr = value,
            "wtr" => timing.wtr = value,
            "rfc" => timing.rfc = Within::new(clocks).unwrap(),
            other => panic!("{other}"),
        }
    }

    fn activate(bank: usize) -> Command {
        Command::Activate { bank, row: 0 }
    }

    fn read(bank: usize) -> Command {
        Command::Read { bank, row: 0 }
    }

    fn write(bank: usize) -> Command {
        Command::Write { bank, row: 0 }
    }

    fn precharge(bank: usize) -> Command {
        Command::Precharge { bank }
    }

    /// One parameter is 50, the others 1; after the first commands the last is legal at one cycle and not before.
    #[test]
    fn every_constraint_is_tight() {
        type Case = (&'static str, Vec<(u64, Command)>, Command, u64);
        let cases: Vec<Case> = vec![
            ("rc", vec![(1, activate(0)), (10, precharge(0))], activate(0), 51),
            ("rrd", vec![(1, activate(0))], activate(1), 51),
            ("rp", vec![(1, activate(0)), (10, precharge(0))], activate(0), 60),
            ("rcd", vec![(1, activate(0))], read(0), 51),
            ("rcd", vec![(1, activate(0))], write(0), 51),
            ("ras", vec![(1, activate(0))], precharge(0), 51),
            ("ras", vec![(1, activate(0))], Command::PrechargeAll, 51),
            ("rtp", vec![(1, activate(0)), (5, read(0))], precharge(0), 55),
            // A write in cycle 5 has its data from 6 to 10.
            ("wr", vec![(1, activate(0)), (5, write(0))], precharge(0), 60),
            ("wtr", vec![(1, activate(0)), (2, activate(1)), (5, write(0))], read(1), 60),
            ("rfc", vec![(5000, Command::Refresh)], activate(0), 5050),
            ("rp", vec![(1, activate(0)), (4980, precharge(0))], Command::Refresh, 5030),
            ("rc", vec![(4980, activate(0)), (4985, precharge(0))], Command::Refresh, 5030),
            // The line in front of it is on the bus up to cycle 10; data may begin where it ends.
            ("bus", vec![(1, activate(0)), (5, read(0))], read(0), 9),
        ];
        for (name, commands, last, earliest) in cases {
            let mut spec = spec(1);
            if name != "bus" {
                set(&mut spec.timing, name, 50);
            }
            let at = |cycle: u64| {
                let commands = commands.iter().copied().chain([(cycle, last)]);
                let log: Vec<_> = commands.map(|(cycle, command)| LoggedCommand { cycle, command }).collect();
                violations(&spec, 1600, 64, &log, cycle).into_iter().map(|violation| violation.rule).collect::<Vec<_>>()
            };
            assert_eq!(at(earliest), [""; 0], "{name}, {last:?}");
            assert_eq!(at(earliest - 1), [name], "{name}, {last:?}");
        }
    }

    #[test]
    fn commands_that_the_rows_do_not_allow_are_found() {
        let cases: [&[(u64, Command)]; 6] = [
            &[(1, read(0))],
            &[(1, activate(0)), (9, activate(0))],
            &[(1, activate(0)), (9, Command::Read { bank: 0, row: 1 })],
            &[(1, precharge(0))],
            &[(1, Command::Refresh)],
            &[(4999, activate(0)), (5001, Command::Refresh)],
        ];
        for case in cases {
            let log: Vec<_> = case.iter().map(|&(cycle, command)| LoggedCommand { cycle, command }).collect();
            assert_eq!(violations(&spec(1), 1600, 64, &log, 10)[0].rule, "state", "{case:?}");
        }
        let twice = [1, 1].map(|cycle| LoggedCommand { cycle, command: activate(cycle as usize) });
        assert_eq!(violations(&spec(1), 1600, 64, &twice, 10)[0].rule, "command");
    }

    struct Awake;

    impl Wake for Awake {
        fn wake(&mut self, _: PartId, _: u64) {}
    }

    /// The log of a channel that is given reads and writes as fast as it takes them.
    fn log(spec: &DramSpec, cycles: u64) -> Vec<LoggedCommand> {
        let mut dram = Dram::new(spec, 1600, 64, PartId(0));
        dram.keep_commands();
        let mut number = 1u64;
        let mut next = || {
            number = number.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            // Three rows, four banks, 32 columns.
            let line = LineAddr((number >> 33) % 384);
            let write = number >> 60 < 6;
            Request { line, class: TrafficClass::Node, write, bytes: Bytes(64), from: PartId(1) }
        };
        let mut request = next();
        for now in 0..cycles {
            // Bursts of requests, then silence in which all is done.
            if now % 2000 < 1200 && dram.put(request, now, &mut Awake) {
                request = next();
            }
            dram.tick(0, now, &mut Awake, |_, _| {});
        }
        dram.log(0).commands().to_vec()
    }

    #[test]
    fn a_constraint_that_is_a_clock_short_is_caught() {
        for name in NAMES {
            let mut right = spec(if name == "rc" { 9 } else { 6 });
            set(&mut right.timing, "rc", 18);
            let clocks = if name == "rfc" { 100 } else { 40 };
            set(&mut right.timing, name, clocks);
            let mut wrong = right.clone();
            set(&mut wrong.timing, name, clocks - 1);
            assert_eq!(violations(&right, 1600, 64, &log(&right, 40_000), 40_000), [], "{name}");
            let found = violations(&right, 1600, 64, &log(&wrong, 40_000), 40_000);
            // How long data is under way shows in the bus and in what follows its end.
            let expected: &[&str] = match name {
                "cl" => &["bus"],
                "cwl" => &["wtr", "wr", "bus"],
                _ => &[name],
            };
            assert!(found.iter().any(|violation| expected.contains(&violation.rule)), "{name}: {found:?}");
        }
        let (right, mut wrong) = (spec(6), spec(6));
        wrong.burst_clocks = Within::new(1).unwrap();
        assert!(violations(&right, 1600, 64, &log(&wrong, 9000), 9000).iter().any(|found| found.rule == "bus"));
    }

    #[test]
    fn a_missing_refresh_is_caught() {
        let spec = spec(6);
        let log = log(&spec, 40_000);
        let refreshes: Vec<_> = (0..log.len()).filter(|&at| log[at].command == Command::Refresh).collect();
        assert_eq!(refreshes.len(), 7);
        for at in refreshes {
            let mut without = log.clone();
            without.remove(at);
            assert!(violations(&spec, 1600, 64, &without, 40_000).iter().any(|found| found.rule == "refi"));
        }
        // An idle channel gives nothing but refreshes, and must give these.
        assert_eq!(violations(&spec, 1600, 64, &[], 5100), [Violation { cycle: 5100, rule: "refi" }]);
    }

    proptest! {
        /// Whatever the clocks: what the channel does is legal.
        #[test]
        fn channels_keep_the_rules(clocks in prop::collection::vec(1..40u64, 11), clock in 200..4000u64) {
            let mut spec = spec(1);
            spec.clock_mhz = Within::new(clock).unwrap();
            NAMES.iter().zip(&clocks).for_each(|(name, &clocks)| set(&mut spec.timing, name, clocks));
            set(&mut spec.timing, "rc", clocks[3] + clocks[4] + clocks[5] / 4);
            prop_assume!(spec.check(64, 1600).is_ok());
            prop_assert_eq!(violations(&spec, 1600, 64, &log(&spec, 12_000), 12_000), []);
        }
    }
}
