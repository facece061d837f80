//! All designs: what is known of each, what was measured, and what a surrogate says of the others.

use rayon::prelude::*;

use super::super::sweep::Point;
use crate::replay::Estimate;
use crate::stats::MachineStats;
use crate::surrogate::{Group, Kernel, Prediction, Process, fit};

/// What a figure is at least where its logarithm is taken.
pub(super) const LEAST: f64 = 1e-30;

/// A figure that designs are compared by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Figure {
    Cycles,
    DramBytes,
    Joules,
}

impl Figure {
    pub(super) const ALL: [Self; 3] = [Self::Cycles, Self::DramBytes, Self::Joules];

    /// Its name in files.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Cycles => "cycles",
            Self::DramBytes => "dram_bytes",
            Self::Joules => "joules",
        }
    }

    /// What was measured; none of an energy that is not known.
    pub(super) fn measured(self, stats: &MachineStats) -> Option<f64> {
        match self {
            Self::Cycles => Some(stats.cycles.0 as f64),
            Self::DramBytes => Some(stats.moved("dram").0 as f64),
            Self::Joules => stats.energy.as_ref().map(|energy| energy.joules),
        }
    }

    /// What is estimated; 1 of an energy that is not known.
    fn estimated(self, estimate: &Estimate) -> f64 {
        match self {
            Self::Cycles => estimate.cycles,
            Self::DramBytes => estimate.dram_bytes,
            Self::Joules => estimate.joules.unwrap_or(1.0),
        }
    }
}

/// A machine of the space under a policy.
pub(super) struct Design {
    pub(super) point: Point,
    /// Wrong pixels of the policy.
    pub(super) wrong: u64,
    pub(super) estimate: Estimate,
    /// What a surrogate knows of it.
    inputs: Vec<f64>,
    /// Each figure, once it was replayed.
    pub(super) measured: Option<Vec<f64>>,
    /// What was predicted of each figure before it was replayed.
    pub(super) foreseen: Option<Vec<Foreseen>>,
}

/// A figure as it is predicted: its logarithm is normal.
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
    groups: Vec<Group>,
    figures: Vec<Figure>,
    /// The surrogate of each figure, as the last fit left it.
    processes: Vec<Process>,
    /// Of each design, what the surrogates say of it.
    predictions: Vec<Vec<Prediction>>,
}

impl Pool {
    /// Designs with what is known of each: its replay, its policy's wrong pixels, an estimate, and inputs in groups.
    pub(super) fn new(
        points: Vec<(Point, u64)>,
        estimates: Vec<Estimate>,
        (inputs, groups): (Vec<Vec<f64>>, Vec<Group>),
    ) -> Self {
        let design = |(((point, wrong), estimate), inputs)| Design {
            point,
            wrong,
            estimate,
            inputs,
            measured: None,
            foreseen: None,
        };
        let designs = points.into_iter().zip(estimates).zip(inputs).map(design).collect();
        Self { designs, groups, figures: Figure::ALL.to_vec(), processes: Vec::new(), predictions: Vec::new() }
    }

    /// A design was replayed.
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

    /// Fits the surrogates to all that was measured.
    pub(super) fn learn(&mut self) {
        let known: Vec<(&Design, &Vec<f64>)> =
            self.designs.iter().filter_map(|design| Some((design, design.measured.as_ref()?))).collect();
        let points: Vec<Vec<f64>> = known.iter().map(|(design, _)| design.inputs.clone()).collect();
        let of_figure = |(at, figure): (usize, &Figure)| {
            let value = |(design, measured): &(&Design, &Vec<f64>)| {
                measured[at].max(LEAST).ln() - figure.estimated(&design.estimate).max(LEAST).ln()
            };
            let values: Vec<f64> = known.iter().map(value).collect();
            let last = self.processes.get(at).map(|it| it.kernel().clone());
            fit(last.unwrap_or_else(|| Kernel::new(self.groups.clone())), &points, &values)
        };
        self.processes = self.figures.par_iter().enumerate().map(of_figure).collect();
        self.predict();
    }

    /// Has the surrogates say of every design what they know by what was measured.
    pub(super) fn predict(&mut self) {
        let predict = |design: &Design| self.processes.iter().map(|process| process.predict(&design.inputs)).collect();
        self.predictions = self.designs.par_iter().map(predict).collect();
    }

    /// What is said of each figure of a design: the logarithms' means and standard deviations.
    pub(super) fn logarithms(&self, design: usize) -> Vec<(f64, f64)> {
        let estimate = &self.designs[design].estimate;
        let of = |(figure, found): (&Figure, &Prediction)| {
            (found.mean + figure.estimated(estimate).max(LEAST).ln(), found.deviation)
        };
        self.figures.iter().zip(&self.predictions[design]).map(of).collect()
    }

    /// What is said of each figure of a design.
    pub(super) fn foreseen(&self, design: usize) -> Vec<Foreseen> {
        let of = |((mean, deviation), process): ((f64, f64), &Process)| {
            let half = process.student() * deviation;
            Foreseen { mean: mean.exp(), low: (mean - half).exp(), high: (mean + half).exp() }
        };
        self.logarithms(design).into_iter().zip(&self.processes).map(of).collect()
    }

    /// The error of a figure's surrogate without the design itself at each measured one, as a logarithm, and half the
    /// width of its 95 % interval.
    pub(super) fn left_out(&self, figure: usize) -> Vec<(f64, f64)> {
        let process = &self.processes[figure];
        process.left_out_errors().into_iter().map(|(error, it)| (error, process.student() * it)).collect()
    }

    /// A design will be known: what is said of others becomes surer.
    pub(super) fn count_in(&mut self, chosen: usize) {
        let Self { processes, designs, predictions, .. } = self;
        let (inputs, own) = (&designs[chosen].inputs, predictions[chosen].clone());
        predictions.par_iter_mut().zip(designs.par_iter()).for_each(|(predictions, design)| {
            for ((process, own), found) in processes.iter().zip(&own).zip(predictions) {
                process.count_in((inputs, own), (&design.inputs, found));
            }
        });
    }
}
