//! Builds the summary of a space for reports.

use std::collections::BTreeMap;

use super::super::sweep::{Sweep, SweepError};
use super::figure::{Figure, LEAST};
use super::front::unbeaten;
use super::pool::Pool;
use crate::report::space::{Accuracy, Design, Errors, PolicyPixels, Sensitivity, Size, SpaceSummary};

/// Puts a value for each figure under its name.
fn by_name<T>(pool: &Pool, values: impl IntoIterator<Item = T>) -> BTreeMap<String, T> {
    pool.figures().iter().map(|figure| figure.name().to_owned()).zip(values).collect()
}

/// The summary of a space that was explored.
///
/// # Errors
/// A machine cannot be made.
pub(super) fn summary(
    sweep: &Sweep,
    pool: &Pool,
    size: Size,
    policies: Vec<PolicyPixels>,
) -> Result<SpaceSummary, SweepError> {
    let experiment = &sweep.experiment;
    let design = |at: usize| design(sweep, pool, at, &policies[pool.designs[at].point.policy].policy);
    let mut designs = (0..pool.designs.len()).map(design).collect::<Result<Vec<_>, _>>()?;
    mark_front(&mut designs);
    Ok(SpaceSummary {
        experiment: experiment.spec.name.clone(),
        scene: experiment.scene.name.clone(),
        fidelity: experiment.spec.fidelity.to_string(),
        frames: experiment.frames.clone(),
        resolution: experiment.spec.resolution,
        size,
        designs,
        sensitivities: sensitivities(sweep, pool, &policies),
        accuracy: accuracy(pool),
        policies,
    })
}

fn design(sweep: &Sweep, pool: &Pool, at: usize, policy: &str) -> Result<Design, SweepError> {
    let design = &pool.designs[at];
    let machine = sweep.machine(design.point.machine)?;
    let changes = machine.changes.into_iter().filter(|change| design.point.role.has_field(&change.field)).collect();
    let predicted = pool.foreseen(at);
    let (figures, half_widths) = match &design.measured {
        Some(measured) => (by_name(pool, measured.clone()), BTreeMap::new()),
        None => (
            by_name(pool, predicted.iter().map(|it| it.mean)),
            by_name(pool, predicted.iter().map(|it| (it.high - it.low) / 2.0)),
        ),
    };
    let foreseen =
        design.foreseen.iter().flat_map(|all| by_name(pool, all.iter().map(|it| [it.mean, it.low, it.high])));
    let figure = |figure: Figure| figures.get(figure.name()).copied();
    Ok(Design {
        machine: machine.name,
        policy: policy.into(),
        changes,
        replayed: design.measured.is_some(),
        front: false,
        wrong_pixels: design.wrong,
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

/// The effect of each field on each figure, for each machine of the experiment and each policy: from all designs,
/// replayed or predicted.
fn sensitivities(sweep: &Sweep, pool: &Pool, policies: &[PolicyPixels]) -> Vec<Sensitivity> {
    let mut series: BTreeMap<(usize, usize), Vec<usize>> = BTreeMap::new();
    for (at, design) in pool.designs.iter().enumerate() {
        series.entry((sweep.base(design.point.machine), design.point.policy)).or_default().push(at);
    }
    let names: Vec<&str> = sweep.experiment.machines.iter().map(|(name, _)| name).collect();
    let mut found = Vec::new();
    for ((base, policy), designs) in series {
        for (at, figure) in pool.figures().iter().enumerate() {
            let logarithm = |&design: &usize| match &pool.designs[design].measured {
                Some(measured) => measured[at].max(LEAST).ln(),
                None => pool.logarithms(design)[at].0,
            };
            let logarithms: Vec<f64> = designs.iter().map(logarithm).collect();
            for (field, (path, tried)) in sweep.fields().zip(sweep.tried()).enumerate() {
                let has = |&&design: &&usize| pool.designs[design].point.role.has_field(path);
                let of = |&design: &usize| sweep.places(pool.designs[design].point.machine).nth(field);
                let places: Vec<usize> = designs.iter().filter(has).filter_map(of).collect();
                let Some(effect) = Effect::new(&places, &logarithms, tried.len()) else { continue };
                let value = |(place, change): (usize, f64)| (tried[place].clone(), change.exp_m1());
                found.push(Sensitivity {
                    machine: names[base].into(),
                    policy: policies[policy].policy.clone(),
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

/// The effect of a field on a figure's logarithm.
struct Effect {
    /// The places of the values with the lowest and the highest mean, and that mean minus the overall mean.
    least: (usize, f64),
    most: (usize, f64),
    share: f64,
}

impl Effect {
    /// From each design's place of its value and its logarithm; `None` without places.
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

fn accuracy(pool: &Pool) -> BTreeMap<String, Accuracy> {
    let of_figure = |(at, figure): (usize, &Figure)| {
        let foreseen = pool.designs.iter().filter_map(|design| {
            let (found, value) = (design.foreseen.as_ref()?[at], design.measured.as_ref()?[at]);
            Some(((found.mean / value - 1.0).abs(), (found.low..=found.high).contains(&value)))
        });
        let left_out = pool.left_out(at).into_iter().map(|(error, half)| (error.exp_m1().abs(), error.abs() <= half));
        let accuracy =
            Accuracy { foreseen: Errors::new(foreseen.collect()), left_out: Errors::new(left_out.collect()) };
        (figure.name().to_owned(), accuracy)
    };
    pool.figures().iter().enumerate().map(of_figure).collect()
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
