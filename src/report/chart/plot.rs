//! Saving against error over several runs: exact policies side by side, the others over their wrong decisions.

use super::data::{ChartSummary, Point};
use crate::report::draw::canvas::{Canvas, DrawError, LEFT, LINE, Text, WIDE};
use crate::report::draw::palette::{Color, FAINT, GRID, INK, PAPER, series_color};
use crate::report::draw::{Figure, Plot};
use crate::report::format::{percent, percent_tick, tick};

/// Height of a panel's axes, and of the parts above and below them.
const PANEL: i32 = 190;
const ABOVE: i32 = 34;
const BELOW: i32 = 54;
/// The columns where the axes begin and end.
const AXIS: i32 = 76;
const END: i32 = WIDE - 20;
/// Where the axis of wrong decisions begins, and the width of its place for points without a wrong decision.
const SPLIT: i32 = 640;
const NONE: i32 = 64;

type Share = fn(&Point) -> Option<f64>;

const PANELS: [(&str, Share); 3] = [
    ("Node visits saved", |point| point.traversal_saved),
    ("Triangle tests saved", |point| point.intersection_saved),
    ("All accesses on account of shadows saved", |point| point.accesses_saved),
];

pub(super) const PLOT: Plot<ChartSummary> =
    Plot { name: "saving-against-error", section: (), figure: |chart| Some(figure(chart)) };

/// Names the policy that saves most without a wrong decision, over all runs.
pub(crate) fn finding(chart: &ChartSummary) -> String {
    let points = |policy: &str| -> Vec<&Point> { chart.points.iter().filter(|point| point.policy == policy).collect() };
    let mean = |policy: &String| {
        let shares: Vec<f64> = points(policy).iter().filter_map(|point| point.traversal_saved).collect();
        (!shares.is_empty()).then(|| shares.iter().sum::<f64>() / shares.len() as f64)
    };
    let right = chart.policies.iter().filter(|policy| points(policy).iter().all(|point| point.wrong == 0));
    let right = right.filter_map(|policy| Some((policy, mean(policy)?)));
    right.max_by(|a, b| a.1.total_cmp(&b.1)).map_or("Every policy here is sometimes wrong".into(), |(policy, saved)| {
        if saved <= 0.0 {
            return "No policy here saves node visits without a wrong decision".into();
        }
        format!("Without a wrong decision, {policy} saves most: {} of the node visits on average", percent(saved))
    })
}

fn figure(chart: &ChartSummary) -> Figure<'_> {
    let is_exact = |policy: &&String| !chart.points.iter().any(|point| point.policy == **policy && point.wrong > 0);
    let (exact, wrong): (Vec<&String>, Vec<&String>) = chart.policies.iter().partition(is_exact);
    let key = chart.experiments.iter().enumerate().map(|(index, name)| (name.clone(), series_color(index))).collect();
    Figure {
        title: finding(chart),
        about: "Share of the work of shadow rays saved, against the run without culling, mean of the frames. Left: \
                policies that are never wrong. Right: the others over their wrong decisions, which have a place of \
                their own for none."
            .into(),
        key,
        data: chart.grid(),
        narrow: false,
        height: Box::new(|_| PANELS.len() as i32 * (ABOVE + PANEL + BELOW)),
        paint: Box::new(move |canvas| {
            PANELS.into_iter().zip(0..).try_for_each(|((title, share), panel)| {
                let top = panel * (ABOVE + PANEL + BELOW) + ABOVE;
                Panel { canvas, chart, top, share, low: low(chart, share) }.draw(title, &exact, &wrong)
            })
        }),
    }
}

/// The lower end of the axis: 0, or the fifth below the lowest share, but not below -1.
fn low(chart: &ChartSummary, share: Share) -> f64 {
    let least = chart.points.iter().filter_map(share).fold(0.0, f64::min);
    ((least * 5.0).floor() / 5.0).max(-1.0)
}

struct Panel<'a, 'svg> {
    canvas: &'a Canvas<'svg>,
    chart: &'a ChartSummary,
    top: i32,
    share: Share,
    low: f64,
}

impl Panel<'_, '_> {
    /// The height of a share.
    fn y(&self, share: f64) -> i32 {
        self.top + ((1.0 - share.max(self.low)) / (1.0 - self.low) * f64::from(PANEL)).round() as i32
    }

    fn draw(&self, title: &str, exact: &[&String], wrong: &[&String]) -> Result<(), DrawError> {
        let (canvas, bottom) = (self.canvas, self.top + PANEL);
        canvas.text(title, (LEFT, self.top - 20), Text::LABEL.bold())?;
        let lowest = (self.low * 5.0).round() as i32;
        for fifth in lowest..=5 {
            let y = self.y(f64::from(fifth) / 5.0);
            let color = if fifth == 0 { FAINT } else { GRID };
            canvas.line(vec![(AXIS, y), (SPLIT - 24, y)], color, 1)?;
            canvas.line(vec![(SPLIT, y), (END, y)], color, 1)?;
            canvas.text(&percent_tick(f64::from(fifth) / 5.0), (AXIS - 8, y), Text::NOTE.right())?;
        }
        let column = (SPLIT - 24 - AXIS) / exact.len().max(1) as i32;
        for (place, policy) in (0..).zip(exact) {
            let middle = AXIS + place * column + column / 2;
            canvas.text(policy, (middle, bottom + 14), Text::NOTE.colored(INK).centered())?;
            let step = (column - 16) / self.chart.experiments.len().max(1) as i32;
            let first = middle - step * (self.chart.experiments.len() as i32 - 1) / 2;
            self.points(policy, |index, _| first + step * index as i32, dot)?;
        }
        self.errors(wrong, bottom)
    }

    /// Draws the policies with wrong decisions over the logarithm of their number per million shadow rays.
    fn errors(&self, policies: &[&String], bottom: i32) -> Result<(), DrawError> {
        if policies.is_empty() {
            return Ok(());
        }
        let canvas = self.canvas;
        let most = self.chart.points.iter().map(|point| point.wrong_per_million).fold(10.0, f64::max);
        let decades = most.log10().ceil() as i32;
        let width = (END - 12 - SPLIT - NONE) / decades;
        let x = |wrong: f64| match wrong {
            0.0 => SPLIT + NONE / 2 - 6,
            wrong => SPLIT + NONE + (wrong.log10().max(0.0) * f64::from(width)).round() as i32,
        };
        canvas.text("none", (x(0.0), bottom + 14), Text::NOTE.centered())?;
        for decade in 0..=decades {
            let (wrong, at) = (10f64.powi(decade), SPLIT + NONE + decade * width);
            canvas.line(vec![(at, self.top), (at, bottom)], GRID, 1)?;
            canvas.text(&tick(wrong), (at, bottom + 14), Text::NOTE.centered())?;
        }
        let marks: [(&str, Mark); 3] = [("\u{25cf}", dot), ("\u{25a0}", square), ("\u{25cb}", ring)];
        let mut names = Vec::new();
        for (policy, (sign, mark)) in policies.iter().zip(marks.into_iter().cycle()) {
            names.push(format!("{sign} {policy}"));
            self.points(policy, |_, point| x(point.wrong_per_million), mark)?;
        }
        let middle = (SPLIT + END) / 2;
        canvas.text(
            "wrong decisions a million shadow rays",
            (middle, bottom + 14 + LINE - 2),
            Text::NOTE.centered(),
        )?;
        canvas.text(&names.join("   "), (END, self.top - 20), Text::NOTE.colored(INK).right())
    }

    fn points(&self, policy: &str, x: impl Fn(usize, &Point) -> i32, mark: Mark) -> Result<(), DrawError> {
        for point in self.chart.points.iter().filter(|point| point.policy == policy) {
            let experiment = self.chart.experiments.iter().position(|name| *name == point.experiment);
            if let (Some(index), Some(share)) = (experiment, (self.share)(point)) {
                mark(self.canvas, (x(index, point), self.y(share)), series_color(index))?;
            }
        }
        Ok(())
    }
}

type Mark = fn(&Canvas<'_>, (i32, i32), Color) -> Result<(), DrawError>;

fn dot(canvas: &Canvas<'_>, at: (i32, i32), color: Color) -> Result<(), DrawError> {
    canvas.dot(at, 5, color)
}

fn square(canvas: &Canvas<'_>, (x, y): (i32, i32), color: Color) -> Result<(), DrawError> {
    canvas.rect((x - 4, y - 4), (x + 4, y + 4), color)
}

fn ring(canvas: &Canvas<'_>, at: (i32, i32), color: Color) -> Result<(), DrawError> {
    canvas.dot(at, 5, color)?;
    canvas.dot(at, 3, PAPER)
}
