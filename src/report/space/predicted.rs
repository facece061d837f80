//! Predictions of designs before their replays, against the measured figures.

use super::data::{Design, SpaceSummary};
use crate::report::draw::canvas::{Canvas, DrawError, LEFT, LINE, Text, tick_step};
use crate::report::draw::palette::{BLUE, FAINT, GRID, VERMILLION, pale};
use crate::report::draw::{Figure, Plot};
use crate::report::format::{number, percent, percent_tick};
use crate::report::grid::Grid;

const PANEL: i32 = 130;
const ABOVE: i32 = 30;
const BELOW: i32 = 24;
const AXIS: i32 = 62;

pub(super) const PLOT: Plot<SpaceSummary> = Plot { name: "predicted", section: (), figure };

/// A figure of all designs that were predicted before their replays. For each design: the error and the interval's
/// ends, relative to the measured figure.
struct Panel {
    name: &'static str,
    errors: Vec<[f64; 3]>,
}

/// A figure: its key in files, its name, and a design's value.
type Named = (&'static str, &'static str, fn(&Design) -> Option<f64>);

const FIGURES: [Named; 3] = [
    ("cycles", "cycles", |it| Some(it.cycles)),
    ("dram_bytes", "DRAM bytes", |it| Some(it.dram_bytes)),
    ("joules", "energy", |it| it.joules),
];

fn figure(summary: &SpaceSummary) -> Option<Figure<'_>> {
    let mut rows = Vec::new();
    let panel = |&(key, name, of): &Named| {
        let mut errors = Vec::new();
        for (at, design) in summary.designs.iter().enumerate().filter(|(_, design)| design.replayed) {
            if let (Some(foreseen), Some(measured)) = (design.foreseen.get(key), of(design).filter(|it| *it > 0.0)) {
                let [mean, low, high] = foreseen.map(|value| value / measured - 1.0);
                errors.push([mean, low, high]);
                rows.push(vec![(at + 1).to_string(), name.to_owned(), number(mean), number(low), number(high)]);
            }
        }
        Panel { name, errors }
    };
    let panels: Vec<Panel> = FIGURES.iter().map(panel).filter(|panel| !panel.errors.is_empty()).collect();
    let cycles = summary.accuracy.get("cycles").filter(|_| !panels.is_empty())?;
    let head = ["design", "figure", "error", "interval from", "to"];
    let data = Grid { head: head.map(Into::into).to_vec(), names: 2, rows };
    let height = panels.len() as i32 * (ABOVE + PANEL + BELOW);
    Some(Figure {
        title: format!(
            "Half of the predictions of cycles are within {}, nine of ten within {}",
            percent(cycles.foreseen.median),
            percent(cycles.foreseen.ninth)
        ),
        about:
            "Dots: the error of what was predicted before a replay, designs in the order of the table. Bars: the 95 % \
                interval, in red where it does not hold what was measured."
                .into(),
        key: vec![("interval holds".into(), BLUE), ("does not".into(), VERMILLION)],
        data,
        narrow: true,
        height: Box::new(move |_| height),
        paint: Box::new(move |canvas| {
            let tops = (0..).map(|index| index * (ABOVE + PANEL + BELOW) + ABOVE);
            panels.iter().zip(tops).try_for_each(|(panel, top)| paint(canvas, panel, top))
        }),
    })
}

fn paint(canvas: &Canvas<'_>, panel: &Panel, top: i32) -> Result<(), DrawError> {
    let (end, bottom) = (canvas.width() - 16, top + PANEL);
    let most = panel.errors.iter().flat_map(|ends| ends.iter().map(|it| it.abs())).fold(0.01, f64::max);
    let step = tick_step(2.0 * most, 5);
    let reach = (most / step).ceil() * step;
    let y = |share: f64| top + ((reach - share) / (2.0 * reach) * f64::from(PANEL)).round() as i32;
    canvas.text(panel.name, (LEFT, top - 16), Text::LABEL.bold())?;
    let ticks = (reach / step).round() as i32;
    for tick in -ticks..=ticks {
        let share = f64::from(tick) * step;
        canvas.line(vec![(AXIS, y(share)), (end, y(share))], if tick == 0 { FAINT } else { GRID }, 1)?;
        if tick % 2 == 0 || ticks < 3 {
            canvas.text(&percent_tick(share), (AXIS - 8, y(share)), Text::NOTE.right())?;
        }
    }
    let apart = f64::from(end - AXIS - LINE) / panel.errors.len() as f64;
    for (at, [error, low, high]) in panel.errors.iter().enumerate() {
        let x = AXIS + LINE / 2 + ((at as f64 + 0.5) * apart).round() as i32;
        let color = if (*low..=*high).contains(&0.0) { BLUE } else { VERMILLION };
        canvas.line(vec![(x, y(*high)), (x, y(*low))], pale(color), 3)?;
        canvas.dot((x, y(*error)), 3, color)?;
    }
    canvas.line(vec![(AXIS, bottom), (end, bottom)], GRID, 1)
}
