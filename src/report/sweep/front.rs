//! Cycles against DRAM bytes of all points, and the points that no other beats in both.

use super::data::{SweepPoint, SweepSummary};
use super::fields::fields;
use crate::report::draw::canvas::{LEFT, LINE, Text};
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

fn figure(summary: &SweepSummary) -> Option<Figure<'_>> {
    if fields(summary).len() < 2 || summary.points.len() < 4 {
        return None;
    }
    let mut names: Vec<String> = Vec::new();
    let mut points: Vec<(usize, &SweepPoint)> = Vec::new();
    for point in &summary.points {
        let name = format!("{}, {}", point.machine, point.policy);
        let series = names.iter().position(|other| *other == name).unwrap_or_else(|| {
            names.push(name);
            names.len() - 1
        });
        points.push((series, point));
    }
    let best = unbeaten(&points);
    let is_sampled = points.iter().any(|(_, point)| point.split.half_widths.is_some());
    let row = |((series, point), best): (&(usize, &SweepPoint), &bool)| {
        let place = place(point);
        let shares = place.map(|it| number(it.share));
        let halves = place.map(|it| it.half_width.map_or_else(String::new, number));
        let names = [names[*series].clone(), point.label()].into_iter().chain(shares);
        let best = if *best { "yes" } else { "no" }.to_owned();
        names.chain([best]).chain(halves.into_iter().filter(|_| is_sampled)).collect()
    };
    let halves = ["half width of cycles", "half width of DRAM bytes"].into_iter().filter(|_| is_sampled);
    let head = ["machine, policy", "point", "change of cycles", "change of DRAM bytes", "unbeaten"];
    let data = Grid {
        head: head.into_iter().chain(halves).map(Into::into).collect(),
        names: 2,
        rows: points.iter().zip(&best).map(row).collect(),
    };
    let cycles = |point: &SweepPoint| place(point)[0];
    let fastest = points.iter().min_by(|a, b| cycles(a.1).share.total_cmp(&cycles(b.1).share))?.1;
    let labels = names.len() as i32 * LINE;
    Some(Figure {
        title: format!(
            "{} of {} are unbeaten; the fastest is {} on {} ({})",
            best.iter().filter(|best| **best).count(),
            counted(points.len(), "point"),
            fastest.label(),
            fastest.machine,
            change_within(1.0, 1.0 + cycles(fastest).share, cycles(fastest).half_width)
        ),
        about: format!(
            "Change of cycles and of DRAM bytes by culling, against the same machine without. Ringed and named: no \
             point of the machine and policy is better in both.{}",
            match is_sampled {
                true =>
                    " Lines through marks: 95 % intervals, within which either of two points may be the better one.",
                false => "",
            }
        ),
        key: Vec::new(),
        data,
        narrow: true,
        height: Box::new(move |_| PANEL + BELOW + LINE + labels),
        paint: Box::new(move |canvas| {
            let (end, top) = (canvas.width() - 16, LINE);
            let [xs, ys] =
                [0, 1].map(|axis| Ticks::around(points.iter().flat_map(|(_, point)| place(point)[axis].ends())));
            let x = |share: f64| AXIS + (xs.place(share) * f64::from(end - AXIS)).round() as i32;
            let y = |share: f64| top + PANEL - (ys.place(share) * f64::from(PANEL)).round() as i32;
            canvas.text("DRAM bytes", (LEFT, 8), Text::NOTE)?;
            canvas.text("cycles", (end, top + PANEL + 34), Text::NOTE.right())?;
            for share in xs.shares() {
                let color = if share.abs() < 1e-9 { FAINT } else { GRID };
                canvas.line(vec![(x(share), top), (x(share), top + PANEL)], color, 1)?;
                canvas.text(&percent_tick(share), (x(share), top + PANEL + 14), Text::NOTE.centered())?;
            }
            for share in ys.shares() {
                canvas.line(
                    vec![(AXIS, y(share)), (end, y(share))],
                    if share.abs() < 1e-9 { FAINT } else { GRID },
                    1,
                )?;
                canvas.text(&percent_tick(share), (AXIS - 8, y(share)), Text::NOTE.right())?;
            }
            let at = |point: &SweepPoint| {
                let [cycles, bytes] = place(point);
                (x(cycles.share), y(bytes.share))
            };
            let mut names_of = Names::default();
            // The texts of the axis.
            names_of.keep(((AXIS, top + PANEL), (end, top + PANEL + LINE)));
            for (series, point) in points.iter().filter(|_| is_sampled && points.len() <= MOST) {
                let ((left, top), [cycles, bytes]) = (at(point), place(point).map(Shift::ends));
                let across = cycles.map(|share| (x(share), top)).into();
                let upright = bytes.map(|share| (left, y(share))).into();
                for ends in [across, upright] {
                    whisker(canvas, ends, series_color(*series))?;
                    names_of.keep(ends);
                }
            }
            points.iter().take(MOST).for_each(|(_, point)| names_of.point(at(point)));
            let drawn = points.iter().zip(&best).enumerate();
            for (_, ((series, point), best)) in drawn.filter(|(index, (_, best))| **best || *index < MOST) {
                mark(canvas, *series, at(point), series_color(*series), *best)?;
                if *best {
                    canvas.ring(at(point), 9, INK, 1)?;
                    names_of.write(canvas, &point.label(), at(point))?;
                }
            }
            for (index, name) in names.iter().enumerate() {
                let y = LINE + PANEL + BELOW + index as i32 * LINE;
                mark(canvas, index, (LEFT + 7, y), series_color(index), true)?;
                canvas.text(name, (LEFT + 20, y), Text::LABEL)?;
            }
            Ok(())
        }),
    })
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
