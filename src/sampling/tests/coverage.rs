//! Coverage of intervals: samples are drawn many times from windows that were all measured.

use std::sync::LazyLock;

use super::super::axis::Axis;
use super::super::covariates::{Columns, Span};
use super::super::estimate::{Estimates, Population, Total, Window, estimates};
use super::super::figures::{Figure, MemoryLevel};
use super::super::plan::MIN_POINTS_TO_STOP;
use super::*;
use crate::machine::kinds::Kind;
use crate::stats::{CacheCounts, Residuals, TrafficClass};

const CUT: Cut = Cut { pixels: 16, before: 1, own: 2, behind: 1 };

/// All windows of the recorded stream on a machine.
pub(super) struct Census(Vec<Window>);

/// On `small`; the stream is short, so a small pool is used to get many windows.
pub(super) static SMALL: LazyLock<Census> = LazyLock::new(|| Census::of(&few_rays()));
/// The same with other L1s.
pub(super) static OTHER: LazyLock<Census> = LazyLock::new(|| {
    let mut machine = few_rays();
    machine.traversal.cache.bytes = crate::ranged::Size::new(2048).unwrap();
    Census::of(&machine)
});

fn few_rays() -> MachineSpec {
    let mut machine = shipped("small");
    machine.dispatcher.rays = num(16);
    machine
}

impl Census {
    fn of(machine: &MachineSpec) -> Self {
        let (header, stream) = quickstart();
        let plan = Plan { strata: Strata { length: 2.0, seed: 0 }, draws: 0..1000, cut: CUT };
        let sampler = Sampler::new(Sampled::Event, &header);
        let mut windows = Findings::of(&sampler, machine, &CUT, pass(&sampler, machine, &plan, 0, &stream)).measured;
        for window in &mut windows {
            // Replays of windows overlap: here each counts with its own size.
            window.operations = window.span(Span::Group).covariates[0];
            let told = |figure: &Figure| *figure == misses() || REPORTED.iter().any(|(told, _)| told == figure);
            window.spans.iter_mut().for_each(|part| part.figures.retain(|figure, _| told(figure)));
        }
        Self(windows)
    }

    /// The `length` windows from `first` on, as a stream.
    fn stream(&self, first: usize, length: usize) -> Stream<'_> {
        let windows = &self.0[first..first + length];
        let mut sums = Span::ALL.map(|_| Population::default());
        for window in windows {
            sums.iter_mut().zip(&window.spans).for_each(|(sum, part)| sum.add(&part.covariates));
        }
        Stream { windows, known: sums.map(|sum| sum.covariates) }
    }

    pub(super) fn whole(&self) -> Stream<'_> {
        self.stream(0, self.0.len())
    }
}

pub(super) struct Stream<'a> {
    windows: &'a [Window],
    /// Their covariates, by span.
    known: [Columns; Span::ALL.len()],
}

/// A sample of a stream.
pub(super) struct Drawn {
    windows: Vec<Window>,
    strata: Strata,
    draws: usize,
}

impl Stream<'_> {
    pub(super) fn drawn(&self, strata: Strata, draws: usize) -> Drawn {
        let mut axis = Axis::new(strata, draws);
        let hits = self.windows.iter().map(|window| Window { hits: axis.next(), ..window.clone() });
        Drawn { windows: hits.filter(|window| !window.hits.is_empty()).collect(), strata, draws }
    }

    fn population(&self, drawn: &Drawn, span: Span) -> Population {
        Population { strata: drawn.strata, windows: self.windows.len(), covariates: self.known[span as usize] }
    }

    pub(super) fn truth(&self, (figure, span): &(Figure, Span)) -> f64 {
        self.windows.iter().map(|window| window.span(*span).figures[figure]).sum()
    }

    pub(super) fn estimates(&self, drawn: &Drawn, (figure, span): (&Figure, Span)) -> Estimates {
        let population = self.population(drawn, span);
        estimates(&population, &drawn.windows, drawn.draws, 64, |it| it == figure)
    }

    pub(super) fn estimate(&self, drawn: &Drawn, (figure, span): &(Figure, Span)) -> Total {
        self.estimates(drawn, (figure, *span)).total(figure)
    }

    /// The residuals of the sample; all three figures are the same one here.
    fn residuals(&self, drawn: &Drawn, (figure, span): &(Figure, Span)) -> Residuals {
        let estimates = self.estimates(drawn, (figure, *span));
        let (points, freedom) = estimates.residuals(&[(); 3].map(|()| figure.clone()));
        Residuals { window_pixels: CUT.window() as u64, seed: drawn.strata.seed, freedom, points, change: None }
    }
}

pub(super) const REPORTED: [(Figure, Span); 3] =
    [(Figure::Cycles, Span::Inside), (Figure::DramBytes, Span::Own), (Figure::L2Bytes, Span::Own)];

fn misses() -> Figure {
    Figure::Cache(MemoryLevel::L1(Kind::Traversal), TrafficClass::Node, CacheCounts::place("misses"))
}

/// Strata with two points each, `points` in all.
pub(super) fn strata(stream: &Stream<'_>, points: usize, seed: u64) -> Strata {
    Strata { length: 2.0 * stream.windows.len() as f64 / points as f64, seed }
}

/// The truth lies within the 95 % intervals in 93 to 97 % of 1000 samples.
#[test]
fn intervals_cover_the_truth_as_often_as_they_say() {
    let stream = SMALL.whole();
    assert!(stream.windows.len() > 200, "{}", stream.windows.len());
    for figure in REPORTED.into_iter().chain([(misses(), Span::Inside)]) {
        let (mut covered, mut width, truth) = (0, 0.0, stream.truth(&figure));
        for seed in 0..1000 {
            let Total { total, half_width } = stream.estimate(&stream.drawn(strata(&stream, 30, seed), 2), &figure);
            covered += u32::from((total - truth).abs() <= half_width);
            width += half_width / truth / 1000.0;
        }
        println!("{figure:?}: {covered} of 1000, mean half width {width:.3}");
        assert!((925..=975).contains(&covered), "{figure:?}: {covered} of 1000");
    }
}

/// The same for streams of 16 to 48 windows with 8 to 24 points: intervals from few windows are wide, and cover the
/// truth. Shorter streams are not sampled.
#[test]
fn intervals_of_few_windows_hold_too() {
    for (length, points) in [(16, 8), (24, 8), (24, 12), (48, 12), (48, 24)] {
        for figure in &REPORTED {
            let (mut covered, mut width) = (0, 0.0);
            for seed in 0..500 {
                let first = seed as usize * 7 % (SMALL.0.len() - length);
                let stream = SMALL.stream(first, length);
                let (drawn, truth) = (stream.drawn(strata(&stream, points, seed), 2), stream.truth(figure));
                let Total { total, half_width } = stream.estimate(&drawn, figure);
                covered += u32::from((total - truth).abs() <= half_width);
                width += half_width / truth / 500.0;
            }
            println!("{points} of {length}, {:?}: {covered} of 500, mean half width {width:.3}", figure.0);
            assert!(covered >= 460, "{points} points of {length} windows, {figure:?}: {covered} of 500");
        }
    }
}

/// The same where sampling stops at a target. Windows at most double from step to step. A sample may stop because its
/// interval is narrow by chance.
#[test]
fn intervals_cover_the_truth_when_sampling_stops_at_a_target() {
    let (stream, figure) = (SMALL.whole(), &REPORTED[0]);
    let truth = stream.truth(figure);
    for target in [0.03, 0.05, 0.1] {
        let (mut covered, mut stopped) = (0, 0);
        for seed in 0..500 {
            // As in sampling with a target: at most one point for each window, then everything is replayed.
            let strata = strata(&stream, 12, seed);
            let plan = |draws| Plan { strata, draws: 0..draws, cut: CUT };
            let (mut draws, most) = (2, strata.length as usize);
            let found = loop {
                let drawn = stream.drawn(strata, draws);
                let points = drawn.windows.iter().map(|window| window.hits.len()).sum();
                let found = stream.estimate(&drawn, figure);
                if points >= MIN_POINTS_TO_STOP && found.share() <= target {
                    break Some(found);
                }
                let Some(next) = plan(draws).next_draws(points, found.share(), target, most) else { break None };
                draws = next;
            };
            if let Some(Total { total, half_width }) = found {
                stopped += 1;
                covered += u32::from((total - truth).abs() <= half_width);
            }
        }
        println!("target {target}: {covered} of {stopped} that stopped");
        assert!(stopped > 250, "target {target}: {stopped}");
        assert!(f64::from(covered) >= 0.93 * f64::from(stopped), "target {target}: {covered} of {stopped}");
    }
}

/// The same for intervals of a change, where sampling stops once that is within a target.
#[test]
fn intervals_of_changes_hold_when_sampling_stops_at_a_target() {
    let (one, other) = (SMALL.whole(), OTHER.whole());
    for figure in &REPORTED {
        let truth = other.truth(figure) / one.truth(figure);
        for target in [0.02, 0.04, 0.08] {
            let (mut covered, mut stopped) = (0, 0);
            for seed in 0..500 {
                let strata = strata(&one, 12, seed);
                let most = strata.length as usize;
                let mut draws = 2;
                while draws <= most {
                    let (drawn, other_drawn) = (one.drawn(strata, draws), other.drawn(strata, draws));
                    let points: usize = drawn.windows.iter().map(|window| window.hits.len()).sum();
                    let [left, others_left] = [one.residuals(&drawn, figure), other.residuals(&other_drawn, figure)];
                    let half = others_left.of_ratio(&left, 0).unwrap();
                    if points >= MIN_POINTS_TO_STOP && half <= target {
                        let [before, after] = [one.estimate(&drawn, figure), other.estimate(&other_drawn, figure)];
                        let ratio = after.total / before.total;
                        stopped += 1;
                        covered += u32::from((ratio - truth).abs() <= ratio * half);
                        break;
                    }
                    draws *= 2;
                }
            }
            println!("{:?}, target {target}: {covered} of {stopped} that stopped", figure.0);
            assert!(f64::from(covered) >= 0.92 * f64::from(stopped), "{figure:?} {target}: {covered} of {stopped}");
        }
    }
}

/// The change by smaller L1s, from the same windows: its interval is narrower than the sum of both, and covers the
/// truth, also for samples of different sizes.
#[test]
fn a_change_from_the_same_windows_is_narrower_and_holds() {
    let (one, other) = (SMALL.whole(), OTHER.whole());
    assert_eq!(one.windows.len(), other.windows.len());
    for (draws, other_draws) in [(2, 2), (2, 4)] {
        for figure in &REPORTED {
            let truth = other.truth(figure) / one.truth(figure);
            let (mut covered, mut paired, mut sum) = (0, 0.0, 0.0);
            for seed in 0..500 {
                let strata = strata(&one, 24, seed);
                let (drawn, other_drawn) = (one.drawn(strata, draws), other.drawn(strata, other_draws));
                let [before, after] = [one.estimate(&drawn, figure), other.estimate(&other_drawn, figure)];
                let [left, others_left] = [one.residuals(&drawn, figure), other.residuals(&other_drawn, figure)];
                let (ratio, half) = (after.total / before.total, others_left.of_ratio(&left, 0).unwrap());
                covered += u32::from((ratio - truth).abs() <= ratio * half);
                paired += half / 500.0;
                sum += (before.share() + after.share()) / 500.0;
            }
            println!("{draws} and {other_draws}, {:?}: {covered} of 500; {paired:.4}, not {sum:.4}", figure.0);
            assert!(covered >= 460, "{draws} and {other_draws}, {figure:?}: {covered} of 500");
            assert!(paired < 0.8 * sum, "{draws} and {other_draws}, {figure:?}: {paired:.4} {sum:.4}");
        }
    }
}
