//! Error of the fidelity levels over their speed: mean, worst and claimed error, and the levels that no other level
//! beats.

use super::data::ParetoSummary;
use super::level::{Rung, Spread};
use super::report::ParetoReport;
use super::timing::Timing;
use crate::report::draw::canvas::{Canvas, DrawError, LEFT, LINE, Text};
use crate::report::draw::marks::{Names, mark};
use crate::report::draw::palette::{FAINT, GRID, INK, series_color};
use crate::report::draw::{Figure, Plot};
use crate::report::format::{number, percent, tick};
use crate::report::grid::Grid;

/// Height of a panel's logarithmic axis, of the place for smaller errors below it, and of the parts above and below.
const PANEL: i32 = 160;
const NONE: i32 = 26;
const ABOVE: i32 = 52;
const BELOW: i32 = 46;
/// Where the axes begin.
const AXIS: i32 = 64;
/// The end of the axis: errors below this share have a place of their own.
const LEAST: f64 = 1e-4;

type ErrorOf = fn(&Rung) -> Option<Spread>;

/// Panels: a title, and the errors, in the order of [`Rung::claimed`].
const PANELS: [(&str, ErrorOf); 4] = [
    ("Cycles", |rung| rung.cycles),
    ("Bytes between L1s and L2", |rung| rung.l2_bytes),
    ("DRAM bytes", |rung| rung.dram_bytes),
    ("Share of cycles that a policy saves", |rung| rung.saving),
];

pub(super) const PLOT: Plot<ParetoReport> =
    Plot { name: "pareto", section: (), figure: |report| Some(figure(&report.summary, &report.timings)) };

/// Names the fastest level whose worst error of cycles is at most 2 %.
pub(super) fn finding(summary: &ParetoSummary, timings: &[Timing]) -> String {
    let levels = summary.rungs.iter().zip(timings.iter().skip(1));
    let close = levels.filter(|(rung, _)| rung.cycles.is_some_and(|spread| spread.worst <= 0.02));
    let fastest = close.filter_map(|(rung, timing)| Some((rung, timing.times()?, rung.cycles?)));
    match fastest.max_by(|a, b| a.1.total_cmp(&b.1)) {
        Some((rung, times, error)) => format!(
            "{} is {times:.1} times as fast as {}, and at most {} off in cycles",
            rung.name,
            summary.truth,
            percent(error.worst)
        ),
        None => format!("No level is within 2 % of {} in all runs", summary.truth),
    }
}

fn figure<'a>(summary: &'a ParetoSummary, timings: &'a [Timing]) -> Figure<'a> {
    let row = |(rung, timing): (&Rung, &Timing)| {
        let shown = |value: Option<f64>| value.map_or_else(String::new, number);
        let errors = PANELS.iter().flat_map(|(_, of)| {
            let spread = of(rung);
            [spread.map(|it| it.mean), spread.map(|it| it.worst)].map(shown)
        });
        [rung.name.clone(), shown(timing.speed())].into_iter().chain(errors).collect()
    };
    let names = ["cycles", "L2 bytes", "DRAM bytes", "saving"];
    let errors = names.into_iter().flat_map(|name| [format!("{name}, mean"), format!("{name}, worst")]);
    Figure {
        title: finding(summary, timings),
        about: format!(
            "Error against {} over the simulator's speed. Mark: mean of all runs; line up: the worst; bar across: \
             half the 95 % interval that the level claims; hollow: it claims nothing; ring: no level is faster and \
             closer.",
            summary.truth
        ),
        key: Vec::new(),
        data: Grid {
            head: ["level".to_owned(), "rays/s".to_owned()].into_iter().chain(errors).collect(),
            names: 1,
            rows: summary.rungs.iter().zip(timings.iter().skip(1)).map(row).collect(),
        },
        narrow: true,
        height: Box::new(|_| PANELS.len() as i32 * (ABOVE + PANEL + NONE + BELOW)),
        paint: Box::new(move |canvas| {
            let speeds = timings.iter().filter_map(Timing::speed);
            let slowest = speeds.clone().fold(f64::INFINITY, f64::min).log10().floor();
            let fastest = speeds.fold(1.0, f64::max).log10().ceil().max(slowest + 1.0);
            PANELS.into_iter().zip(0..).try_for_each(|((title, error), index)| {
                let top = index * (ABOVE + PANEL + NONE + BELOW) + ABOVE;
                Panel { canvas, top, slowest, fastest }.draw(title, summary, timings, error, index as usize)
            })
        }),
    }
}

struct Panel<'a, 'svg> {
    canvas: &'a Canvas<'svg>,
    top: i32,
    /// Logarithms of the speeds at both ends.
    slowest: f64,
    fastest: f64,
}

impl Panel<'_, '_> {
    fn x(&self, speed: f64) -> i32 {
        let width = f64::from(self.canvas.width() - 24 - AXIS);
        AXIS + ((speed.log10() - self.slowest) / (self.fastest - self.slowest) * width).round() as i32
    }

    /// The height of an error: from 1 to [`LEAST`] on a logarithmic scale, and below that in a place of its own.
    fn y(&self, error: f64) -> i32 {
        if error < LEAST {
            return self.top + PANEL + NONE / 2 + 4;
        }
        self.top + (error.min(1.0).log10() / LEAST.log10() * f64::from(PANEL)).round() as i32
    }

    fn draw(
        &self,
        title: &str,
        summary: &ParetoSummary,
        timings: &[Timing],
        error: ErrorOf,
        claimed: usize,
    ) -> Result<(), DrawError> {
        let (canvas, end) = (self.canvas, self.canvas.width() - 24);
        let bottom = self.top + PANEL + NONE;
        canvas.text(title, (LEFT, self.top - 34), Text::LABEL.bold())?;
        for share in [1.0, 0.1, 0.01, 0.001, LEAST] {
            let y = self.y(share);
            canvas.line(vec![(AXIS, y), (end, y)], GRID, 1)?;
            canvas.text(&percent(share), (AXIS - 8, y), Text::NOTE.right())?;
        }
        canvas.text("less", (AXIS - 8, self.y(0.0)), Text::NOTE.right())?;
        for decade in self.slowest as i32..=self.fastest as i32 {
            let (speed, x) = (10f64.powi(decade), self.x(10f64.powi(decade)));
            canvas.line(vec![(x, self.top), (x, bottom)], GRID, 1)?;
            canvas.text(&tick(speed), (x, bottom + 14), Text::NOTE.centered())?;
        }
        canvas.text("rays simulated a second", (end, bottom + 14 + LINE - 4), Text::NOTE.right())?;
        let mut names = Names::default();
        if let Some(truth) = timings.first().and_then(Timing::speed) {
            let x = self.x(truth);
            canvas.line(vec![(x, self.top), (x, bottom)], FAINT, 1)?;
            let half = Text::NOTE.width(&summary.truth) / 2;
            canvas.text(&summary.truth, (x.clamp(half, end - half), self.top - 12), Text::NOTE.centered())?;
        }
        let frontier = summary.frontier(timings, error);
        let levels = || summary.rungs.iter().zip(timings.iter().skip(1)).enumerate();
        let place = |(rung, timing): (&Rung, &Timing)| Some((self.x(timing.speed()?), self.y(error(rung)?.mean)));
        levels().filter_map(|(_, level)| place(level)).for_each(|at| names.point(at));
        for (index, (rung, timing)) in levels() {
            let (Some(Spread { worst, .. }), Some((x, y))) = (error(rung), place((rung, timing))) else { continue };
            let (color, width) = (series_color(index), rung.claimed.and_then(|widths| widths[claimed]));
            if frontier[index] {
                canvas.ring((x, y), 10, INK, 1)?;
            }
            canvas.line(vec![(x, y), (x, self.y(worst))], color, 2)?;
            mark(canvas, index, (x, y), color, width.is_some())?;
            if let Some(width) = width {
                let y = self.y(width);
                canvas.line(vec![(x - 7, y), (x + 7, y)], color, 2)?;
            }
            names.write(canvas, &rung.name, (x + 6, y))?;
        }
        Ok(())
    }
}
