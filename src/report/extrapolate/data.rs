//! Machines of many cores as their scale models predict them.

use serde::{Deserialize, Serialize};

/// What several large machines take; `summary.json` holds it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(transparent)]
pub(crate) struct Extrapolations(pub Vec<Extrapolation>);

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

/// A figure of a large machine, and of its models.
pub(super) struct Told {
    /// What it is called, and its name in files.
    pub name: &'static str,
    pub key: &'static str,
    /// Its unit.
    pub unit: Unit,
    /// Of each model, the smallest first: its cores, and what it stands for.
    pub models: Vec<(u64, f64)>,
    /// What follows.
    pub predicted: Prediction,
    /// What `Event` says, where that was asked for.
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
    /// By the law.
    pub value: f64,
    /// As far below and above as other laws are away.
    pub low: f64,
    /// See above.
    pub high: f64,
    /// The least that any such machine can take: predictions are not below it.
    pub least: u64,
}

impl Extrapolation {
    /// The large machine in words.
    pub(super) fn name(&self) -> String {
        format!("{}, {} cores", self.machine, self.cores)
    }

    /// All figures; the energy if it is known.
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

    /// What the prediction of each figure and of the energy is off, where it was checked; of what never moved, no
    /// share.
    pub(super) fn errors(&self) -> Option<[Option<f64>; 4]> {
        let checked = self.checked?.all().map(|it| it as f64);
        let predicted = self.predicted.all();
        let off = |told: f64, truth: f64| (truth > 0.0).then(|| told / truth - 1.0);
        let energy = self.joules.zip(self.checked_joules).and_then(|(told, truth)| off(told.value, truth));
        let [cycles, l2, dram] = std::array::from_fn(|at| off(predicted[at].value, checked[at]));
        Some([cycles, l2, dram, energy])
    }
}
