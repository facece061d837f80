//! What was found, as a report has it.

use std::collections::BTreeMap;

use super::super::sweep::{Sweep, SweepError};
use super::front::unbeaten;
use super::series::{Figure, Series};
use crate::report::space::{Accuracy, Design, Errors, PolicyPixels, Sensitivity, Size, SpaceSummary};

/// Puts a value for each figure under its name.
fn by_name<T>(series: &Series, values: impl IntoIterator<Item = T>) -> BTreeMap<String, T> {
    series.figures().iter().map(|figure| figure.name().to_owned()).zip(values).collect()
}

/// The summary of a space that was explored.
///
/// # Errors
/// A machine cannot be made.
pub(super) fn summary(
    sweep: &Sweep,
    all: &[Series],
    size: Size,
    policies: Vec<PolicyPixels>,
) -> Result<SpaceSummary, SweepError> {
    let experiment = &sweep.experiment;
    let mut designs = Vec::new();
    for series in all {
        for at in 0..series.designs.len() {
            designs.push(design(sweep, series, at, &policies[series.policy])?);
        }
    }
    mark_front(&mut designs);
    Ok(SpaceSummary {
        experiment: experiment.spec.name.clone(),
        scene: experiment.scene.name.clone(),
        fidelity: experiment.spec.fidelity.to_string(),
        frames: experiment.frames.clone(),
        resolution: experiment.spec.resolution,
        size,
        designs,
        sensitivities: sensitivities(sweep, all, &policies),
        accuracy: accuracy(all),
        policies,
    })
}

fn design(sweep: &Sweep, series: &Series, at: usize, policy: &PolicyPixels) -> Result<Design, SweepError> {
    let design = &series.designs[at];
    let machine = sweep.machine(design.point.machine)?;
    let changes = machine.changes.into_iter().filter(|change| design.point.role.has_field(&change.field)).collect();
    let predicted = series.foreseen(at);
    let (figures, half_widths) = match &design.measured {
        Some(measured) => (by_name(series, measured.clone()), BTreeMap::new()),
        None => (
            by_name(series, predicted.iter().map(|it| it.mean)),
            by_name(series, predicted.iter().map(|it| (it.high - it.low) / 2.0)),
        ),
    };
    let foreseen =
        design.foreseen.iter().flat_map(|all| by_name(series, all.iter().map(|it| [it.mean, it.low, it.high])));
    let figure = |figure: Figure| figures.get(figure.name()).copied();
    Ok(Design {
        machine: machine.name,
        policy: policy.policy.clone(),
        changes,
        replayed: design.measured.is_some(),
        front: false,
        wrong_pixels: series.wrong,
        cycles: figure(Figure::Cycles).unwrap_or_default(),
        dram_bytes: figure(Figure::DramBytes).unwrap_or_default(),
        joules: figure(Figure::Joules),
        half_widths,
        foreseen: foreseen.collect(),
    })
}

/// Marks the replayed designs that no other replayed one beats.
fn mark_front(designs: &mut [Design]) {
    let replayed: Vec<&mut Design> = designs.iter_mut().filter(|design| design.replayed).collect();
    let of = |it: &&mut Design| vec![it.cycles, it.dram_bytes, it.joules.unwrap_or(0.0), it.wrong_pixels as f64];
    let front = unbeaten(&replayed.iter().map(of).collect::<Vec<_>>());
    replayed.into_iter().zip(front).for_each(|(design, front)| design.front = front);
}

/// What each field does to each figure, from all designs, replayed or predicted.
fn sensitivities(sweep: &Sweep, all: &[Series], policies: &[PolicyPixels]) -> Vec<Sensitivity> {
    let mut found = Vec::new();
    for series in all {
        let Some(first) = series.designs.first() else { continue };
        let name = sweep.experiment.machines.iter().nth(series.base).map_or("", |(name, _)| name);
        for (at, figure) in series.figures().iter().enumerate() {
            let logarithm = |number: usize| match &series.designs[number].measured {
                Some(measured) => measured[at].max(1e-30).ln(),
                None => series.logarithms(number)[at].0,
            };
            let logarithms: Vec<f64> = (0..series.designs.len()).map(logarithm).collect();
            for (field, (path, tried)) in sweep.fields().zip(sweep.tried()).enumerate() {
                if !first.point.role.has_field(path) {
                    continue;
                }
                let place = |number: usize| sweep.places(series.designs[number].point.machine).nth(field);
                let places: Vec<usize> = (0..series.designs.len()).filter_map(place).collect();
                let Some(effect) = Effect::new(&places, &logarithms, tried.len()) else { continue };
                let value = |(place, change): (usize, f64)| (tried[place].clone(), change.exp() - 1.0);
                found.push(Sensitivity {
                    machine: name.into(),
                    policy: policies[series.policy].policy.clone(),
                    field: path.into(),
                    figure: figure.name().into(),
                    least: value(effect.least),
                    most: value(effect.most),
                    share: effect.share,
                });
            }
        }
    }
    found
}

/// What a field does to a logarithm.
struct Effect {
    /// The values' places with the least and the most mean, less the mean of all.
    least: (usize, f64),
    most: (usize, f64),
    share: f64,
}

impl Effect {
    /// Of designs with a value's place and a logarithm each; none if all are the same.
    fn new(places: &[usize], logarithms: &[f64], values: usize) -> Option<Self> {
        let count = logarithms.len() as f64;
        let mean = logarithms.iter().sum::<f64>() / count;
        let variance = logarithms.iter().map(|it| (it - mean).powi(2)).sum::<f64>() / count;
        let mut sums = vec![(0.0, 0.0); values];
        for (&place, logarithm) in places.iter().zip(logarithms) {
            sums[place].0 += 1.0;
            sums[place].1 += logarithm - mean;
        }
        let explained: f64 = sums.iter().filter(|(times, _)| *times > 0.0).map(|(times, sum)| sum * sum / times).sum();
        let means =
            || sums.iter().enumerate().filter(|(_, (times, _))| *times > 0.0).map(|(at, (n, sum))| (at, sum / n));
        let least = means().min_by(|a, b| a.1.total_cmp(&b.1))?;
        let most = means().max_by(|a, b| a.1.total_cmp(&b.1))?;
        let share = if variance > 0.0 { explained / count / variance } else { 0.0 };
        Some(Self { least, most, share })
    }
}

fn accuracy(all: &[Series]) -> BTreeMap<String, Accuracy> {
    let mut errors: BTreeMap<String, [Vec<(f64, bool)>; 2]> = BTreeMap::new();
    for series in all {
        for (at, figure) in series.figures().iter().enumerate() {
            let [foreseen, left_out] = errors.entry(figure.name().into()).or_default();
            for design in &series.designs {
                if let (Some(found), Some(measured)) = (&design.foreseen, &design.measured) {
                    let (found, value) = (found[at], measured[at]);
                    foreseen.push(((found.mean / value - 1.0).abs(), found.low <= value && value <= found.high));
                }
            }
            left_out.extend(
                series.left_out(at).into_iter().map(|(error, half)| (error.exp_m1().abs(), error.abs() <= half)),
            );
        }
    }
    let summed = |(name, [foreseen, left_out]): (String, [Vec<_>; 2])| {
        (name, Accuracy { foreseen: Errors::new(foreseen), left_out: Errors::new(left_out) })
    };
    errors.into_iter().map(summed).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fields_effect_is_that_of_its_values_means() {
        let effect = Effect::new(&[0, 0, 1, 1], &[1.0, 1.0, 3.0, 3.0], 3).unwrap();
        assert_eq!((effect.least, effect.most, effect.share), ((0, -1.0), (1, 1.0), 1.0));
        let none = Effect::new(&[0, 1, 0, 1], &[1.0, 1.0, 3.0, 3.0], 2).unwrap();
        assert_eq!((none.least.1, none.most.1, none.share), (0.0, 0.0, 0.0));
    }
}
