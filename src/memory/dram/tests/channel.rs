//! The behaviour of a channel, compared with closed forms.

use super::{Awake, with};
use crate::memory::dram::Dram;
use crate::memory::dram::mapping::{Field, Mapping};
use crate::memory::dram::spec::{DramSpec, Page};
use crate::memory::{PartId, Request};
use crate::quantity::{Bytes, LineAddr};
use crate::ranged::{PowerOfTwo, PowerOfTwoSize, Within};
use crate::stats::TrafficClass;

/// A DRAM with the machine's clock, so that its parameters are in cycles; lines of 64 B, two bursts each.
fn built(spec: &DramSpec) -> Dram {
    spec.check(64).unwrap();
    Dram::new(spec, 1600, 64, PartId(0))
}

fn dram() -> Dram {
    built(&DramSpec::default())
}

/// The timing parameters in the closed forms.
struct Closed {
    cl: u64,
    cwl: u64,
    rcd: u64,
    rp: u64,
    ras: u64,
    rc: u64,
    rtp: u64,
    wr: u64,
    wtr: u64,
    refi: u64,
    rfc: u64,
}

fn timing(spec: &DramSpec) -> Closed {
    let t = &spec.part.timing;
    Closed {
        cl: t.cl.get(),
        cwl: t.cwl.get(),
        rcd: t.rcd.get(),
        rp: t.rp.get(),
        ras: t.ras.get(),
        rc: t.rc.get(),
        rtp: t.rtp.get(),
        wr: t.wr.get(),
        wtr: t.wtr_l.get(),
        refi: t.refi.get(),
        rfc: t.rfc.get(),
    }
}

fn request(line: u64, write: bool) -> Request {
    Request {
        line: LineAddr(line),
        class: TrafficClass::Node,
        write,
        bytes: Bytes(64),
        from: PartId(9),
        attributed: false,
    }
}

/// Puts each request in its cycle; returns the cycle of each answer.
fn answers(dram: &mut Dram, requests: &[(u64, Request)], cycles: u64) -> Vec<u64> {
    let mut left = requests.iter().copied().peekable();
    let mut answers = Vec::new();
    for now in 0..cycles {
        while let Some((_, request)) = left.next_if(|&(at, _)| at <= now) {
            assert!(dram.put(request, now, &mut Awake));
        }
        dram.tick(0, now, &mut Awake, |_, _| answers.push(now));
    }
    answers
}

/// Clocks of a line on the bus: two bursts of 8.
const LINE: u64 = 16;
/// Distance in lines to the next row of the same bank: 2 columns, 8 banks, 16 columns.
const ROW: u64 = 256;

#[test]
fn latencies_are_closed_forms() {
    let timing = timing(&DramSpec::default());
    // The first command is given in the cycle after the request was put.
    let miss = 1 + timing.rcd + timing.cl + LINE;
    let hit = 1 + timing.cl + LINE;
    // The precharge waits for tRAS after the activate, which was given in cycle 1.
    let late = 1000;
    let conflict = 1 + timing.rp + timing.rcd + timing.cl + LINE;
    for (second, at, expected) in [(1, late, late + hit), (ROW, late, late + conflict), (2, late, late + miss)] {
        let mut dram = dram();
        let got = answers(&mut dram, &[(0, request(0, false)), (at, request(second, false))], 3000);
        assert_eq!(got, [miss, expected], "line {second}");
        let counts = *dram.counts(0);
        let met = (counts.row_hits, counts.row_misses, counts.row_conflicts);
        assert_eq!(met, [(1, 1, 0), (0, 1, 1), (0, 2, 0)][[1, ROW, 2].iter().position(|&l| l == second).unwrap()]);
    }
}

#[test]
fn an_early_conflict_waits_for_the_row_to_be_restored() {
    let mut dram = dram();
    let timing = timing(&DramSpec::default());
    let got = answers(&mut dram, &[(0, request(0, false)), (0, request(ROW, false))], 3000);
    let precharge = 1 + timing.ras;
    assert_eq!(got[1], precharge + timing.rp + timing.rcd + timing.cl + LINE);
}

#[test]
fn a_read_after_a_write_waits_for_the_turn() {
    let mut dram = dram();
    let timing = timing(&DramSpec::default());
    let got = answers(&mut dram, &[(0, request(0, true)), (0, request(1, false))], 3000);
    let write_ends = 1 + timing.rcd + timing.cwl + LINE;
    assert_eq!(got, [write_ends + timing.wtr + timing.cl + LINE]);
}

#[test]
fn a_write_after_a_read_waits_for_the_bus_to_turn() {
    let spec = with(&[("turn", 50)]);
    let mut dram = built(&spec);
    let timing = timing(&DramSpec::default());
    let row = [0, 1, 16].map(|line| request(line, line == 1));
    let got = answers(&mut dram, &row.map(|request| (0, request)), 3000);
    // Both reads go first: a write could start only after the bus has turned.
    let reads_end = 1 + timing.rcd + timing.cl + 2 * LINE;
    assert_eq!(got, [reads_end - LINE, reads_end]);
    let mut alone = built(&spec);
    let got = answers(&mut alone, &[(0, row[0]), (0, row[1]), (300, row[2])], 3000);
    let write_ends = reads_end - LINE + 50 + LINE;
    assert_eq!(got, [reads_end - LINE, (write_ends + timing.wtr).max(301) + timing.cl + LINE]);
}

/// One line in each of eight banks: the fifth activate comes tFAW after the first.
#[test]
fn four_activates_fill_their_window() {
    let spec = with(&[("faw", 200)]);
    let mut dram = built(&spec);
    let timing = timing(&DramSpec::default());
    let banks: Vec<_> = (0..8).map(|bank| (0, request(2 * bank, false))).collect();
    let first = 1 + timing.rcd + timing.cl + LINE;
    let window = |start: u64| (0..4).map(move |bank| start + bank * 16);
    assert_eq!(answers(&mut dram, &banks, 3000), window(first).chain(window(first + 200)).collect::<Vec<_>>());
}

#[test]
fn row_hits_go_first() {
    let mut dram = dram();
    let requests = [(0, request(0, false)), (0, request(ROW, false)), (0, request(1, false))];
    answers(&mut dram, &requests, 3000);
    let counts = dram.counts(0);
    assert_eq!((counts.row_hits, counts.row_misses, counts.row_conflicts), (1, 1, 1));
}

#[test]
fn a_chain_of_row_hits_fills_the_bus() {
    let mut dram = dram();
    let timing = timing(&DramSpec::default());
    let first = 1 + timing.rcd + timing.cl;
    // The lines of one row: columns 0 and 1, then the columns above the bank bits.
    let row: Vec<_> = (0..32).map(|line| (0, request(line / 2 * 16 + line % 2, false))).collect();
    let got = answers(&mut dram, &row, 3000);
    assert_eq!(got, (1..=32).map(|line| first + line * LINE).collect::<Vec<_>>());
}

/// The bus moves a line in 16 / 1600 MHz = 10 ns, 1.4 cycles of 140 MHz: 5 lines take 7 cycles, not 10.
#[test]
fn a_fraction_of_a_cycle_is_not_lost() {
    let mut dram = Dram::new(&DramSpec::default(), 140, 64, PartId(0));
    let row: Vec<_> = (0..30).map(|line| (0, request(line / 2 * 16 + line % 2, false))).collect();
    let got = answers(&mut dram, &row, 500);
    assert_eq!(got[29] - got[4], 25 * 7 / 5);
}

#[test]
fn refreshes_come_every_refi_and_stop_the_channel() {
    let mut dram = dram();
    let timing = timing(&DramSpec::default());
    let got = answers(&mut dram, &[(timing.refi, request(0, false))], 10 * timing.refi + 1);
    // All banks are closed: the refresh is given when it is due, the activate tRFC after it.
    assert_eq!(got, [timing.refi + timing.rfc + timing.rcd + timing.cl + LINE]);
    assert_eq!(dram.counts(0).refreshes, 10);
}

/// The queue is never empty: between refreshes the lines follow one another without gaps.
#[test]
fn bandwidth_is_limited_by_refreshes_alone() {
    let mut dram = dram();
    let timing = timing(&DramSpec::default());
    let intervals = 20;
    // Before the first refresh: the activate in cycle 1.
    let (mut first, mut bursts) = (1 + timing.rcd, 0);
    for due in (1..=intervals).map(|interval| interval * timing.refi) {
        // Bursts, two per line; a refresh can split the last line.
        let more = (due - first).div_ceil(LINE / 2);
        let last = first + (more - 1) * (LINE / 2);
        bursts += more;
        first = due.max(last + timing.rtp) + timing.rp + timing.rfc + timing.rcd;
    }
    let (mut column, cycles) = (0, intervals * timing.refi);
    for now in 0..cycles {
        // The 32 lines of one row, over and over.
        while dram.put(request(column / 2 * 16 + column % 2, false), now, &mut Awake) {
            column = (column + 1) % 32;
        }
        dram.tick(0, now, &mut Awake, |_, _| {});
    }
    let counts = dram.counts(0);
    assert_eq!((counts.reads, counts.row_conflicts), (bursts / 2, 0));
    // One channel of LPDDR4 reaches 94 % of its peak.
    let (busy, share) = (bursts / 2 * LINE, 1.0 - (timing.rp + timing.rfc + timing.rcd) as f64 / timing.refi as f64);
    assert!((busy as f64 / cycles as f64 - share).abs() < 0.005, "{busy} of {cycles}, {share}");
}

#[test]
fn a_refresh_closes_the_rows() {
    let mut dram = dram();
    let timing = timing(&DramSpec::default());
    let before = timing.refi - timing.rcd - timing.cl - LINE - 2;
    answers(&mut dram, &[(before, request(0, false)), (2 * before, request(1, false))], 2 * timing.refi);
    assert_eq!(dram.counts(0).row_misses, 2);
}

#[test]
fn a_full_queue_refuses() {
    let spec = DramSpec { queue: Within::new(1).unwrap(), ..DramSpec::default() };
    let mut dram = built(&spec);
    assert!(dram.put(request(0, false), 0, &mut Awake));
    assert!(!dram.put(request(1, false), 0, &mut Awake));
}

/// Banks 0 to 3 are one group, 4 to 7 the other; a line of 64 B is one burst of 4 clocks.
fn grouped() -> DramSpec {
    let mut spec = with(&[("ccd_s", 4), ("ccd_l", 8), ("rrd_s", 5), ("rrd_l", 9), ("wtr_s", 3), ("wtr_l", 14)]);
    spec.part.bank_groups = PowerOfTwo::new(2).unwrap();
    (spec.part.burst_bytes, spec.part.burst_clocks) = (PowerOfTwoSize::new(64).unwrap(), Within::new(4).unwrap());
    spec.mapping = Mapping(vec![Field::BankGroup(1), Field::Bank(2), Field::Column(5), Field::Row]);
    spec
}

#[test]
fn bank_groups_part_long_from_short() {
    let spec = grouped();
    let Closed { cl, cwl, rcd, .. } = timing(&spec);
    let first = 1 + rcd + cl + 4;
    // Line 1 is in the other group, line 2 in the same. The second activate comes tRRD after the first.
    for (other, rrd) in [(1, 5), (2, 9)] {
        let got = answers(&mut built(&spec), &[(0, request(0, false)), (0, request(other, false))], 3000);
        assert_eq!(got, [first, first + rrd], "line {other}");
    }
    // Open rows: line 8 + other follows line 8 by tCCD, and a read follows a write by tWTR.
    for (other, ccd, wtr) in [(1, 4, 3), (2, 8, 14)] {
        let opened = [(0, request(0, false)), (0, request(other, false))];
        let pair = |write| [(500, request(8, write)), (500, request(8 + other, false))];
        let got = answers(&mut built(&spec), &[opened, pair(false)].concat(), 3000);
        assert_eq!(got[2..], [501 + cl + 4, 501 + ccd + cl + 4], "line {other}");
        let got = answers(&mut built(&spec), &[opened, pair(true)].concat(), 3000);
        // A read goes first if both come at once and the write must wait; here the write is legal at once.
        assert_eq!(got[2..], [501 + cwl + 4 + wtr + cl + 4], "line {other}");
    }
}

/// With one group a channel reaches `burst / tCCD_L` of its peak, with two groups in turn all of it.
#[test]
fn groups_in_turn_fill_the_bus() {
    let spec = grouped();
    let Closed { cl, rcd, .. } = timing(&spec);
    let first = 1 + rcd + cl;
    let one: Vec<_> = (0..20).map(|column| (0, request(8 * column, false))).collect();
    assert_eq!(*answers(&mut built(&spec), &one, 3000).last().unwrap(), first + 19 * 8 + 4);
    let both: Vec<_> = (0..20).map(|number| (0, request(number / 2 * 8 + number % 2, false))).collect();
    let got = answers(&mut built(&spec), &both, 3000);
    // The second row opens one activate later; from then on the bursts follow without gaps.
    assert!(got.windows(2).skip(2).all(|pair| pair[1] - pair[0] == 4), "{got:?}");
}

#[test]
fn a_closed_page_is_opened_for_every_request() {
    let spec = DramSpec { page: Page::Closed, ..DramSpec::default() };
    let Closed { cl, cwl, rcd, rp, ras, rc, rtp, wr, .. } = timing(&spec);
    let miss = rcd + cl + LINE;
    // Late requests find the row closed: each is a row miss.
    let mut dram = built(&spec);
    let got = answers(&mut dram, &[(0, request(0, false)), (1000, request(1, false))], 3000);
    assert_eq!(got, [1 + miss, 1001 + miss]);
    assert_eq!((dram.counts(0).row_misses, dram.counts(0).row_hits), (2, 0));
    // With both requests at once, the bank closes tRTP after the second burst or tRAS after the activate, and opens tRP
    // later.
    let reopened = 1 + ras.max(rcd + LINE / 2 + rtp) + rp;
    let got = answers(&mut built(&spec), &[(0, request(0, false)), (0, request(1, false))], 3000);
    assert_eq!(got[1], reopened.max(1 + rc) + miss);
    let reopened = 1 + ras.max(rcd + LINE / 2 + cwl + LINE / 2 + wr) + rp;
    let got = answers(&mut built(&spec), &[(0, request(0, true)), (0, request(1, false))], 3000);
    assert_eq!(got, [reopened + miss]);
}

/// DRAM clocks are counted exactly for any ratio to the machine's clock.
#[test]
fn a_read_takes_the_same_time_on_any_machine() {
    let spec = DramSpec::default();
    let Closed { cl, rcd, .. } = timing(&spec);
    for mhz in [123, 500, 1599, 1600, 1601, 4000] {
        let mut dram = Dram::new(&spec, mhz, 64, PartId(0));
        let got = answers(&mut dram, &[(10, request(0, false))], 20_000);
        // The first clock that begins in cycle 11 or later, and the first cycle that begins after the data has passed.
        let clock = (11 * 1600u64).div_ceil(mhz) + rcd + cl + LINE;
        assert_eq!(got, [(clock * mhz).div_ceil(1600)], "{mhz} MHz");
    }
}
