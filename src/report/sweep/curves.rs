//! The effect of each value of a field: one curve per machine and policy, with a ring around the machine's own value.

use super::data::{SweepPoint, SweepSummary};
use super::fields::{Field, fields, own, places, value};
use super::values::shown;
use crate::report::draw::canvas::{Canvas, LEFT, LINE, Text};
use crate::report::draw::marks::{mark, whisker};
use crate::report::draw::palette::{FAINT, GRID, INK, series_color};
use crate::report::draw::ticks::Ticks;
use crate::report::draw::{DrawError, Drawing, Figure};
use crate::report::format::{number, percent, percent_tick};
use crate::report::grid::Grid;
use crate::report::split::{Shift, change_within};
use crate::size::amount;

const PANEL: i32 = 150;
const ABOVE: i32 = 34;
const BELOW: i32 = 40;
const AXIS: i32 = 62;

/// A panel: its heading, and the figure of a point, which may need the baseline's point.
type Metric = (&'static str, fn(&SweepPoint, Option<&SweepPoint>) -> Option<Shift>);

/// Changes against the baseline machine, and against the same machine without culling.
const METRICS: [Metric; 3] = [
    ("Cycles with culling, against the machine as it is", |it, own| {
        Shift::new(it.split.cycles[2], own?.split.cycles[2], it.half_width_to_file())
    }),
    ("Cycles, change by culling", |it, _| it.split.shifts()[0]),
    ("DRAM bytes, change by culling", |it, _| it.split.shifts()[1]),
];

/// One plot per field; none at all if any point changes several fields.
pub(super) fn drawings(summary: &SweepSummary) -> Result<Vec<Drawing>, DrawError> {
    if summary.points.iter().any(|point| point.changes.len() > 1) {
        return Ok(Vec::new());
    }
    let names: Vec<String> = fields(summary).iter().map(|field| field.path.replace('.', "-")).collect();
    let all = fields(summary).into_iter().zip(names);
    all.map(|(field, name)| Drawing::new(format!("field-{name}"), (), figure(summary, field))).collect()
}

/// The effect of the first field, in a sentence; `None` if nothing was varied.
pub(super) fn finding_of_first(summary: &SweepSummary) -> Option<String> {
    let field = fields(summary).into_iter().next()?;
    Some(finding(&field, &curves(summary, &field)))
}

/// A machine under a policy: its name, and its points along a field.
struct Curve<'a> {
    name: String,
    points: Vec<(usize, &'a SweepPoint)>,
    /// The point of the baseline machine.
    own: Option<&'a SweepPoint>,
}

impl Curve<'_> {
    fn figure(&self, (_, of): Metric, point: &SweepPoint) -> Option<Shift> {
        of(point, self.own)
    }
}

fn curves<'a>(summary: &'a SweepSummary, field: &Field<'a>) -> Vec<Curve<'a>> {
    let mut curves: Vec<Curve<'a>> = Vec::new();
    let varies = |point: &SweepPoint| point.changes.iter().all(|change| change.field == field.path);
    for point in summary.points.iter().filter(|point| varies(point)) {
        let Some(value) = value(summary, point, field.path) else { continue };
        let Some(place) = field.values.iter().position(|it| *it == value) else { continue };
        let name = format!("{}, {}", point.machine, point.policy);
        match curves.iter_mut().find(|curve| curve.name == name) {
            Some(curve) => curve.points.push((place, point)),
            None => curves.push(Curve { name, points: vec![(place, point)], own: None }),
        }
    }
    for curve in &mut curves {
        curve.points.sort_by_key(|(place, _)| *place);
        let own = curve
            .points
            .iter()
            .find(|(_, point)| value(summary, point, field.path) == own(summary, &point.machine, field.path));
        curve.own = own.map(|(_, point)| *point);
    }
    curves
}

fn figure<'a>(summary: &'a SweepSummary, field: Field<'a>) -> Figure<'a> {
    let curves = curves(summary, &field);
    let is_sampled = curves.iter().flat_map(|curve| &curve.points).any(|(_, point)| point.split.half_widths.is_some());
    let row = |curve: &Curve<'_>, place: usize, point: &SweepPoint| -> Vec<String> {
        let text = |value: Option<f64>| value.map_or_else(String::new, number);
        let metrics = METRICS.iter().flat_map(|metric| {
            let shift = curve.figure(*metric, point);
            let half_width = is_sampled.then(|| text(shift.and_then(|shift| shift.half_width)));
            [Some(text(shift.map(|shift| shift.share))), half_width].into_iter().flatten()
        });
        [curve.name.clone(), field.values[place].to_owned()].into_iter().chain(metrics).collect()
    };
    let rows = curves.iter().flat_map(|curve| curve.points.iter().map(|(place, point)| row(curve, *place, point)));
    let of_metric = |(name, _): Metric| [Some(name), is_sampled.then_some("half width")].into_iter().flatten();
    let head = ["machine, policy", field.path].into_iter().chain(METRICS.into_iter().flat_map(of_metric));
    let data = Grid { head: head.map(Into::into).collect(), names: 1, rows: rows.collect() };
    let labels = curves.len() as i32 * LINE;
    Figure {
        title: finding(&field, &curves),
        about: format!(
            "`{}` along the axis, all else as in the machine's file. Ring: the machine's own value.{}",
            field.path,
            if is_sampled { " Lines through marks: 95 % intervals." } else { "" }
        ),
        key: Vec::new(),
        data,
        narrow: true,
        height: Box::new(move |_| METRICS.len() as i32 * (ABOVE + PANEL + BELOW) + labels),
        paint: Box::new(move |canvas| {
            for (index, metric) in (0..).zip(METRICS) {
                panel(canvas, (&field, &curves), metric, index * (ABOVE + PANEL + BELOW) + ABOVE)?;
            }
            let top = METRICS.len() as i32 * (ABOVE + PANEL + BELOW) + LINE / 2;
            for (index, curve) in curves.iter().enumerate() {
                let y = top + index as i32 * LINE;
                mark(canvas, index, (LEFT + 7, y), series_color(index), true)?;
                canvas.text(&curve.name, (LEFT + 20, y), Text::LABEL)?;
            }
            Ok(())
        }),
    }
}

/// A smaller relative difference of cycles counts as none.
const LEAST_DIFFERENCE: f64 = 0.002;

/// The points of a curve with the fewest and the most cycles.
struct Ends {
    best: usize,
    worst: usize,
    cycles: [f64; 2],
    /// Sum of both points' half widths, as a share of cycles.
    within: f64,
}

impl Ends {
    fn of(curve: &Curve<'_>) -> Option<Self> {
        let cycles = |(_, point): &&(usize, &SweepPoint)| point.split.cycles[2];
        let (&(best, fast), &(worst, slow)) =
            (curve.points.iter().min_by_key(cycles)?, curve.points.iter().max_by_key(cycles)?);
        let within = [fast, slow].map(|point| point.half_width_to_file().unwrap_or_default()).iter().sum();
        Some(Self { best, worst, cycles: [fast, slow].map(|point| point.split.cycles[2] as f64), within })
    }

    fn ratio(&self) -> f64 {
        let [least, most] = self.cycles;
        if least > 0.0 { most / least } else { 1.0 }
    }
}

/// Names the curve with the largest significant ratio of cycles, in a sentence.
fn finding(field: &Field<'_>, curves: &[Curve<'_>]) -> String {
    let shown = |place: usize| shown(field.path, field.values[place]);
    let all: Vec<(&Curve<'_>, Ends)> = curves.iter().filter_map(|curve| Some((curve, Ends::of(curve)?))).collect();
    let open = all.iter().map(|(_, ends)| ends.within).fold(0.0, f64::max);
    // A difference within its interval does not count.
    let differ = all.iter().filter(|(_, ends)| ends.ratio() > 1.0 + ends.within.max(LEAST_DIFFERENCE));
    match differ.max_by(|(_, one), (_, other)| one.ratio().total_cmp(&other.ratio())) {
        Some((curve, ends @ Ends { best, worst, cycles: [least, most], .. })) => format!(
            "{}: {} takes the fewest cycles on {}, {} against {}",
            field.path,
            shown(*best),
            curve.name,
            change_within(*most, *least, (ends.within > 0.0).then_some(ends.within)),
            shown(*worst)
        ),
        None if open > LEAST_DIFFERENCE => {
            format!("{}: cycles stay the same, within intervals of {}", field.path, percent(open))
        }
        None => format!("{}: cycles stay the same", field.path),
    }
}

fn panel(
    canvas: &Canvas<'_>,
    (field, curves): (&Field<'_>, &[Curve<'_>]),
    metric: Metric,
    top: i32,
) -> Result<(), DrawError> {
    let (end, bottom) = (canvas.width() - 34, top + PANEL);
    canvas.text(metric.0, (LEFT, top - 20), Text::LABEL.bold())?;
    let all = curves.iter().flat_map(|curve| curve.points.iter().filter_map(|(_, it)| curve.figure(metric, it)));
    let ticks = Ticks::around(all.flat_map(Shift::ends));
    let y = |share: f64| bottom - (ticks.place(share) * f64::from(PANEL)).round() as i32;
    let xs: Vec<i32> =
        places(&field.values).iter().map(|place| AXIS + (place * f64::from(end - AXIS)).round() as i32).collect();
    for share in ticks.shares() {
        canvas.line(vec![(AXIS, y(share)), (end, y(share))], GRID, 1)?;
        canvas.text(&percent_tick(share), (AXIS - 8, y(share)), Text::NOTE.right())?;
    }
    canvas.line(vec![(AXIS, y(0.0)), (end, y(0.0))], FAINT, 1)?;
    let mut free = i32::MIN;
    for (value, &x) in field.values.iter().zip(&xs) {
        let text = shown(field.path, value);
        let half = Text::NOTE.width(&text) / 2;
        canvas.line(vec![(x, top), (x, bottom)], GRID, 1)?;
        if x - half > free {
            canvas.text(&text, (x, bottom + 14), Text::NOTE.centered())?;
            free = x + half + 4;
        }
    }
    for (index, curve) in curves.iter().enumerate() {
        let color = series_color(index);
        let at = |place: usize, point: &SweepPoint| Some((xs[place], curve.figure(metric, point)?));
        let placed = || curve.points.iter().filter_map(|(place, point)| Some((*point, at(*place, point)?)));
        let line: Vec<(i32, i32)> = placed().map(|(_, (x, shift))| (x, y(shift.share))).collect();
        // No line between values that are names.
        if line.len() > 1 && field.values.iter().all(|value| amount(value).is_some()) {
            canvas.line(line, color, 2)?;
        }
        for (point, (x, shift)) in placed() {
            let at = (x, y(shift.share));
            if shift.half_width.is_some() {
                let [low, high] = shift.ends().map(|end| (x, y(end)));
                whisker(canvas, (low, high), color)?;
            }
            mark(canvas, index, at, color, true)?;
            if curve.own == Some(point) {
                canvas.ring(at, 9, INK, 2)?;
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::run::tests::sample::sweep;

    /// The finding about the first field if its second point takes `times` as many cycles as the first.
    fn told(times: f64, half_width: Option<f64>) -> String {
        let mut summary = sweep();
        let [own, other] = &mut summary.points[..] else { panic!("two points") };
        other.split.cycles[2] = (own.split.cycles[2] as f64 * times) as u64;
        other.effect.as_mut().unwrap().half_widths = half_width.map(|half| [half; 2]);
        finding_of_first(&summary).unwrap()
    }

    /// A value is called faster only if the difference exceeds its interval.
    #[test]
    fn a_difference_within_its_interval_is_none() {
        let faster = |by: &str| {
            format!("shadow_cache.place: Own takes the fewest cycles on small, published, \u{2212}{by} against L2")
        };
        assert_eq!(told(1.01, None), faster("1.0 %"));
        assert_eq!(told(1.01, Some(0.009)), faster("1.0 \u{b1} 0.9 %"));
        let open = "shadow_cache.place: cycles stay the same, within intervals of 1.1 %";
        assert_eq!(told(1.01, Some(0.011)), open);
        assert_eq!(told(1.001, None), "shadow_cache.place: cycles stay the same");
    }

    #[test]
    fn intervals_have_columns_of_their_own() {
        let summary = sweep();
        let field = fields(&summary).into_iter().next().unwrap();
        let data = figure(&summary, field).data;
        assert_eq!(data.head.iter().filter(|head| *head == "half width").count(), METRICS.len());
        assert!(data.rows.iter().all(|row| row.len() == data.head.len()), "{:?}", data.rows);
        assert!(data.rows[1].iter().skip(2).all(|cell| cell.parse::<f64>().is_ok()), "{:?}", data.rows);
    }
}
