//! Miss ratios over the size of a cache, a panel a kind of caches, a line a class.

use super::data::{ReuseSummary, size as named};
use crate::report::draw::Plot;
use crate::report::draw::canvas::{
    Canvas, DrawError, LEFT, LINE, TITLES, Text, WIDTH, class_color, legend_height, palette, svg, tick_step,
};
use crate::report::format::words;
use crate::stats::{ReuseCurve, ReuseLevel, TrafficClass};

const PANEL: i32 = 150;
const ABOVE: i32 = 36;
const BELOW: i32 = 40;
const AXIS: i32 = 76;
const END: i32 = WIDTH - 40;

pub(super) const PLOT: Plot<ReuseSummary> =
    Plot { name: "reuse", section: (), draw: |summary| draw(summary).map(Some) };

fn draw(summary: &ReuseSummary) -> Result<String, DrawError> {
    let all = || summary.levels.iter().flat_map(|level| level.classes.keys());
    let classes: Vec<_> = TrafficClass::ALL.into_iter().filter(|class| all().any(|other| other == class)).collect();
    let legend: Vec<_> = classes.iter().map(|class| (words(class.name()), class_color(*class))).collect();
    let top = TITLES + legend_height(&legend);
    svg(top + summary.levels.len() as i32 * (ABOVE + PANEL + BELOW) + LINE, |canvas| {
        let title = format!("Misses over the size of a cache: {}, {}", summary.scene, summary.policy);
        let subtitle = format!(
            "share of a class's accesses that miss in LRU caches without sets, asked as on {}; {}; grey: the size that the machine has",
            summary.machine, summary.of
        );
        canvas.titles(&title, &subtitle)?;
        canvas.legend(TITLES, &legend)?;
        (0..)
            .zip(&summary.levels)
            .try_for_each(|(index, level)| panel(canvas, level, top + index * (ABOVE + PANEL + BELOW) + ABOVE))
    })
}

fn panel(canvas: &Canvas<'_>, level: &ReuseLevel, top: i32) -> Result<(), DrawError> {
    let ratio = |curve: &ReuseCurve, misses: f64| misses / curve.sampled.max(1.0);
    let ratios = |curve: &ReuseCurve| -> Vec<f64> { curve.misses.iter().map(|&misses| ratio(curve, misses)).collect() };
    let most = level.classes.values().flat_map(ratios).fold(0.01, f64::max);
    let (bottom, sizes) = (top + PANEL, ReuseCurve::sizes().count() as i32);
    let x = |place: i32| AXIS + place * (END - AXIS) / (sizes - 1);
    let y = |share: f64| bottom - (share / most * f64::from(PANEL)).round() as i32;
    let caches = if level.caches > 1 { format!("{} caches", level.caches) } else { "1 cache".into() };
    canvas.text(&format!("{}: {caches}", level.name), (LEFT, top - 20), Text::LABEL.bold())?;
    let step = tick_step(most, 4);
    for tick in 0..=(most / step) as i32 {
        let share = f64::from(tick) * step;
        canvas.line(vec![(AXIS, y(share)), (END, y(share))], palette::GRID, 1)?;
        canvas.text(
            &format!("{:.3} %", share * 100.0).replace(".000", ""),
            (AXIS - 8, y(share)),
            Text::NOTE.right(),
        )?;
    }
    for (place, size) in (0..).zip(ReuseCurve::sizes()) {
        if size == level.bytes {
            canvas.line(vec![(x(place), top), (x(place), bottom)], palette::GREY, 3)?;
        }
        canvas.text(&named(size), (x(place), bottom + 14), Text::NOTE.centered())?;
    }
    for (class, curve) in &level.classes {
        let points: Vec<_> = (0..).zip(ratios(curve)).map(|(place, share)| (x(place), y(share))).collect();
        points.iter().try_for_each(|&point| canvas.dot(point, 3, class_color(*class)))?;
        canvas.line(points, class_color(*class), 2)?;
    }
    Ok(())
}
