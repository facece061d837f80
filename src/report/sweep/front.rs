//! Cycles against DRAM bytes of all points, and the points that no other beats in both.

use super::data::{SweepPoint, SweepSummary};
use super::fields::fields;
use crate::report::draw::canvas::{Canvas, DrawError, LEFT, LINE, Text};
use crate::report::draw::marks::{Names, mark, whisker};
use crate::report::draw::palette::{FAINT, GRID, INK, series_color};
use crate::report::draw::ticks::Ticks;
use crate::report::draw::{Figure, Plot};
use crate::report::format::{counted, number, percent_tick};
use crate::report::grid::Grid;
use crate::report::split::{Shift, change_within};

const PANEL: i32 = 300;
const AXIS: i32 = 62;
const BELOW: i32 = 54;
/// The lower end of the upright axis.
const BOTTOM: i32 = LINE + PANEL;
/// The most points in a plot; of the points beyond, only unbeaten ones are drawn.
const MOST: usize = 2_000;

pub(super) const PLOT: Plot<SweepSummary> = Plot { name: "front", section: (), figure };

/// A point's changes of cycles and DRAM bytes against the same machine without culling. For a figure that is 0
/// without culling, the number with culling stands in.
fn place(point: &SweepPoint) -> [Shift; 2] {
    let [cycles, bytes] = point.split.shifts();
    let all = |number: u64| Shift { share: number as f64, half_width: None };
    [cycles.unwrap_or(all(point.split.cycles[2])), bytes.unwrap_or(all(point.split.dram[2].0))]
}

/// For each point, whether no other point of the same machine and policy beats it in both figures.
fn unbeaten(points: &[(usize, &SweepPoint)]) -> Vec<bool> {
    let mut order: Vec<usize> = (0..points.len()).collect();
    let at = |index: usize| {
        let [cycles, bytes] = place(points[index].1);
        (points[index].0, (cycles.share, bytes.share))
    };
    order.sort_by(|&a, &b| {
        let ((of_a, (x, y)), (of_b, (u, v))) = (at(a), at(b));
        of_a.cmp(&of_b).then(x.total_cmp(&u)).then(y.total_cmp(&v))
    });
    let mut best = vec![false; points.len()];
    let mut before: Option<(usize, (f64, f64))> = None;
    for index in order {
        let (series, found) = at(index);
        let beats = before.is_none_or(|(other, least)| other != series || found.1 < least.1 || found == least);
        best[index] = beats;
        if beats {
            before = Some((series, found));
        }
    }
    best
}

/// The points of a sweep by machine and policy.
struct Front<'s> {
    /// The series: machine and policy.
    names: Vec<String>,
    /// Each point with its series.
    points: Vec<(usize, &'s SweepPoint)>,
    /// For each point, whether it is unbeaten.
    best: Vec<bool>,
    is_sampled: bool,
}

fn figure(summary: &SweepSummary) -> Option<Figure<'_>> {
    if fields(summary).len() < 2 || summary.points.len() < 4 {
        return None;
    }
    let front = Front::new(&summary.points);
    let labels = front.names.len() as i32 * LINE;
    Some(Figure {
        title: front.title()?,
        about: front.about(),
        key: Vec::new(),
        data: front.data(),
        narrow: true,
        height: Box::new(move |_| PANEL + BELOW + LINE + labels),
        paint: Box::new(move |canvas| front.paint(canvas)),
    })
}

impl<'s> Front<'s> {
    fn new(all: &'s [SweepPoint]) -> Self {
        let mut names: Vec<String> = Vec::new();
        let mut points: Vec<(usize, &SweepPoint)> = Vec::new();
        for point in all {
            let name = format!("{}, {}", point.machine, point.policy);
            let series = names.iter().position(|other| *other == name).unwrap_or_else(|| {
                names.push(name);
                names.len() - 1
            });
            points.push((series, point));
        }
        let is_sampled = all.iter().any(|point| point.split.half_widths.is_some());
        Self { names, best: unbeaten(&points), points, is_sampled }
    }

    /// `None` without points.
    fn title(&self) -> Option<String> {
        let cycles = |point: &SweepPoint| place(point)[0];
        let (_, best) = self.points.iter().min_by(|a, b| cycles(a.1).share.total_cmp(&cycles(b.1).share)).copied()?;
        Some(format!(
            "{} of {} are unbeaten; the best change of cycles by culling has {} on {} ({})",
            self.best.iter().filter(|best| **best).count(),
            counted(self.points.len(), "point"),
            best.label(),
            best.machine,
            change_within(1.0, 1.0 + cycles(best).share, cycles(best).half_width)
        ))
    }

    fn about(&self) -> String {
        let intervals =
            " Lines through marks: 95 % intervals, within which either of two points may be the better one.";
        format!(
            "Change of cycles and of DRAM bytes by culling, against the same machine without. Ringed and named: no \
             point of the machine and policy is better in both.{}",
            if self.is_sampled { intervals } else { "" }
        )
    }

    fn data(&self) -> Grid {
        let row = |((series, point), best): (&(usize, &SweepPoint), &bool)| {
            let place = place(point);
            let shares = place.map(|it| number(it.share));
            let halves = place.map(|it| it.half_width.map_or_else(String::new, number));
            let names = [self.names[*series].clone(), point.label()].into_iter().chain(shares);
            let best = if *best { "yes" } else { "no" }.to_owned();
            names.chain([best]).chain(halves.into_iter().filter(|_| self.is_sampled)).collect()
        };
        let halves = ["half width of cycles", "half width of DRAM bytes"].into_iter().filter(|_| self.is_sampled);
        let head = ["machine, policy", "point", "change of cycles", "change of DRAM bytes", "unbeaten"];
        Grid {
            head: head.into_iter().chain(halves).map(Into::into).collect(),
            names: 2,
            rows: self.points.iter().zip(&self.best).map(row).collect(),
        }
    }

    fn paint(&self, canvas: &Canvas<'_>) -> Result<(), DrawError> {
        let axes = Axes::new(canvas.width(), &self.points);
        axes.draw(canvas)?;
        let mut names_of = Names::default();
        // The texts of the axis.
        names_of.keep(((AXIS, BOTTOM), (axes.end, BOTTOM + LINE)));
        for (series, point) in self.points.iter().filter(|_| self.is_sampled && self.points.len() <= MOST) {
            for ends in axes.intervals(point).map(Into::into) {
                whisker(canvas, ends, series_color(*series))?;
                names_of.keep(ends);
            }
        }
        self.points.iter().take(MOST).for_each(|(_, point)| names_of.point(axes.at(point)));
        let drawn = self.points.iter().zip(&self.best).enumerate();
        for (_, ((series, point), best)) in drawn.filter(|(index, (_, best))| **best || *index < MOST) {
            mark(canvas, *series, axes.at(point), series_color(*series), *best)?;
            if *best {
                canvas.ring(axes.at(point), 9, INK, 1)?;
                names_of.write(canvas, &point.label(), axes.at(point))?;
            }
        }
        for (index, name) in self.names.iter().enumerate() {
            let y = BOTTOM + BELOW + index as i32 * LINE;
            mark(canvas, index, (LEFT + 7, y), series_color(index), true)?;
            canvas.text(name, (LEFT + 20, y), Text::LABEL)?;
        }
        Ok(())
    }
}

/// The axes: change of cycles across, of DRAM bytes upright.
struct Axes {
    xs: Ticks,
    ys: Ticks,
    /// The right end.
    end: i32,
}

impl Axes {
    fn new(width: i32, points: &[(usize, &SweepPoint)]) -> Self {
        let [xs, ys] = [0, 1].map(|axis| Ticks::around(points.iter().flat_map(|(_, point)| place(point)[axis].ends())));
        Self { xs, ys, end: width - 16 }
    }

    fn x(&self, share: f64) -> i32 {
        AXIS + (self.xs.place(share) * f64::from(self.end - AXIS)).round() as i32
    }

    fn y(&self, share: f64) -> i32 {
        BOTTOM - (self.ys.place(share) * f64::from(PANEL)).round() as i32
    }

    /// The place of a point.
    fn at(&self, point: &SweepPoint) -> (i32, i32) {
        let [cycles, bytes] = place(point);
        (self.x(cycles.share), self.y(bytes.share))
    }

    /// The ends of a point's intervals, across and upright.
    fn intervals(&self, point: &SweepPoint) -> [[(i32, i32); 2]; 2] {
        let ((left, top), [cycles, bytes]) = (self.at(point), place(point).map(Shift::ends));
        [cycles.map(|share| (self.x(share), top)), bytes.map(|share| (left, self.y(share)))]
    }

    fn draw(&self, canvas: &Canvas<'_>) -> Result<(), DrawError> {
        canvas.text("DRAM bytes", (LEFT, 8), Text::NOTE)?;
        canvas.text("cycles", (self.end, BOTTOM + 34), Text::NOTE.right())?;
        let color = |share: f64| if share.abs() < 1e-9 { FAINT } else { GRID };
        for share in self.xs.shares() {
            let x = self.x(share);
            canvas.line(vec![(x, LINE), (x, BOTTOM)], color(share), 1)?;
            canvas.text(&percent_tick(share), (x, BOTTOM + 14), Text::NOTE.centered())?;
        }
        for share in self.ys.shares() {
            let y = self.y(share);
            canvas.line(vec![(AXIS, y), (self.end, y)], color(share), 1)?;
            canvas.text(&percent_tick(share), (AXIS - 8, y), Text::NOTE.right())?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::run::tests::sample::sweep;
    use crate::report::sweep::data::Change;

    /// The sentence that names the fastest point gives its interval too.
    #[test]
    fn samples_have_intervals_and_what_is_exact_has_none() {
        let mut summary = sweep();
        let change = Change { field: "shadow_cache.count".into(), value: "2".into() };
        let more = [1, 1].map(|at| SweepPoint { changes: vec![change.clone()], ..summary.points[at].clone() });
        summary.points.extend(more);
        let told = |summary: &SweepSummary| {
            let figure = figure(summary).unwrap();
            assert!(figure.data.rows.iter().all(|row| row.len() == figure.data.head.len()), "{:?}", figure.data.rows);
            (figure.title.contains('\u{b1}'), figure.about.contains("intervals"), figure.data.head.len())
        };
        assert_eq!(told(&summary), (true, true, 7));
        summary.points.iter_mut().for_each(|point| point.split.half_widths = None);
        assert_eq!(told(&summary), (false, false, 5));
    }

    #[test]
    fn without_culling_there_may_be_nothing() {
        let mut point = sweep().points.remove(0);
        let bytes = |point: &SweepPoint| place(point)[1].share;
        assert!(bytes(&point).abs() < 10.0);
        (point.split.dram[0].0, point.split.dram[2].0) = (0, 0);
        assert_eq!(bytes(&point), 0.0, "nothing changes");
    }
}
