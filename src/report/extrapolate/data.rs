//! Machines with many cores, predicted from scale models.

use serde::{Deserialize, Serialize};

/// Predictions for several large machines; `summary.json` holds them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub(crate) struct Extrapolations(pub Vec<Extrapolation>);

/// The prediction for a large machine on a stream.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Extrapolation {
    /// The stream's scene and policy.
    pub scene: String,
    /// The stream's policy.
    pub policy: String,
    /// The machine's name.
    pub machine: String,
    /// Cores of the large machine.
    pub cores: u64,
    /// Its DRAM, in words.
    pub dram: String,
    /// The fidelity level at which its scale models were replayed.
    pub fidelity: String,
    /// Rays that it traces.
    pub rays: u64,
    /// Rays of a frame per entry of its pool.
    pub rays_an_entry: f64,
    /// Its predicted rays per second.
    pub rays_per_second: f64,
    /// Its scale models, the smallest first.
    pub models: Vec<ScaleModel>,
    /// The predictions from the models.
    pub predicted: Figures<Prediction>,
    /// Its predicted energy in J; `None` if the energy of its DRAM is not known.
    pub joules: Option<Prediction>,
    /// The large machine's figures by `Event`; `None` if no check was requested.
    pub checked: Option<Figures<u64>>,
    /// Its energy in J by `Event`; `None` if no check was requested or the energy is not known.
    pub checked_joules: Option<f64>,
}

/// Figures of a scale model, scaled up to the rays of the large machine.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct ScaleModel {
    /// Its cores.
    pub cores: u64,
    /// Rays that it traced itself.
    pub rays: u64,
    /// The scaled figures.
    pub figures: Figures<f64>,
    /// The scaled energy in J; `None` if the energy of the DRAM is not known.
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

/// A figure of a large machine, and of its models.
pub(super) struct Told {
    /// Its name in texts, and in files.
    pub name: &'static str,
    pub key: &'static str,
    /// Its unit.
    pub unit: Unit,
    /// For each model, the smallest first: its cores, and its scaled figure.
    pub models: Vec<(u64, f64)>,
    /// The prediction.
    pub predicted: Prediction,
    /// The figure by `Event`, if it was checked.
    pub truth: Option<f64>,
}

/// The unit of a figure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Unit {
    Cycles,
    Bytes,
    Joules,
}

impl Unit {
    /// Its name in files.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Cycles => "cycles",
            Self::Bytes => "bytes",
            Self::Joules => "J",
        }
    }
}

/// A predicted figure.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Prediction {
    /// The figure by the law.
    pub value: f64,
    /// The lower end of a range that is symmetric around `value` and reaches as far as the other laws.
    pub low: f64,
    /// The upper end of the range.
    pub high: f64,
    /// A lower bound for every such machine: predictions are not below it.
    pub least: u64,
}

impl Extrapolation {
    /// The large machine in words.
    pub(super) fn name(&self) -> String {
        format!("{}, {} cores", self.machine, self.cores)
    }

    /// All figures; energy only if it is known.
    pub(super) fn told(&self) -> Vec<Told> {
        let names = [("cycles", "cycles"), ("L2 bytes", "l2_bytes"), ("DRAM bytes", "dram_bytes")];
        let figures = names.into_iter().zip([Unit::Cycles, Unit::Bytes, Unit::Bytes]).enumerate();
        let counts = figures.map(|(at, ((name, key), unit))| Told {
            name,
            key,
            unit,
            models: self.models.iter().map(|model| (model.cores, model.figures.all()[at])).collect(),
            predicted: self.predicted.all()[at],
            truth: self.checked.map(|checked| checked.all()[at] as f64),
        });
        let of_models = self.models.iter().map(|model| Some((model.cores, model.joules?))).collect();
        let energy = self.joules.zip(of_models).map(|(predicted, models): (_, Vec<_>)| Told {
            name: "energy",
            key: "energy",
            unit: Unit::Joules,
            models,
            predicted,
            truth: self.checked_joules,
        });
        counts.chain(energy).collect()
    }

    /// The relative errors of the predicted cycles, L2 bytes, DRAM bytes and energy; `None` without a check. A figure
    /// that is 0 by `Event` has no error.
    pub(super) fn errors(&self) -> Option<[Option<f64>; 4]> {
        let checked = self.checked?.all().map(|it| it as f64);
        let predicted = self.predicted.all();
        let off = |told: f64, truth: f64| (truth > 0.0).then(|| told / truth - 1.0);
        let energy = self.joules.zip(self.checked_joules).and_then(|(told, truth)| off(told.value, truth));
        let [cycles, l2, dram] = std::array::from_fn(|at| off(predicted[at].value, checked[at]));
        Some([cycles, l2, dram, energy])
    }
}
