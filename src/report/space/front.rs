//! Cycles against DRAM bytes and energy: replayed designs, predicted designs, and the front.

use super::axis::Axis;
use super::data::{Design, SpaceSummary};
use crate::report::draw::canvas::{Canvas, DrawError, LEFT, LINE, Text};
use crate::report::draw::marks::mark;
use crate::report::draw::palette::{GREY, GRID, INK, series_color};
use crate::report::draw::{Figure, Plot};
use crate::report::format::{counted, joules, number, tick};
use crate::report::grid::Grid;
use crate::report::sweep::label;

const PANEL: i32 = 300;
const AXIS: i32 = 70;
const BELOW: i32 = 54;
/// The most predicted designs in a plot.
const MOST: usize = 2_000;

pub(super) const PLOT: Plot<SpaceSummary> = Plot { name: "front", section: (), figure };

type Of = fn(&Design) -> Option<f64>;

/// A figure that is drawn against cycles: its name, a design's value, and the function that formats a tick.
type Panel = (&'static str, Of, fn(f64) -> String);

const PANELS: [Panel; 2] = [
    ("DRAM bytes", |it| Some(it.dram_bytes), |value| format!("{}B", tick(value)).replace(" B", "B")),
    ("energy", |it| it.joules, joules),
];

fn figure(summary: &SpaceSummary) -> Option<Figure<'_>> {
    let mut names: Vec<String> = Vec::new();
    for design in &summary.designs {
        let name = series(design);
        if !names.contains(&name) {
            names.push(name);
        }
    }
    let front = summary.front();
    let fastest = front.first()?.1;
    let row = |(at, it): (usize, &Design)| {
        vec![
            (at + 1).to_string(),
            series(it),
            label(&it.changes),
            number(it.cycles),
            number(it.dram_bytes),
            it.joules.map_or_else(String::new, |joules| joules.to_string()),
            if it.front { "yes" } else { "no" }.into(),
        ]
    };
    let replayed = summary.designs.iter().enumerate().filter(|(_, it)| it.replayed);
    let head = ["design", "machine, policy", "fields", "cycles", "DRAM bytes", "energy in J", "unbeaten"];
    let data = Grid { head: head.map(Into::into).to_vec(), names: 3, rows: replayed.map(row).collect() };
    let panels = PANELS.iter().filter(|(_, of, _)| summary.designs.iter().any(|it| of(it).is_some())).count() as i32;
    let labels = names.len() as i32 * LINE;
    Some(Figure {
        title: format!(
            "{} are unbeaten; {} under {} takes the fewest cycles",
            counted(front.len(), "design"),
            label(&fastest.changes),
            fastest.policy
        ),
        about:
            "Marks: designs that were replayed; ringed where no other is better in everything, wrong pixels among it. \
                Grey: designs that are predicted. Both axes are logarithmic."
                .into(),
        key: vec![("predicted".into(), GREY)],
        data,
        narrow: true,
        height: Box::new(move |_| panels * (LINE + PANEL + BELOW) + labels),
        paint: Box::new(move |canvas| {
            let mut top = 0;
            for panel in PANELS.iter().filter(|(_, of, _)| summary.designs.iter().any(|it| of(it).is_some())) {
                paint(canvas, summary, &names, panel, top + LINE)?;
                top += LINE + PANEL + BELOW;
            }
            for (index, name) in names.iter().enumerate() {
                let y = top + index as i32 * LINE;
                mark(canvas, index, (LEFT + 7, y), series_color(index), true)?;
                canvas.text(name, (LEFT + 20, y), Text::LABEL)?;
            }
            Ok(())
        }),
    })
}

fn series(design: &Design) -> String {
    format!("{}, {}", design.machine, design.policy)
}

fn paint(
    canvas: &Canvas<'_>,
    summary: &SpaceSummary,
    names: &[String],
    (name, of, shown): &Panel,
    top: i32,
) -> Result<(), DrawError> {
    let (end, bottom) = (canvas.width() - 16, top + PANEL);
    let x = Axis::new(summary.designs.iter().map(|it| it.cycles), AXIS, end);
    let y = Axis::new(summary.designs.iter().filter_map(of), bottom, top);
    canvas.text(name, (LEFT, top - 12), Text::NOTE)?;
    canvas.text("cycles", (end, bottom + 34), Text::NOTE.right())?;
    let mut free = i32::MIN;
    for value in x.ticks(5) {
        let (at, text) = (x.at(value), tick(value));
        canvas.line(vec![(at, top), (at, bottom)], GRID, 1)?;
        let half = Text::NOTE.width(&text) / 2;
        if at - half > free {
            canvas.text(&text, (at, bottom + 14), Text::NOTE.centered())?;
            free = at + half + 6;
        }
    }
    let mut free = i32::MAX;
    for value in y.ticks(6) {
        let at = y.at(value);
        canvas.line(vec![(AXIS, at), (end, at)], GRID, 1)?;
        if at < free {
            canvas.text(&shown(value), (AXIS - 8, at), Text::NOTE.right())?;
            free = at - LINE + 6;
        }
    }
    let place = |design: &Design| Some((x.at(design.cycles), y.at(of(design)?)));
    for at in summary.designs.iter().filter(|it| !it.replayed).filter_map(place).take(MOST) {
        canvas.dot(at, 2, GREY)?;
    }
    for front in [false, true] {
        for design in summary.designs.iter().filter(|it| it.replayed && it.front == front) {
            let (Some(at), Some(index)) = (place(design), names.iter().position(|name| *name == series(design))) else {
                continue;
            };
            mark(canvas, index, at, series_color(index), front)?;
            if front {
                canvas.ring(at, 9, INK, 1)?;
            }
        }
    }
    Ok(())
}
