//! Samples beside a baseline, drawn many times from windows that were all measured.

use super::super::baseline::{Baseline, Corrected};
use super::super::estimate::Total;
use super::super::figures::Figures;
use super::coverage::{OTHER, REPORTED, SMALL, strata};
use crate::stats::Residuals;

/// Smaller L1s in 24 points, beside a baseline with 96 points: intervals are narrower than from the 24 points alone,
/// and cover the truth; so do those of the change.
#[test]
fn a_baseline_sets_right_what_few_windows_are_off() {
    let (one, other) = (SMALL.whole(), OTHER.whole());
    for figure in &REPORTED {
        let ((name, span), ends) = (figure, Figures::new());
        let (truth, change) = (other.truth(figure), other.truth(figure) / one.truth(figure));
        let (mut held, mut changes, mut widths) = (0, 0, [0.0; 3]);
        for seed in 0..500 {
            let strata = strata(&one, 24, seed);
            let all = one.estimates(&one.drawn(strata, 8), (name, *span));
            let (points, freedom) = all.residuals(&[(); 3].map(|()| name.clone()));
            let known = [(name.clone(), (all.total(name).total, all.total(name).share()))].into();
            let windows = one.estimates(&one.drawn(strata, 2), (name, *span));
            let baseline = Baseline { windows, ends: &ends, known: &known, points: &points };
            let own = other.estimates(&other.drawn(strata, 2), (name, *span));
            let corrected: Corrected = baseline.corrected(&own, &ends, &[(); 3].map(|()| name.clone()));
            let Total { total, half_width } = corrected.totals[name];
            held += u32::from((total - truth).abs() <= half_width);
            let of = |points, change| Residuals { window_pixels: 1, seed, freedom, points, change };
            let half = of(corrected.points, Some(corrected.change)).of_ratio(&of(points.clone(), None), 0).unwrap();
            let ratio = total / all.total(name).total;
            changes += u32::from((ratio - change).abs() <= ratio * half);
            let found = [half_width / truth, own.total(name).share(), half];
            widths.iter_mut().zip(found).for_each(|(width, it)| *width += it / 500.0);
        }
        println!("{name:?}: {held} and {changes} of 500 hold; {widths:.4?} beside, alone, of the change");
        assert!(held >= 460 && changes >= 460, "{name:?}: {held} {changes}");
        assert!(widths[0] < 0.9 * widths[1], "{name:?}: {widths:?}");
    }
}
