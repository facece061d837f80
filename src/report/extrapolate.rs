//! Machines of many cores as their scale models predict them.

use serde::{Deserialize, Serialize};

use super::format::{bytes, exact, joules, or_absent, short, signed};
use super::grid::Grid;
use crate::quantity::Bytes;

/// What a large machine takes for a stream.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Extrapolation {
    /// The stream's scene and policy.
    pub scene: String,
    /// See above.
    pub policy: String,
    /// The machine's name.
    pub machine: String,
    /// Cores of the large machine.
    pub cores: u64,
    /// Its DRAM, in words.
    pub dram: String,
    /// What its scale models were replayed by.
    pub fidelity: String,
    /// Rays that it traces.
    pub rays: u64,
    /// Rays of a frame for each entry of its pool.
    pub rays_an_entry: f64,
    /// Its rays a second, as predicted.
    pub rays_per_second: f64,
    /// Its scale models, the smallest first.
    pub models: Vec<ScaleModel>,
    /// What follows from them.
    pub predicted: Figures<Prediction>,
    /// Its energy in J; none if that of its DRAM is not known.
    pub joules: Option<Prediction>,
    /// What the large machine took by `Event`; none if that was not asked for.
    pub checked: Option<Figures<u64>>,
    /// Its energy in J by `Event`; none if that was not asked for, or is not known.
    pub checked_joules: Option<f64>,
}

/// What a scale model measured, times as many as the rays that one of its rays stands for.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct ScaleModel {
    /// Its cores.
    pub cores: u64,
    /// Rays that it traced itself.
    pub rays: u64,
    /// What it stands for.
    pub figures: Figures<f64>,
    /// The energy in J that it stands for; none if that of the DRAM is not known.
    pub joules: Option<f64>,
}

/// The figures of a machine that are predicted.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Figures<T> {
    /// Cycles.
    pub cycles: T,
    /// Bytes between the L1s and the L2s.
    pub l2_bytes: T,
    /// Bytes of the DRAM.
    pub dram_bytes: T,
}

impl<T: Copy> Figures<T> {
    /// The figures in the order of tables.
    pub(crate) fn all(&self) -> [T; 3] {
        [self.cycles, self.l2_bytes, self.dram_bytes]
    }
}

/// A predicted figure.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Prediction {
    /// By the law.
    pub value: f64,
    /// As far below and above as other laws are away.
    pub low: f64,
    /// See above.
    pub high: f64,
    /// The least that any such machine can take: predictions are not below it.
    pub least: u64,
}

/// Rays of a frame for each entry of the pool, below which a frame is mostly its beginning and its end, so that it is
/// chance which rays a model has there: docs/validation/extrapolate.md.
const FEW: f64 = 32.0;

impl Extrapolation {
    /// The large machine in words.
    fn name(&self) -> String {
        format!("{}, {} cores", self.machine, self.cores)
    }

    /// What the prediction of each figure is off, where it was checked; of what never moved, no share.
    fn errors(&self) -> Option<[String; 4]> {
        let checked = self.checked?.all().map(|it| it as f64);
        let predicted = self.predicted.all();
        let off = |told: f64, truth: f64| (truth > 0.0).then(|| told / truth - 1.0);
        let energy = self.joules.zip(self.checked_joules).and_then(|(told, truth)| off(told.value, truth));
        let [cycles, l2, dram] = std::array::from_fn(|at| off(predicted[at].value, checked[at]));
        Some([cycles, l2, dram, energy].map(|off| or_absent(off, signed)))
    }
}

/// What was measured and predicted: a row a model, then the large machine.
pub(crate) fn grid(found: &Extrapolation) -> Grid {
    let name = format!("{}, {}", found.machine, found.policy);
    let head = [name.as_str(), "cycles", "L2 bytes", "DRAM bytes", "energy"].map(String::from);
    let shown = |[cycles, l2, dram]: [f64; 3], energy: Option<f64>| {
        [exact(cycles.round() as u64), amount(l2), amount(dram), or_absent(energy, joules)]
    };
    let row = |name: String, cells: [String; 4]| [name].into_iter().chain(cells).collect::<Vec<String>>();
    let mut rows: Vec<_> = found
        .models
        .iter()
        .map(|model| row(format!("model of {}", cores(model.cores)), shown(model.figures.all(), model.joules)))
        .collect();
    let predicted =
        |name: String, of: fn(Prediction) -> f64| row(name, shown(found.predicted.all().map(of), found.joules.map(of)));
    rows.push(predicted(format!("{} cores, predicted", found.cores), |it| it.value));
    rows.push(predicted("  from".into(), |it| it.low));
    rows.push(predicted("  to".into(), |it| it.high));
    if let (Some(checked), Some(errors)) = (found.checked, found.errors()) {
        rows.push(row(
            format!("{} cores, Event", found.cores),
            shown(checked.all().map(|it| it as f64), found.checked_joules),
        ));
        rows.push(row("  the prediction is off".into(), errors));
    }
    Grid { head: head.to_vec(), names: 1, rows }
}

/// A number with its prefix in front of a unit: `1.77 G`.
fn prefixed(value: f64) -> String {
    let text = short(value);
    if text.contains(' ') { text } else { format!("{text} ") }
}

fn amount(value: f64) -> String {
    bytes(Bytes(value.round() as u64))
}

fn cores(count: u64) -> String {
    if count == 1 { "1 core".into() } else { format!("{count} cores") }
}

/// What the table comes to, in a sentence.
pub(crate) fn verdict(found: &Extrapolation) -> String {
    let Prediction { value, low, high, .. } = found.predicted.cycles;
    let range = format!("{} to {}", exact(low.round() as u64), exact(high.round() as u64));
    let predicted = format!(
        "{} would take {} cycles ({range} by other laws), trace {}rays/s and move {} of DRAM traffic.",
        found.name(),
        exact(value.round() as u64),
        prefixed(found.rays_per_second),
        amount(found.predicted.dram_bytes.value),
    );
    let checked = found.errors().map(|[cycles, l2, dram, energy]| {
        let energy =
            if found.checked_joules.is_some() { format!(", and {energy} of the energy") } else { String::new() };
        format!(" By Event, the prediction is off by {cycles} of cycles, {l2} of L2 and {dram} of DRAM bytes{energy}.")
    });
    let few = (found.rays_an_entry < FEW).then(|| {
        format!(
            "\nFew rays: {:.0} a frame for each entry of the pool. It is chance which of them a model has where the \
             frame begins and ends: a larger picture tells more.",
            found.rays_an_entry
        )
    });
    format!("{predicted}{}{}\nThe large machine: {}.", checked.unwrap_or_default(), few.unwrap_or_default(), found.dram)
}
