//! Miss ratios over the size of a cache, a panel a kind of caches, a line a class.

use super::data::{ReuseSummary, size as named};
use crate::report::draw::canvas::{Canvas, DrawError, LEFT, Text, tick_step};
use crate::report::draw::palette::{FAINT, GRID, INK, class_color};
use crate::report::draw::{Figure, Plot};
use crate::report::format::{number, percent_tick, words};
use crate::report::grid::Grid;
use crate::stats::{ReuseCurve, ReuseLevel, TrafficClass};

const PANEL: i32 = 150;
const ABOVE: i32 = 36;
const BELOW: i32 = 40;
const AXIS: i32 = 62;

pub(super) const PLOT: Plot<ReuseSummary> =
    Plot { name: "reuse", section: (), figure: |summary| Some(figure(summary)) };

fn ratio(curve: &ReuseCurve, misses: f64) -> f64 {
    misses / curve.sampled.max(1.0)
}

/// The share of a level's accesses that miss at each size, all classes together.
fn all_misses(level: &ReuseLevel, place: usize) -> f64 {
    let sum = |of: fn(&ReuseCurve, usize) -> f64| level.classes.values().map(|curve| of(curve, place)).sum::<f64>();
    sum(|curve, place| curve.misses[place]) / sum(|curve, _| curve.sampled).max(1.0)
}

/// What doubling the cache that gains most would do.
pub(crate) fn finding(summary: &ReuseSummary) -> String {
    let gain = |level: &ReuseLevel| {
        let place = ReuseCurve::sizes().position(|size| size == level.bytes)?;
        let [now, then] =
            [place, place + 1].map(|place| (place < ReuseCurve::sizes().count()).then(|| all_misses(level, place)));
        Some((now?, then?))
    };
    let gains = summary.levels.iter().filter_map(|level| Some((level, gain(level)?)));
    match gains.max_by(|a, b| (a.1.0 - a.1.1).total_cmp(&(b.1.0 - b.1.1))) {
        Some((level, (now, then))) => format!(
            "Twice the {} ({}) would miss in {} instead of {} of its accesses",
            words(&level.name),
            named(level.bytes * 2),
            percent_tick(then),
            percent_tick(now),
        ),
        None => "Misses over the size of a cache".into(),
    }
}

fn figure(summary: &ReuseSummary) -> Figure<'_> {
    let all = || summary.levels.iter().flat_map(|level| level.classes.keys());
    let classes: Vec<_> = TrafficClass::ALL.into_iter().filter(|class| all().any(|other| other == class)).collect();
    let height = summary.levels.len() as i32 * (ABOVE + PANEL + BELOW);
    Figure {
        title: finding(summary),
        about: format!(
            "Share of a class's accesses that miss in LRU caches without sets, over the size of one cache, asked as \
             on {} ({}). The upright line with a ring a class: the size that the machine has.",
            summary.machine, summary.of
        ),
        key: classes.iter().map(|class| (words(class.name()), class_color(*class))).collect(),
        data: data(summary),
        narrow: true,
        height: Box::new(move |_| height),
        paint: Box::new(|canvas| {
            let tops = (0..).map(|index| index * (ABOVE + PANEL + BELOW) + ABOVE);
            summary.levels.iter().zip(tops).try_for_each(|(level, top)| panel(canvas, level, top))
        }),
    }
}

fn data(summary: &ReuseSummary) -> Grid {
    let rows = summary.levels.iter().flat_map(|level| {
        level.classes.iter().flat_map(move |(class, curve)| {
            ReuseCurve::sizes().zip(&curve.misses).map(move |(size, &misses)| {
                vec![words(&level.name), words(class.name()), size.to_string(), number(ratio(curve, misses))]
            })
        })
    });
    Grid { head: ["cache", "class", "bytes", "miss ratio"].map(Into::into).to_vec(), names: 2, rows: rows.collect() }
}

fn panel(canvas: &Canvas<'_>, level: &ReuseLevel, top: i32) -> Result<(), DrawError> {
    let ratios = |curve: &ReuseCurve| -> Vec<f64> { curve.misses.iter().map(|&misses| ratio(curve, misses)).collect() };
    let most = level.classes.values().flat_map(ratios).fold(0.01, f64::max);
    let (end, bottom, sizes) = (canvas.width() - 30, top + PANEL, ReuseCurve::sizes().count() as i32);
    let x = |place: i32| AXIS + place * (end - AXIS) / (sizes - 1);
    let y = |share: f64| bottom - (share / most * f64::from(PANEL)).round() as i32;
    let caches = if level.caches > 1 { format!("{} caches", level.caches) } else { "1 cache".into() };
    let heading = format!("{}: {caches} of {}", words(&level.name), named(level.bytes));
    canvas.text(&heading, (LEFT, top - 20), Text::LABEL.bold())?;
    let step = tick_step(most, 4);
    for tick in 0..=(most / step) as i32 {
        let share = f64::from(tick) * step;
        canvas.line(vec![(AXIS, y(share)), (end, y(share))], GRID, 1)?;
        canvas.text(&percent_tick(share), (AXIS - 8, y(share)), Text::NOTE.right())?;
    }
    let every = if canvas.is_narrow() { 4 } else { 1 };
    for (place, size) in (0..).zip(ReuseCurve::sizes()) {
        if size == level.bytes {
            canvas.line(vec![(x(place), top), (x(place), bottom)], FAINT, 2)?;
        }
        if place % every == 0 {
            canvas.text(&named(size), (x(place), bottom + 14), Text::NOTE.centered())?;
        }
    }
    for (class, curve) in &level.classes {
        let points: Vec<_> = (0..).zip(ratios(curve)).map(|(place, share)| (x(place), y(share))).collect();
        points.iter().try_for_each(|&point| canvas.dot(point, 3, class_color(*class)))?;
        let own = ReuseCurve::sizes().position(|size| size == level.bytes).and_then(|place| points.get(place));
        own.map_or(Ok(()), |&point| canvas.ring(point, 6, INK, 1))?;
        canvas.line(points, class_color(*class), 2)?;
    }
    Ok(())
}
