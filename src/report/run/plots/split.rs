//! DRAM bytes that culling saved, and those that mode words cost, as a waterfall.

use super::machine::{Machine, MachinePlot};
use crate::quantity::Bytes;
use crate::report::draw::Figure;
use crate::report::draw::palette::{ORANGE, PAID, SAVED, WITHOUT};
use crate::report::draw::waterfall::{Level, Waterfall};
use crate::report::format::{bytes, change, or_absent, percent};
use crate::report::split::{Split, signed};

pub(super) const PLOT: MachinePlot = MachinePlot { name: "split", figure };

fn figure<'a>(machine: &'a Machine<'a>) -> Option<Figure<'a>> {
    let frames = machine.found.frames.len().max(1) as f64;
    let a_frame = |amount: f64| amount / frames;
    let way = |(policy, split): (&str, &Split)| {
        let [off, _, with] = split.dram.map(|amount| a_frame(amount.0 as f64));
        let [saved, words, interference] =
            [split.saved as f64, split.words as f64, split.interference as f64].map(a_frame);
        let free = off - saved;
        let step = |name, from: f64, by: f64, color| Level {
            name,
            span: (from, from + by),
            color: if by < 0.0 { SAVED } else { color },
            note: if by < 0.0 { signed(by.round() as i64) } else { format!("+{}", signed(by.round() as i64)) },
        };
        let whole = |name, amount: f64, color, note| Level { name, span: (0.0, amount), color, note };
        let shown = |amount: f64| bytes(Bytes(amount.round() as u64));
        let net = or_absent(change(off, with), |it| it);
        let levels = vec![
            whole("without culling", off, WITHOUT, shown(off)),
            step("saved by culling", off, -saved, PAID),
            step("words, counters, ids", free, words, PAID),
            step("interference", free + words, interference, ORANGE),
            whole("with culling", with, machine.color(policy), format!("{} ({net})", shown(with))),
        ];
        let culled = format!(
            "{policy}: {} of shadow rays culled, {} would repay the words",
            percent(split.culled),
            or_absent(split.break_even, percent)
        );
        (culled, levels)
    };
    let ways: Vec<_> = machine.found.split.iter().map(way).collect();
    let any = machine.found.split.iter().any(|(_, split)| split.dram.iter().any(|bytes| bytes.0 > 0));
    let (policy, first) = machine.found.split.iter().next().filter(|_| any)?;
    let paid = first.words as i64 + first.interference;
    let verdict = if first.saved > paid { "saves more than it pays" } else { "pays more than it saves" };
    let chart = Waterfall {
        title: format!("{}: {policy} {verdict} in DRAM bytes", machine.name),
        about:
            "DRAM bytes a measured frame. Three replays tell apart what culling saves if words cost nothing, the bytes \
                of words, counters and occluder ids, and extra bytes of other classes, whose lines the words evicted."
                .into(),
        key: [("saved", SAVED), ("paid for words", PAID), ("paid by interference", ORANGE)]
            .map(|(name, color)| (name.into(), color))
            .into(),
        axis: "DRAM bytes a frame",
        tick: |amount| bytes(Bytes(amount.max(0.0).round() as u64)),
        ways,
    };
    Some(chart.figure())
}
