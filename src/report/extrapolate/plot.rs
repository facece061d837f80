//! Scale models and what they predict: a row of panels a machine, a panel a figure, over the cores of the models.

use super::data::{Extrapolation, Extrapolations, Prediction};
use super::words::grid;
use crate::quantity::Bytes;
use crate::report::draw::canvas::{Canvas, DrawError, LEFT, LINE, Text, is_narrow, tick_step};
use crate::report::draw::marks::mark;
use crate::report::draw::palette::{BLUE, GRID, SKY, VERMILLION, pale};
use crate::report::draw::{Figure, Plot};
use crate::report::format::{bytes, exact, joules, percent, tick};
use crate::report::grid::Grid;

/// Height of a panel's axes, of what stands above and below them, and of a machine's name.
const PANEL: i32 = 150;
const ABOVE: i32 = 34;
const BELOW: i32 = 34;
const NAME: i32 = 26;
/// Where the axes of a panel begin, and the room behind them and beside their first and last point.
const AXIS: i32 = 70;
const BEHIND: i32 = 14;
const BESIDE: i32 = 16;

pub(super) const PLOT: Plot<Extrapolations> =
    Plot { name: "models", section: (), figure: |found| Some(figure(&found.0)) };

/// What the largest machine would take; where predictions of cycles were checked, how far off they are.
pub(super) fn finding(found: &[Extrapolation]) -> String {
    let off = found.iter().filter_map(|it| it.errors()?[0]).max_by(|a, b| a.abs().total_cmp(&b.abs()));
    if let (Some(off), true) = (off, found.len() > 1) {
        return format!("Predictions of cycles are at most {} off what Event says", percent(off.abs()));
    }
    let Some(largest) = found.iter().max_by_key(|it| it.cores) else { return "No machine".into() };
    let told = format!("{} would take {} cycles", largest.name(), exact(largest.predicted.cycles.value.round() as u64));
    let than =
        off.map(|off| format!(", {} {} than by Event", percent(off.abs()), if off < 0.0 { "fewer" } else { "more" }));
    told + &than.unwrap_or_default()
}

/// How a figure is shown.
type Shown = fn(f64) -> String;

/// A figure of a machine and of its models.
struct Panel {
    name: &'static str,
    /// Of each model, the smallest first: its cores, and what it stands for.
    models: Vec<(u64, f64)>,
    /// Cores of the large machine.
    cores: u64,
    told: Prediction,
    truth: Option<f64>,
    shown: Shown,
}

/// The figures of a machine; that of its energy if that is known.
fn panels(found: &Extrapolation) -> Vec<Panel> {
    let names: [(_, Shown); 3] =
        [("cycles", tick), ("L2 bytes", |it| bytes(Bytes(it as u64))), ("DRAM bytes", |it| bytes(Bytes(it as u64)))];
    let counts = names.into_iter().enumerate().map(|(at, (name, shown))| Panel {
        name,
        models: found.models.iter().map(|model| (model.cores, model.figures.all()[at])).collect(),
        cores: found.cores,
        told: found.predicted.all()[at],
        truth: found.checked.map(|checked| checked.all()[at] as f64),
        shown,
    });
    let of_models = found.models.iter().map(|model| Some((model.cores, model.joules?))).collect::<Option<Vec<_>>>();
    let energy = found.joules.zip(of_models).map(|(told, models)| Panel {
        name: "energy",
        models,
        cores: found.cores,
        told,
        truth: found.checked_joules,
        shown: joules,
    });
    counts.chain(energy).collect()
}

/// Panels beside each other on a sheet of this width.
fn columns(width: i32) -> i32 {
    if is_narrow(width) { 1 } else { 4 }
}

fn figure(found: &[Extrapolation]) -> Figure<'_> {
    let rows = |found: &Extrapolation, width: i32| (panels(found).len() as i32 + columns(width) - 1) / columns(width);
    let height = move |found: &Extrapolation, width: i32| NAME + rows(found, width) * (ABOVE + PANEL + BELOW);
    Figure {
        title: finding(found),
        about: "Each model counts as many times as its share of the machine asks for, so that it stands for all of \
                it. The law is the line through the two largest models, over the inverse of the cores: the large \
                machine is at the left. The pale bar reaches as far as other laws."
            .into(),
        key: vec![
            ("models, and the law".to_owned(), SKY),
            ("predicted".to_owned(), BLUE),
            ("by Event".to_owned(), VERMILLION),
        ],
        data: data(found),
        narrow: true,
        height: Box::new(move |width| found.iter().map(|it| height(it, width)).sum()),
        paint: Box::new(move |canvas| {
            let (width, columns) = (canvas.width(), columns(canvas.width()));
            let mut top = 0;
            for machine in found {
                canvas.text(&format!("{}, {}", machine.name(), machine.policy), (LEFT, top + LINE / 2), Text::TITLE)?;
                for (place, panel) in (0..).zip(panels(machine)) {
                    let left = place % columns * (width / columns);
                    let at = (left, top + NAME + place / columns * (ABOVE + PANEL + BELOW));
                    panel.draw(canvas, at, width / columns)?;
                }
                top += height(machine, width);
            }
            Ok(())
        }),
    }
}

impl Panel {
    fn draw(&self, canvas: &Canvas<'_>, (left, top): (i32, i32), width: i32) -> Result<(), DrawError> {
        let (begin, end, top) = (left + AXIS, left + width - BEHIND, top + ABOVE);
        let bottom = top + PANEL;
        // Over one over the cores, from the large machine on.
        let from_large = |cores: u64| 1.0 / cores as f64 - 1.0 / self.cores as f64;
        let farthest = self.models.iter().map(|&(cores, _)| from_large(cores)).fold(0.0, f64::max);
        let room = f64::from(end - begin - 2 * BESIDE);
        let x = |cores: u64| begin + BESIDE + (from_large(cores) / farthest * room).round() as i32;
        let all = self.models.iter().map(|&(_, value)| value).chain([self.told.high]).chain(self.truth);
        let most = all.fold(0.0, f64::max);
        if most == 0.0 {
            return canvas.text(&format!("{}: none", self.name), (left + LEFT, top - 18), Text::LABEL.bold());
        }
        let y = |value: f64| bottom - (value / most * f64::from(PANEL)).round() as i32;
        canvas.text(self.name, (left + LEFT, top - 18), Text::LABEL.bold())?;
        let step = tick_step(most, 4);
        for line in 0..=(most / step) as i32 {
            let value = f64::from(line) * step;
            canvas.line(vec![(begin, y(value)), (end, y(value))], GRID, 1)?;
            let text = if line == 0 { "0".into() } else { (self.shown)(value) };
            canvas.text(&text, (begin - 6, y(value)), Text::NOTE.right())?;
        }
        let large = x(self.cores);
        canvas.rect((large - 4, y(self.told.high)), (large + 4, y(self.told.low)), pale(BLUE))?;
        let second = self.models.iter().rev().nth(1).map(|&(cores, value)| (x(cores), y(value)));
        canvas.line([(large, y(self.told.value))].into_iter().chain(second).collect(), SKY, 2)?;
        for &(cores, value) in &self.models {
            mark(canvas, 0, (x(cores), y(value)), SKY, true)?;
            canvas.text(&cores.to_string(), (x(cores), bottom + 14), Text::NOTE.centered())?;
        }
        canvas.text(&self.cores.to_string(), (large, bottom + 14), Text::NOTE.centered())?;
        mark(canvas, 0, (large, y(self.told.value)), BLUE, true)?;
        self.truth.map_or(Ok(()), |truth| mark(canvas, 3, (large, y(truth)), VERMILLION, false))
    }
}

/// The tables of all machines, one below the other.
fn data(found: &[Extrapolation]) -> Grid {
    let grids: Vec<Grid> = found.iter().map(grid).collect();
    let names = grids.first().map_or_else(Vec::new, |grid| grid.head[1..].to_vec());
    let rows = grids.into_iter().flat_map(|Grid { head, rows, .. }| {
        let machine = head[0].clone();
        rows.into_iter().map(move |row| [machine.clone()].into_iter().chain(row).collect())
    });
    Grid {
        head: ["machine, policy", "of"].map(String::from).into_iter().chain(names).collect(),
        names: 2,
        rows: rows.collect(),
    }
}
