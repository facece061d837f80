//! The machine as a block diagram: boxes filled by cause of cycles, edges whose width shows bytes.

use std::collections::BTreeMap;

use super::machine::{Machine, MachinePlot};
use crate::quantity::Bytes;
use crate::report::draw::Figure;
use crate::report::draw::canvas::{Canvas, DrawError, LEFT, LINE, Text};
use crate::report::draw::palette::{BLUE, Color, FAINT, GREEN, GRID, cause_look};
use crate::report::format::{bytes, percent, words};
use crate::report::grid::Grid;
use crate::report::run::machine_run::MachineRun;
use crate::stats::Cause;

pub(super) const PLOT: MachinePlot = MachinePlot { name: "diagram", figure };

/// Height of a unit's row, and of its box below its name.
const ROW: i32 = 58;
const BOX: i32 = 22;
/// Height of the DRAM's row and of the edge above it.
const DRAM: i32 = 78;
/// Width of the widest edge.
const WIDEST: f64 = 22.0;

/// The colour of edges.
const EDGE: Color = BLUE;

fn figure<'a>(machine: &'a Machine<'a>) -> Option<Figure<'a>> {
    let (policy, run) = machine.culling().next().or_else(|| machine.runs().next())?;
    let diagram = Diagram::new(run, machine.found.frames.len().max(1))?;
    let rows = diagram.units.len() as i32 + 1;
    let [widest, dram] = [diagram.widest(), diagram.dram + diagram.host].map(shown);
    Some(Figure {
        title: format!("{} with {policy}: the busiest link carries {widest} a frame, the DRAM {dram}", machine.name,),
        about: "Boxes are filled by cause of cycles. Edges are as wide as the bytes that they carry a measured frame. \
                Caches say how many of their accesses hit."
            .into(),
        key: Cause::ALL.into_iter().map(|cause| (cause_look(cause).0.into(), cause_look(cause).1)).collect(),
        data: diagram.data(),
        narrow: true,
        height: Box::new(move |_| rows * ROW + DRAM),
        paint: Box::new(move |canvas| diagram.paint(canvas)),
    })
}

/// A kind of unit.
struct Unit {
    name: String,
    count: u64,
    /// Shares of cycles, in the order of [`Cause::ALL`].
    causes: [f64; Cause::ALL.len()],
    /// Bytes per frame to its L1 and from there to the L2, and the L1's hit rate.
    l1: Option<(f64, f64, f64)>,
}

struct Diagram {
    dispatcher: Option<Unit>,
    units: Vec<Unit>,
    /// Bytes per frame through the FIFOs, to the L2, from there to the DRAM, and from the host's port to the DRAM.
    fifos: f64,
    l2: f64,
    dram: f64,
    host: f64,
    l2_hits: Option<f64>,
    /// Share of the DRAM's peak bandwidth.
    dram_use: Option<f64>,
}

impl Diagram {
    fn new(run: &MachineRun, frames: usize) -> Option<Self> {
        let stats = &run.stats;
        let a_frame = |level: &str| stats.moved(level).0 as f64 / frames as f64;
        let of_host = stats.bytes.get("dram").into_iter().flatten().filter(|(class, _)| class.is_of_host());
        let host = of_host.map(|(_, moved)| moved.0).sum::<u64>() as f64 / frames as f64;
        // Requests of an L1 to the L2: missed lines, and words that it passes on or writes back. They divide the
        // bytes of the L2 among the L1s.
        let asked = |cache: &str| -> u64 {
            let classes = stats.caches.get(cache).into_iter().flat_map(|classes| classes.values());
            classes.map(|it| it.counts.misses + it.counts.passed_writes + it.counts.write_backs).sum()
        };
        let all: u64 = stats.caches.keys().filter(|cache| cache.starts_with("l1_")).map(|cache| asked(cache)).sum();
        let hits = |cache: &str| {
            let classes = stats.caches.get(cache)?.values();
            let sums = classes.fold((0, 0), |sum, it| (sum.0 + it.counts.hits, sum.1 + it.counts.accesses));
            (sums.1 > 0).then(|| sums.0 as f64 / sums.1 as f64)
        };
        let unit = |(name, causes): (&String, &BTreeMap<Cause, u64>)| {
            let whole: u64 = causes.values().sum::<u64>().max(1);
            let cache = format!("l1_{name}");
            let share = asked(&cache) as f64 / all.max(1) as f64;
            Unit {
                name: words(name),
                count: stats.unit_counts.get(name).copied().unwrap_or(1),
                causes: Cause::ALL.map(|cause| causes.get(&cause).map_or(0.0, |&it| it as f64 / whole as f64)),
                l1: hits(&cache).map(|rate| (a_frame(&cache), a_frame("l2") * share, rate)),
            }
        };
        let (dispatcher, units) = stats.units.iter().partition::<Vec<_>, _>(|(name, _)| *name == "dispatcher");
        // A kind of unit without any ray is left out.
        let units: Vec<Unit> = units.into_iter().map(unit).filter(|it| it.causes[Cause::ALL.len() - 1] < 1.0).collect();
        let diagram = Self {
            dispatcher: dispatcher.into_iter().map(unit).next(),
            units,
            fifos: a_frame("fifos"),
            l2: a_frame("l2"),
            dram: a_frame("dram") - host,
            host,
            l2_hits: hits("l2"),
            dram_use: run.dram_utilization,
        };
        (!diagram.units.is_empty() && diagram.widest() > 0.0).then_some(diagram)
    }

    fn widest(&self) -> f64 {
        let edges = self.units.iter().filter_map(|unit| unit.l1).map(|(to_l1, ..)| to_l1);
        edges.chain([self.fifos, self.l2, self.dram, self.host]).fold(0.0, f64::max)
    }

    fn data(&self) -> Grid {
        let row = |from: &str, to: &str, amount: f64| vec![from.to_owned(), to.into(), format!("{amount:.0}")];
        let mut rows = vec![row("dispatcher", "units", self.fifos)];
        for unit in &self.units {
            let Some((to_l1, to_l2, _)) = unit.l1 else { continue };
            rows.push(row(&unit.name, "L1", to_l1));
            rows.push(row(&format!("L1 of {}", unit.name), "L2", to_l2));
        }
        rows.push(row("L2", "DRAM", self.dram));
        if self.host > 0.0 {
            rows.push(row("host's port", "DRAM", self.host));
        }
        Grid { head: ["between", "and", "bytes a frame"].map(Into::into).to_vec(), names: 2, rows }
    }

    fn paint(&self, canvas: &Canvas<'_>) -> Result<(), DrawError> {
        let at = |share: f64| (f64::from(canvas.width()) * share).round() as i32;
        let right = canvas.width() - LEFT;
        // The host's edge runs down beside the L2.
        let beside = if self.host > 0.0 { self.stroke(self.host) as i32 + 14 } else { 0 };
        let (unit, l1, l2) = ((LEFT, at(0.42)), (at(0.57), at(0.72)), (at(0.85), right - beside));
        let (first, last) = (ROW, ROW * (1 + self.units.len() as i32));
        if let Some(dispatcher) = &self.dispatcher {
            block(canvas, dispatcher, unit, 0)?;
            let x = unit.0 + 24;
            canvas.line(vec![(x, LINE + BOX), (x, ROW - 2)], EDGE, self.stroke(self.fifos))?;
            let text = format!("FIFOs {}", shown(self.fifos));
            canvas.text(&text, (x + 20, LINE + BOX + 9), Text::NOTE)?;
        }
        canvas.frame((l2.0, first + LINE - 6), (l2.1, last - 8), FAINT, 1)?;
        let middle = (l2.0 + l2.1) / 2;
        canvas.text("L2", (middle, (first + last) / 2 - 9), Text::LABEL.bold().centered())?;
        let hits = self.l2_hits.map(percent).unwrap_or_default();
        canvas.text(&hits, (middle, (first + last) / 2 + 9), Text::NOTE.centered())?;
        for (row, it) in (1..).zip(&self.units) {
            block(canvas, it, unit, row * ROW)?;
            let Some((to_l1, to_l2, rate)) = it.l1 else { continue };
            let (top, y) = (row * ROW + LINE, row * ROW + LINE + BOX / 2);
            canvas.line(vec![(unit.1, y), (l1.0, y)], EDGE, self.stroke(to_l1))?;
            canvas.text(&shown(to_l1), ((unit.1 + l1.0) / 2, top - 8), Text::NOTE.centered())?;
            canvas.frame((l1.0, top - 4), (l1.1, top + BOX + 4), FAINT, 1)?;
            let text = if canvas.is_narrow() {
                format!("{:.0} %", rate * 100.0)
            } else {
                format!("L1: {} hit", percent(rate))
            };
            canvas.text(&text, ((l1.0 + l1.1) / 2, y), Text::NOTE.centered())?;
            canvas.line(vec![(l1.1, y), (l2.0, y)], EDGE, self.stroke(to_l2))?;
            canvas.text(&shown(to_l2), ((l1.1 + l2.0) / 2, top - 8), Text::NOTE.centered())?;
        }
        let top = last + DRAM - 40;
        canvas.line(vec![(middle, last - 8), (middle, top)], EDGE, self.stroke(self.dram))?;
        canvas.text(&shown(self.dram), (middle - 16, (last - 8 + top) / 2), Text::NOTE.right())?;
        if self.host > 0.0 {
            let (x, y) = (right - self.stroke(self.host) as i32 / 2 - 1, LINE + BOX / 2);
            canvas.line(vec![(unit.1, y), (x, y), (x, top)], EDGE, self.stroke(self.host))?;
            let text = format!("host's port {}", shown(self.host));
            canvas.text(&text, ((unit.1 + x) / 2, y - 20), Text::NOTE.centered())?;
        }
        let used = self.dram_use.unwrap_or(0.0).min(1.0);
        let full = l2.0 + (f64::from(right - l2.0) * used).round() as i32;
        canvas.rect((l2.0, top), (right, top + BOX), GRID)?;
        canvas.rect((l2.0, top), (full, top + BOX), GREEN)?;
        canvas.frame((l2.0, top), (right, top + BOX), FAINT, 1)?;
        let text = self.dram_use.map_or("DRAM".into(), |used| format!("DRAM {} of peak", percent(used)));
        canvas.text(&text, (l2.0 - 8, top + BOX / 2), Text::LABEL.right())
    }

    fn stroke(&self, amount: f64) -> u32 {
        ((amount / self.widest() * WIDEST).round() as u32).max(1)
    }
}

/// Draws a kind of unit: its name, and a box filled by causes.
fn block(canvas: &Canvas<'_>, unit: &Unit, (left, right): (i32, i32), top: i32) -> Result<(), DrawError> {
    let count = if unit.count == 1 && canvas.is_narrow() { String::new() } else { format!(" \u{d7}{}", unit.count) };
    let name = unit.name.clone() + &count;
    let busy = percent(unit.causes[0]);
    let (look, busy) = match canvas.is_narrow() {
        true => (Text::NOTE.bold(), format!("{:.0} %", unit.causes[0] * 100.0)),
        false => (Text::LABEL.bold(), format!("{busy} busy")),
    };
    canvas.text(&name, (left, top + LINE / 2), look)?;
    // Where there is no room for it, the box alone tells the share.
    if look.width(&name) + 6 + Text::NOTE.width(&busy) <= right - left {
        canvas.text(&busy, (right, top + LINE / 2), Text::NOTE.right())?;
    }
    let at = |share: f64| left + (share * f64::from(right - left)).round() as i32;
    let mut from = 0.0;
    for (share, cause) in unit.causes.into_iter().zip(Cause::ALL) {
        if share > 0.0 {
            canvas.rect((at(from), top + LINE), (at(from + share), top + LINE + BOX), cause_look(cause).1)?;
        }
        from += share;
    }
    canvas.frame((left, top + LINE), (right, top + LINE + BOX), FAINT, 1)
}

fn shown(amount: f64) -> String {
    bytes(Bytes(amount.round() as u64))
}
