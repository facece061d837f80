//! All designs: their estimates, their measured figures, and the surrogates' predictions of the others.

use rayon::prelude::*;

use super::super::sweep::Point;
use super::axes::{Inputs, Known};
use super::figure::{Figure, LEAST};
use crate::replay::Estimate;
use crate::stats::MachineStats;
use crate::surrogate::{Kernel, Prediction, Process, fit};

/// A machine of the space under a policy.
pub(super) struct Design {
    pub(super) point: Point,
    /// Wrong pixels of the policy.
    pub(super) wrong: u64,
    pub(super) estimate: Estimate,
    /// The figures, once the design was replayed.
    pub(super) measured: Option<Vec<f64>>,
    /// The predictions of its figures before the design was replayed.
    pub(super) foreseen: Option<Vec<Foreseen>>,
}

/// A predicted figure: its logarithm is normal.
#[derive(Clone, Copy, Debug)]
pub(super) struct Foreseen {
    pub(super) mean: f64,
    /// Ends of the 95 % interval.
    pub(super) low: f64,
    pub(super) high: f64,
}

/// All designs, and a surrogate for each figure.
pub(super) struct Pool {
    pub(super) designs: Vec<Design>,
    figures: Vec<Figure>,
    /// The inputs of the surrogate of each of [`Figure::ALL`], for all designs.
    inputs: Vec<Inputs>,
    /// The surrogate of each figure, from the last fit.
    processes: Vec<Process>,
    /// The predictions of each design.
    predictions: Vec<Vec<Prediction>>,
}

impl Pool {
    /// Designs with their estimates; a point comes with its policy's wrong pixels.
    pub(super) fn new(points: Vec<(Point, u64)>, known: &Known<'_>) -> Self {
        let design = |((point, wrong), estimate): ((Point, u64), &Estimate)| Design {
            point,
            wrong,
            estimate: estimate.clone(),
            measured: None,
            foreseen: None,
        };
        let designs = points.into_iter().zip(known.estimates).map(design).collect();
        let inputs = Figure::ALL.map(|figure| known.inputs(figure)).into();
        Self { designs, figures: Figure::ALL.to_vec(), inputs, processes: Vec::new(), predictions: Vec::new() }
    }

    /// Enters the result of a design's replay.
    pub(super) fn measure(&mut self, design: usize, stats: &MachineStats) {
        self.figures.retain(|figure| figure.measured(stats).is_some());
        let foreseen = (!self.processes.is_empty()).then(|| self.foreseen(design));
        let design = &mut self.designs[design];
        design.measured = Some(Figure::ALL.iter().filter_map(|figure| figure.measured(stats)).collect());
        design.foreseen = foreseen;
    }

    /// The figures that are known.
    pub(super) fn figures(&self) -> &[Figure] {
        &self.figures
    }

    /// Fits the surrogates to all measured designs.
    pub(super) fn learn(&mut self) {
        let known = self.designs.iter().enumerate();
        let known: Vec<(usize, &Vec<f64>)> =
            known.filter_map(|(at, design)| Some((at, design.measured.as_ref()?))).collect();
        let of_figure = |(at, figure): (usize, &Figure)| {
            let value = |(design, measured): &(usize, &Vec<f64>)| {
                measured[at].max(LEAST).ln() - figure.estimated(&self.designs[*design].estimate).max(LEAST).ln()
            };
            let values: Vec<f64> = known.iter().map(value).collect();
            let (rows, groups) = &self.inputs[*figure as usize];
            let points: Vec<Vec<f64>> = known.iter().map(|(design, _)| rows[*design].clone()).collect();
            let last = self.processes.get(at).map(|it| it.kernel().clone());
            fit(last.unwrap_or_else(|| Kernel::new(groups.clone())), &points, &values)
        };
        self.processes = self.figures.par_iter().enumerate().map(of_figure).collect();
        self.predict();
    }

    /// Predicts every design from the measured ones.
    pub(super) fn predict(&mut self) {
        let Self { processes, figures, inputs, .. } = self;
        let of = |design: usize, (process, figure): (&Process, &Figure)| {
            process.predict(&inputs[*figure as usize].0[design])
        };
        let predict = |design| processes.iter().zip(figures.iter()).map(|figure| of(design, figure)).collect();
        self.predictions = (0..self.designs.len()).into_par_iter().map(predict).collect();
    }

    /// The prediction of each figure of a design: mean and standard deviation of the logarithm.
    pub(super) fn logarithms(&self, design: usize) -> Vec<(f64, f64)> {
        let estimate = &self.designs[design].estimate;
        let of = |(figure, found): (&Figure, &Prediction)| {
            (found.mean + figure.estimated(estimate).max(LEAST).ln(), found.deviation)
        };
        self.figures.iter().zip(&self.predictions[design]).map(of).collect()
    }

    /// The prediction of each figure of a design.
    pub(super) fn foreseen(&self, design: usize) -> Vec<Foreseen> {
        let of = |((mean, deviation), process): ((f64, f64), &Process)| {
            let half = process.student() * deviation;
            Foreseen { mean: mean.exp(), low: (mean - half).exp(), high: (mean + half).exp() }
        };
        self.logarithms(design).into_iter().zip(&self.processes).map(of).collect()
    }

    /// The leave-one-out error of a figure's surrogate at each measured design, as a logarithm, and half the width of
    /// its 95 % interval.
    pub(super) fn left_out(&self, figure: usize) -> Vec<(f64, f64)> {
        let process = &self.processes[figure];
        process.left_out_errors().into_iter().map(|(error, it)| (error, process.student() * it)).collect()
    }

    /// Narrows the predictions of the other designs as if the chosen one were measured.
    pub(super) fn count_in(&mut self, chosen: usize) {
        let Self { processes, figures, inputs, predictions, .. } = self;
        let own = predictions[chosen].clone();
        let processes = || processes.iter().zip(figures.iter().map(|figure| &inputs[*figure as usize].0));
        predictions.par_iter_mut().enumerate().for_each(|(design, predictions)| {
            for (((process, rows), own), found) in processes().zip(&own).zip(predictions) {
                process.count_in((&rows[chosen], own), (&rows[design], found));
            }
        });
    }
}
