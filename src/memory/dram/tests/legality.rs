//! The timing checker finds violations, and finds none in the logs of the channels.

use proptest::prelude::*;

use super::{Awake, NAMES, num, set};
use crate::memory::dram::Dram;
use crate::memory::dram::command::{ChannelLog, Column, Command, LoggedCommand};
use crate::memory::dram::legality::violations;
use crate::memory::dram::mapping::{Field, Mapping};
use crate::memory::dram::part::DramPart;
use crate::memory::dram::spec::{DramSpec, Page};
use crate::memory::{PartId, Request};
use crate::quantity::{Bytes, LineAddr};
use crate::ranged::PowerOfTwo;
use crate::stats::TrafficClass;

/// Two groups of four banks; a line of 64 B in two bursts of 2 clocks. All parameters are `clocks`, except refreshes
/// every 5000.
fn spec(clocks: u64) -> DramSpec {
    let mut spec = DramSpec {
        part: DramPart { bank_groups: PowerOfTwo::new(2).unwrap(), burst_clocks: num(2), ..DramPart::default() },
        mapping: Mapping(vec![Field::Column(1), Field::BankGroup(1), Field::Bank(2), Field::Column(4), Field::Row]),
        ..DramSpec::default()
    };
    NAMES.iter().for_each(|name| set(&mut spec.part.timing, name, clocks));
    set(&mut spec.part.timing, "refi", 5000);
    spec
}

fn activate(bank: usize) -> Command {
    Command::Activate { bank, row: 0 }
}

fn burst(bank: usize, column: u64, auto_precharge: bool) -> Column {
    Column { bank, row: 0, column, auto_precharge }
}

fn read(bank: usize) -> Command {
    Command::Read(burst(bank, 0, false))
}

fn write(bank: usize) -> Command {
    Command::Write(burst(bank, 0, false))
}

fn precharge(bank: usize) -> Command {
    Command::Precharge { bank }
}

fn log_of(commands: impl IntoIterator<Item = (u64, Command)>) -> Vec<LoggedCommand> {
    commands.into_iter().map(|(clock, command)| LoggedCommand { clock, command }).collect()
}

/// One parameter is 50, the others 1. After the first commands, the last is legal at one clock and not earlier.
#[test]
fn every_constraint_is_tight() {
    type Case = (&'static str, Vec<(u64, Command)>, Command, u64);
    let both = |bank| vec![(1, activate(0)), (2, activate(bank))];
    let and = |mut commands: Vec<(u64, Command)>, last| {
        commands.push(last);
        commands
    };
    let cases: Vec<Case> = vec![
        ("rc", vec![(1, activate(0)), (10, precharge(0))], activate(0), 51),
        ("rrd_l", vec![(1, activate(0))], activate(1), 51),
        ("rrd_s", vec![(1, activate(0))], activate(4), 51),
        ("rp", vec![(1, activate(0)), (10, precharge(0))], activate(0), 60),
        ("rcd", vec![(1, activate(0))], read(0), 51),
        ("rcd", vec![(1, activate(0))], write(0), 51),
        ("ras", vec![(1, activate(0))], precharge(0), 51),
        ("ras", vec![(1, activate(0))], Command::PrechargeAll, 51),
        ("rtp", vec![(1, activate(0)), (5, read(0))], precharge(0), 55),
        ("ccd_l", and(both(1), (5, read(0))), read(1), 55),
        ("ccd_l", and(both(1), (5, write(0))), write(1), 55),
        ("ccd_l", and(both(1), (5, read(0))), write(1), 55),
        ("ccd_l", and(both(1), (5, write(0))), read(1), 55),
        ("ccd_s", and(both(4), (5, read(0))), read(4), 55),
        ("ccd_s", and(both(4), (5, write(0))), write(4), 55),
        ("ccd_s", and(both(4), (5, read(0))), write(4), 55),
        ("ccd_s", and(both(4), (5, write(0))), read(4), 55),
        // A write in clock 5 has its data from 6 to 8.
        ("wr", vec![(1, activate(0)), (5, write(0))], precharge(0), 58),
        ("wtr_l", and(both(1), (5, write(0))), read(1), 58),
        ("wtr_s", and(both(4), (5, write(0))), read(4), 58),
        ("rfc", vec![(5000, Command::Refresh)], activate(0), 5050),
        ("rp", vec![(1, activate(0)), (4980, precharge(0))], Command::Refresh, 5030),
        ("rc", vec![(4980, activate(0)), (4985, precharge(0))], Command::Refresh, 5030),
        ("faw", (0..4).map(|bank| (1 + 3 * bank as u64, activate(bank))).collect(), activate(4), 51),
        // The burst is read in clocks 6 to 8; the bus turns until clock 58.
        ("turn", vec![(1, activate(0)), (5, read(0))], write(0), 57),
        // The earlier burst is on the bus up to clock 8; data may begin there.
        ("bus", vec![(1, activate(0)), (5, read(0))], read(0), 7),
    ];
    for (name, commands, last, earliest) in cases {
        let mut spec = spec(1);
        if name != "bus" {
            set(&mut spec.part.timing, name, 50);
        }
        let at = |clock: u64| {
            let log = log_of(commands.iter().copied().chain([(clock, last)]));
            violations(&spec, 64, &log, clock).into_iter().map(|violation| violation.rule).collect::<Vec<_>>()
        };
        let name = if name == "turn" { "bus" } else { name };
        assert_eq!(at(earliest), [""; 0], "{name}, {last:?}");
        assert_eq!(at(earliest - 1), [name], "{name}, {last:?}");
    }
}

/// With auto-precharge the bank closes when tRAS, tRTP and tWR allow it, and can be opened tRP later.
#[test]
fn a_bank_that_closes_itself_is_tight() {
    for (name, column, earliest) in [
        ("ras", Command::Read(burst(0, 1, true)), 1 + 50 + 1),
        ("rtp", Command::Read(burst(0, 1, true)), 5 + 50 + 1),
        ("wr", Command::Write(burst(0, 1, true)), 8 + 50 + 1),
    ] {
        let mut spec = DramSpec { page: Page::Closed, ..spec(1) };
        set(&mut spec.part.timing, name, 50);
        let at = |clock| violations(&spec, 64, &log_of([(1, activate(0)), (5, column), (clock, activate(0))]), clock);
        assert_eq!(at(earliest), [], "{name}");
        assert_eq!(at(earliest - 1)[0].rule, "rp", "{name}");
    }
}

#[test]
fn commands_that_the_rows_do_not_allow_are_found() {
    let cases: [&[(u64, Command)]; 8] = [
        &[(1, read(0))],
        &[(1, activate(0)), (9, activate(0))],
        &[(1, activate(0)), (9, Command::Read(Column { row: 1, ..burst(0, 0, false) }))],
        &[(1, activate(0)), (9, Command::Read(burst(0, 64, false)))],
        // The page policy requires that the row stay open.
        &[(1, activate(0)), (9, Command::Read(burst(0, 1, true)))],
        &[(1, precharge(0))],
        &[(1, Command::Refresh)],
        &[(4999, activate(0)), (5001, Command::Refresh)],
    ];
    for case in cases {
        assert_eq!(violations(&spec(1), 64, &log_of(case.iter().copied()), 10)[0].rule, "state", "{case:?}");
    }
    let closed = DramSpec { page: Page::Closed, ..spec(1) };
    let stays = log_of([(1, activate(0)), (9, Command::Read(burst(0, 1, false)))]);
    assert_eq!(violations(&closed, 64, &stays, 10)[0].rule, "state");
    let twice = log_of([1, 1].map(|clock| (clock, activate(clock as usize))));
    assert_eq!(violations(&spec(1), 64, &twice, 10)[0].rule, "command");
}

/// The log of a channel that gets random reads and writes as fast as it accepts them.
fn log(spec: &DramSpec, clocks: u64) -> Vec<LoggedCommand> {
    let mut dram = Dram::new(spec, spec.part.clock_mhz.get(), 64, PartId(0));
    dram.logs().into_iter().for_each(ChannelLog::keep);
    let mut number = 1u64;
    let mut next = || {
        number = number.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        // Three rows, eight banks, 32 columns.
        let line = LineAddr((number >> 33) % 768);
        let write = number >> 60 < 6;
        Request { line, class: TrafficClass::Node, write, bytes: Bytes(64), from: PartId(1), attributed: false }
    };
    let mut request = next();
    for now in 0..clocks {
        // Phases of requests, then silence in which all requests complete.
        if now % 2000 < 1200 && dram.put(request, now, &mut Awake) {
            request = next();
        }
        dram.tick(0, now, &mut Awake, |_, _| {});
    }
    dram.logs()[0].commands().to_vec()
}

#[test]
fn a_constraint_that_is_a_clock_short_is_caught() {
    for page in [Page::Open, Page::Closed] {
        for name in NAMES {
            let mut right = spec(if name == "rc" { 9 } else { 6 });
            right.page = page;
            set(&mut right.part.timing, "rc", 18);
            let clocks = if name == "rfc" { 100 } else { 40 };
            set(&mut right.part.timing, name, clocks);
            if let Some(name) = name.strip_suffix("_s") {
                set(&mut right.part.timing, &format!("{name}_l"), clocks + 2);
            }
            let mut wrong = right.clone();
            set(&mut wrong.part.timing, name, clocks - 1);
            assert_eq!(violations(&right, 64, &log(&right, 40_000), 40_000), [], "{name}");
            let found = violations(&right, 64, &log(&wrong, 40_000), 40_000);
            // A wrong latency shows in the bus rule and in the rules that count from the end of data.
            let expected: &[&str] = match name {
                "cl" | "turn" => &["bus"],
                "cwl" => &["wtr_s", "wtr_l", "wr", "bus", "rp"],
                // A bank that closes itself too early can also be opened too early.
                "ras" | "rtp" | "wr" if page == Page::Closed => &[name, "rp"],
                _ => &[name],
            };
            assert!(found.iter().any(|violation| expected.contains(&violation.rule)), "{page:?}, {name}: {found:?}");
        }
    }
    let (right, mut wrong) = (spec(6), spec(6));
    wrong.part.burst_clocks = num(1);
    set(&mut wrong.part.timing, "ccd_s", 1);
    assert!(violations(&right, 64, &log(&wrong, 9000), 9000).iter().any(|found| found.rule == "bus"));
}

#[test]
fn a_missing_early_or_late_refresh_is_caught() {
    let spec = spec(6);
    let right = log(&spec, 40_000);
    let refreshes: Vec<_> = (0..right.len()).filter(|&at| right[at].command == Command::Refresh).collect();
    assert_eq!(refreshes.len(), 7);
    for at in refreshes {
        let mut without = right.clone();
        without.remove(at);
        assert!(violations(&spec, 64, &without, 40_000).iter().any(|found| found.rule == "refi"));
    }
    // An idle channel gives nothing but refreshes; an empty log misses them.
    assert_eq!(violations(&spec, 64, &[], 5100)[0].rule, "refi");
    for (refi, rule) in [(4999, "state"), (5001, "refi")] {
        let mut wrong = spec.clone();
        set(&mut wrong.part.timing, "refi", refi);
        let found = violations(&spec, 64, &log(&wrong, 400_000), 400_000);
        assert!(found.iter().any(|found| found.rule == rule), "{refi}: {found:?}");
    }
}

proptest! {
    /// For all timing parameters, the channel's commands are legal.
    #[test]
    fn channels_keep_the_rules(clocks in prop::collection::vec(1..40u64, NAMES.len()), closed in any::<bool>()) {
        let mut spec = spec(1);
        spec.page = if closed { Page::Closed } else { Page::Open };
        NAMES.iter().zip(&clocks).for_each(|(name, &clocks)| set(&mut spec.part.timing, name, clocks));
        set(&mut spec.part.timing, "rc", clocks[3] + clocks[4] + clocks[5] / 4);
        for (short, long) in [(6, 7), (8, 9), (13, 14)] {
            set(&mut spec.part.timing, NAMES[long], clocks[short] + clocks[long]);
        }
        set(&mut spec.part.timing, "ccd_s", clocks[6].max(2));
        spec.check(64).unwrap();
        prop_assert_eq!(violations(&spec, 64, &log(&spec, 12_000), 12_000), []);
    }
}
