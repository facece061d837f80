//! Miss ratios over the size of a cache: one panel per kind of cache, one line per class.

use super::data::{ReuseSummary, size as named};
use crate::report::draw::canvas::{Canvas, DrawError, LEFT, Text, is_narrow, tick_step};
use crate::report::draw::palette::{FAINT, GRID, INK, class_color};
use crate::report::draw::{Figure, Plot};
use crate::report::format::{number, percent, percent_tick, words};
use crate::report::grid::Grid;
use crate::stats::{ReuseCurve, ReuseLevel, TrafficClass};

const PANEL: i32 = 150;
const ABOVE: i32 = 36;
const BELOW: i32 = 40;
const AXIS: i32 = 62;
const HEIGHT: i32 = ABOVE + PANEL + BELOW;

pub(super) const PLOT: Plot<ReuseSummary> = Plot {
    name: "reuse",
    section: (),
    figure: |summary| {
        let ReuseSummary { machine, of, levels, .. } = summary;
        Some(figure(levels, finding(levels), format!("Asked as on {machine} ({of}).")))
    },
};

fn ratio(curve: &ReuseCurve, misses: f64) -> f64 {
    misses / curve.sampled.max(1.0)
}

/// The share of a level's accesses that miss at each size, all classes together.
fn all_misses(level: &ReuseLevel, place: usize) -> f64 {
    let sum = |of: fn(&ReuseCurve, usize) -> f64| level.classes.values().map(|curve| of(curve, place)).sum::<f64>();
    sum(|curve, place| curve.misses[place]) / sum(|curve, _| curve.sampled).max(1.0)
}

/// Names the cache with the largest drop of its miss ratio at twice its size.
pub(crate) fn finding(levels: &[ReuseLevel]) -> String {
    let gain = |level: &ReuseLevel| {
        let place = ReuseCurve::sizes().position(|size| size == level.bytes)?;
        let [now, then] =
            [place, place + 1].map(|place| (place < ReuseCurve::sizes().count()).then(|| all_misses(level, place)));
        Some((now?, then?))
    };
    let gains = levels.iter().filter_map(|level| Some((level, gain(level)?)));
    match gains.max_by(|a, b| (a.1.0 - a.1.1).total_cmp(&(b.1.0 - b.1.1))) {
        Some((level, (now, then))) => format!(
            "{} of twice the size ({}) misses in {} of its accesses instead of {}, both fully associative",
            words(&level.name),
            named(level.bytes * 2),
            percent(then),
            percent(now),
        ),
        None => "Misses over the size of a cache".into(),
    }
}

/// Number of panels side by side.
fn columns(width: i32) -> i32 {
    if is_narrow(width) { 1 } else { 2 }
}

/// Miss ratios at all sizes; `asked` names the machine and the accesses.
pub(crate) fn figure(levels: &[ReuseLevel], title: String, asked: String) -> Figure<'_> {
    let all = || levels.iter().flat_map(|level| level.classes.keys());
    let classes: Vec<_> = TrafficClass::ALL.into_iter().filter(|class| all().any(|other| other == class)).collect();
    let count = levels.len() as i32;
    Figure {
        title,
        about: format!(
            "Share of a class's accesses that miss in LRU caches without sets, over the size of one cache. The \
             vertical line marks the machine's own size, with a ring for each class. {asked}"
        ),
        key: classes.iter().map(|class| (words(class.name()), class_color(*class))).collect(),
        data: data(levels),
        narrow: true,
        height: Box::new(move |width| (count + columns(width) - 1) / columns(width) * HEIGHT),
        paint: Box::new(|canvas| {
            let columns = columns(canvas.width());
            let width = canvas.width() / columns;
            let places = (0..).map(|index| ((index % columns) * width, index / columns * HEIGHT));
            levels.iter().zip(places).try_for_each(|(level, place)| panel(canvas, level, place, width))
        }),
    }
}

/// One row per size, one column per class of a cache.
fn data(levels: &[ReuseLevel]) -> Grid {
    let curves: Vec<_> = levels.iter().flat_map(|level| level.classes.iter().map(move |it| (level, it))).collect();
    let names = curves.iter().map(|(level, (class, _))| format!("{}: {}", words(&level.name), words(class.name())));
    let row = |(place, size): (usize, u64)| {
        // More than four decimals cannot be seen in a plot.
        let share = |curve: &ReuseCurve| number((ratio(curve, curve.misses[place]) * 1e4).round() / 1e4);
        std::iter::once(size.to_string()).chain(curves.iter().map(|(_, (_, curve))| share(curve))).collect()
    };
    Grid {
        head: std::iter::once("bytes".to_owned()).chain(names).collect(),
        names: 0,
        rows: ReuseCurve::sizes().enumerate().map(row).collect(),
    }
}

fn panel(canvas: &Canvas<'_>, level: &ReuseLevel, (left, top): (i32, i32), width: i32) -> Result<(), DrawError> {
    let ratios = |curve: &ReuseCurve| -> Vec<f64> { curve.misses.iter().map(|&misses| ratio(curve, misses)).collect() };
    let most = level.classes.values().flat_map(ratios).fold(0.01, f64::max);
    let (begin, end) = (left + AXIS, left + width - 34);
    let (top, sizes) = (top + ABOVE, ReuseCurve::sizes().count() as i32);
    let bottom = top + PANEL;
    let x = |place: i32| begin + place * (end - begin) / (sizes - 1);
    let y = |share: f64| bottom - (share / most * f64::from(PANEL)).round() as i32;
    let caches = if level.caches > 1 { format!("{} caches", level.caches) } else { "1 cache".into() };
    let heading = format!("{}: {caches} of {}", words(&level.name), named(level.bytes));
    canvas.text(&heading, (left + LEFT, top - 20), Text::LABEL.bold())?;
    let step = tick_step(most, 4);
    for tick in 0..=(most / step) as i32 {
        let share = f64::from(tick) * step;
        canvas.line(vec![(begin, y(share)), (end, y(share))], GRID, 1)?;
        canvas.text(&percent_tick(share), (begin - 8, y(share)), Text::NOTE.right())?;
    }
    for (place, size) in (0..).zip(ReuseCurve::sizes()) {
        if size == level.bytes {
            canvas.line(vec![(x(place), top), (x(place), bottom)], FAINT, 2)?;
        }
        if place % 4 == 0 {
            canvas.line(vec![(x(place), bottom), (x(place), bottom + 4)], FAINT, 1)?;
            canvas.text(&named(size), (x(place), bottom + 15), Text::NOTE.centered())?;
        }
    }
    for (class, curve) in &level.classes {
        let points: Vec<_> = (0..).zip(ratios(curve)).map(|(place, share)| (x(place), y(share))).collect();
        let own = ReuseCurve::sizes().position(|size| size == level.bytes).and_then(|place| points.get(place));
        own.map_or(Ok(()), |&point| canvas.ring(point, 6, INK, 1))?;
        canvas.line(points, class_color(*class), 2)?;
    }
    Ok(())
}
