//! Error of the rungs over their speed: mean and worst, what they claim, and which none beats.

use super::data::ParetoSummary;
use super::level::{Rung, Spread};
use super::report::ParetoReport;
use super::timing::Timing;
use crate::report::draw::Plot;
use crate::report::draw::canvas::{
    Canvas, DrawError, LEFT, LINE, TITLES, Text, WIDTH, legend_height, palette, policy_color, svg,
};
use crate::report::format::{percent, tick};

/// Height of a panel's axes, and of what stands above and below them.
const PANEL: i32 = 170;
const ABOVE: i32 = 34;
const BELOW: i32 = 52;
/// Where the axes begin and end.
const AXIS: i32 = 76;
const END: i32 = WIDTH - 24;
/// Errors below this share are drawn as this one.
const LEAST: f64 = 1e-4;

type Figure = fn(&Rung) -> Option<Spread>;

/// Panels: a title, and the errors, in the order of what rungs claim.
const PANELS: [(&str, Figure); 4] = [
    ("Cycles", |rung| rung.cycles),
    ("Bytes between L1s and L2", |rung| rung.l2_bytes),
    ("DRAM bytes", |rung| rung.dram_bytes),
    ("Share of cycles saved by a policy (difference of shares)", |rung| rung.saving),
];

pub(super) const PLOT: Plot<ParetoReport> =
    Plot { name: "pareto", section: (), draw: |report| draw(&report.summary, &report.timings).map(Some) };

fn draw(summary: &ParetoSummary, timings: &[Timing]) -> Result<String, DrawError> {
    let legend: Vec<_> = summary
        .rungs
        .iter()
        .enumerate()
        .map(|(index, rung)| {
            let orders = match rung.disagreements.len() {
                0 => String::new(),
                count => format!(" (another order {count} times)"),
            };
            (format!("{}{orders}", rung.name), policy_color(index))
        })
        .collect();
    let top = TITLES + legend_height(&legend);
    let title = format!("Error against {}, over speed", summary.truth);
    svg(top + PANELS.len() as i32 * (ABOVE + PANEL + BELOW), |canvas| {
        canvas.titles(
            &title,
            "dot: mean of all runs, line up: worst, tick: half the 95 % interval that the rung claims, ring: no rung is faster and closer",
        )?;
        canvas.legend(TITLES, &legend)?;
        let speeds = timings.iter().filter_map(Timing::speed);
        let slowest = speeds.clone().fold(f64::INFINITY, f64::min).log10().floor();
        let fastest = speeds.fold(1.0, f64::max).log10().ceil().max(slowest + 1.0);
        PANELS.into_iter().zip(0..).try_for_each(|((title, figure), panel)| {
            let top = top + panel * (ABOVE + PANEL + BELOW) + ABOVE;
            Panel { canvas, top, slowest, fastest }.draw(title, summary, timings, figure, panel as usize)
        })
    })
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
        AXIS + ((speed.log10() - self.slowest) / (self.fastest - self.slowest) * f64::from(END - AXIS)).round() as i32
    }

    /// The height of an error, from [`LEAST`] to 1 on a logarithmic scale.
    fn y(&self, error: f64) -> i32 {
        let share = error.clamp(LEAST, 1.0).log10() / LEAST.log10();
        self.top + (share * f64::from(PANEL)).round() as i32
    }

    fn draw(
        &self,
        title: &str,
        summary: &ParetoSummary,
        timings: &[Timing],
        figure: Figure,
        claimed: usize,
    ) -> Result<(), DrawError> {
        let (canvas, bottom) = (self.canvas, self.top + PANEL);
        canvas.text(title, (LEFT, self.top - 20), Text::LABEL.bold())?;
        for error in [1.0, 0.1, 0.01, 0.001, LEAST] {
            let y = self.y(error);
            canvas.line(vec![(AXIS, y), (END, y)], palette::GRID, 1)?;
            canvas.text(&percent(error), (AXIS - 8, y), Text::NOTE.right())?;
        }
        for decade in self.slowest as i32..=self.fastest as i32 {
            let (speed, x) = (10f64.powi(decade), self.x(10f64.powi(decade)));
            canvas.line(vec![(x, self.top), (x, bottom)], palette::GRID, 1)?;
            canvas.text(&tick(speed), (x, bottom + 14), Text::NOTE.centered())?;
        }
        canvas.text("rays simulated a second", (END, bottom + 14 + LINE - 2), Text::NOTE.right())?;
        if let Some(truth) = timings.first().and_then(Timing::speed) {
            let x = self.x(truth);
            canvas.line(vec![(x, self.top), (x, bottom)], palette::FAINT, 1)?;
            canvas.text(&summary.truth, (x, self.top - 8), Text::NOTE.centered())?;
        }
        let frontier = summary.frontier(timings, figure);
        for (index, ((rung, timing), best)) in
            summary.rungs.iter().zip(timings.iter().skip(1)).zip(frontier).enumerate()
        {
            let (Some(Spread { mean, worst }), Some(speed)) = (figure(rung), timing.speed()) else { continue };
            let (x, color) = (self.x(speed), policy_color(index));
            if best {
                canvas.dot((x, self.y(mean)), 8, palette::INK)?;
                canvas.dot((x, self.y(mean)), 6, palette::PAPER)?;
            }
            canvas.line(vec![(x, self.y(mean)), (x, self.y(worst))], color, 2)?;
            canvas.dot((x, self.y(mean)), 4, color)?;
            if let Some(width) = rung.claimed.and_then(|widths| widths[claimed]) {
                let y = self.y(width);
                canvas.line(vec![(x - 7, y), (x + 7, y)], color, 2)?;
            }
        }
        Ok(())
    }
}
