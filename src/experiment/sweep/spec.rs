//! A sweep's file, and the machines that it makes of an experiment's.

use std::path::{Path, PathBuf};

use ron::value::RawValue;
use rustc_hash::FxHashSet;
use schemars::JsonSchema;
use serde::Deserialize;
use serde_json::Value;
use xxhash_rust::xxh3::xxh3_128;

use super::super::files::named;
use super::super::frames::FrameRange;
use super::super::load::{Experiment, Overrides};
use super::super::set;
use super::error::SweepError;
use crate::machine::MachineSpec;
use crate::named::Named;
use crate::quantity::Resolution;
use crate::replay::{Fidelity, Share};
use crate::report::sweep::{Change, Own};
use crate::ron_file::{self, ConfigError, Kind};

/// The most machines of a sweep: some years of replays.
const MAX_MACHINES: u128 = 100_000;

/// A sweep as its RON file says it.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct SweepSpec {
    /// The experiment whose streams and machines are used, relative to this file.
    experiment: PathBuf,
    /// Other frames than the experiment's.
    #[serde(default)]
    frames: Option<FrameRange>,
    /// Another size of the pictures.
    #[serde(default)]
    resolution: Option<Resolution>,
    /// Another fidelity level than the experiment's.
    #[serde(default)]
    fidelity: Option<Fidelity>,
    /// Paths of fields in a machine's file, each with the values to try.
    #[schemars(with = "Named<Vec<Value>>")]
    vary: Named<Vec<Box<RawValue>>>,
    /// Which combinations.
    #[serde(default)]
    points: Points,
}

/// What the command line sets in place of a sweep's file.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct ChosenLevel {
    /// The fidelity level.
    pub(crate) fidelity: Option<Fidelity>,
    /// Sample until the intervals are within this share.
    pub(crate) target_error: Option<Share>,
}

/// Which combinations of values are tried.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
enum Points {
    /// The machine as it is, and each value alone.
    #[default]
    Single,
    /// All combinations.
    All,
}

/// A sweep with everything that its files name.
pub(super) struct Sweep {
    pub(super) experiment: Experiment,
    fields: Vec<Field>,
    /// All machines, in the order of the files: no two of them are the same.
    machines: Vec<Combination>,
}

/// A field of a machine's spec, and the values to try.
struct Field {
    path: String,
    values: Vec<String>,
}

/// A machine of the experiment, and the places of the values that it gets.
struct Combination {
    base: usize,
    /// A field, and one of its values.
    values: Vec<(usize, usize)>,
}

/// A machine of the sweep.
pub(super) struct Machine {
    pub(super) name: String,
    pub(super) changes: Vec<Change>,
    pub(super) spec: MachineSpec,
}

impl Sweep {
    /// Reads the sweep of the file `path` and all files that it names, and checks every machine.
    pub(super) fn load(path: &Path, level: ChosenLevel) -> Result<Self, SweepError> {
        let spec: SweepSpec = ron_file::read(path)?;
        let overrides = Overrides { frames: spec.frames, resolution: spec.resolution, ..Overrides::default() };
        let mut experiment = Experiment::load(&named(Kind::Experiment, path, &spec.experiment), overrides)?;
        let wrong = |what: String| ConfigError::Content { path: path.into(), what };
        let fidelity = level.fidelity.or(spec.fidelity).unwrap_or(experiment.spec.fidelity);
        let sampled = level.target_error.map_or(Ok(fidelity), |target| fidelity.with_target_error(target));
        experiment.spec.fidelity = sampled.map_err(wrong)?;
        let values = |values: &[Box<RawValue>]| values.iter().map(|value| value.get_ron().trim().to_owned()).collect();
        let fields = spec.vary.iter().map(|(path, tried)| Field { path: path.into(), values: values(tried) }).collect();
        let mut sweep = Self { experiment, fields, machines: Vec::new() };
        sweep.combine(spec.points).map_err(wrong)?;
        Ok(sweep)
    }

    /// The values that the varied fields have in the machines' files.
    pub(super) fn own_values(&self) -> Vec<Own> {
        let of_machine = |(name, spec): (&str, &MachineSpec)| -> Vec<Own> {
            let spec = serde_json::to_value(spec).expect("a spec is plain data, which JSON can hold");
            let own = |field: &Field| {
                let value = field.path.split('.').try_fold(&spec, |place, name| place.get(name))?;
                let text = value.as_str().map_or_else(|| value.to_string(), str::to_owned);
                Some(Own { machine: name.into(), field: field.path.clone(), value: text })
            };
            self.fields.iter().filter_map(own).collect()
        };
        self.experiment.machines.iter().flat_map(of_machine).collect()
    }

    /// Paths of the fields that vary.
    pub(super) fn fields(&self) -> impl Iterator<Item = &str> {
        self.fields.iter().map(|field| field.path.as_str())
    }

    /// How many machines there are.
    pub(super) fn len(&self) -> usize {
        self.machines.len()
    }

    /// A machine. It was checked when the sweep was read.
    pub(super) fn machine(&self, index: usize) -> Result<Machine, SweepError> {
        let made = self.make(&self.machines[index]);
        let path = &self.experiment.spec.name;
        made.map_err(|what| ConfigError::Content { path: path.into(), what }.into())
    }

    /// Finds all machines. A value that a machine has already makes no machine of its own.
    fn combine(&mut self, points: Points) -> Result<(), String> {
        if let Some(field) = self.fields.iter().find(|field| field.values.is_empty()) {
            return Err(format!("`vary` has no value for `{}`: at least one is needed", field.path));
        }
        if self.experiment.machines.is_empty() {
            return Err(format!("the experiment `{}` has no machines", self.experiment.spec.name));
        }
        let values = self.fields.iter().map(|field| field.values.len() as u128);
        let each = match points {
            Points::Single => 1 + values.sum::<u128>(),
            Points::All => values.fold(1, u128::saturating_mul),
        };
        let count = each.saturating_mul(self.experiment.machines.len() as u128);
        if count > MAX_MACHINES {
            return Err(format!("`vary` makes {count} machines: up to {MAX_MACHINES} are allowed"));
        }
        let mut seen = FxHashSet::default();
        for base in 0..self.experiment.machines.len() {
            for number in 0..each as usize {
                let combination = Combination { base, values: self.values(points, number) };
                let machine = self.make(&combination)?;
                let spec = serde_json::to_vec(&machine.spec).expect("a spec is plain data, which JSON can hold");
                if seen.insert((base, xxh3_128(&spec))) {
                    self.machines.push(combination);
                }
            }
        }
        Ok(())
    }

    /// Fields and values of combination `number`. The first field's value changes fastest.
    fn values(&self, points: Points, number: usize) -> Vec<(usize, usize)> {
        let mut rest = number;
        match points {
            Points::All => {
                let value = |(field, of): (usize, &Field)| {
                    let value = rest % of.values.len();
                    rest /= of.values.len();
                    (field, value)
                };
                self.fields.iter().enumerate().map(value).collect()
            }
            Points::Single => {
                // 0 is the machine as it is.
                let all = self.fields.iter().enumerate();
                let mut all = all.flat_map(|(field, of)| (0..of.values.len()).map(move |value| (field, value)));
                number.checked_sub(1).and_then(|number| all.nth(number)).into_iter().collect()
            }
        }
    }

    fn make(&self, combination: &Combination) -> Result<Machine, String> {
        let all = self.experiment.machines.iter().nth(combination.base);
        let (name, base) = all.ok_or("there is no such machine")?;
        let values = combination.values.iter();
        let changes: Vec<(&str, &str)> = values
            .map(|&(field, value)| (self.fields[field].path.as_str(), self.fields[field].values[value].as_str()))
            .collect();
        let mut spec = base.clone();
        for &(field, value) in &changes {
            let wrong = |what: String| format!("`vary` has the value `{value}` for `{field}`: {what}");
            spec = set::field(&spec, field, value).map_err(wrong)?;
        }
        spec.check().map_err(|error| format!("machine `{name}` with {}: {error}", listed(&changes)))?;
        let changes = changes.into_iter().map(|(field, value)| Change { field: field.into(), value: value.into() });
        Ok(Machine { name: name.into(), changes: changes.collect(), spec })
    }
}

fn listed(changes: &[(&str, &str)]) -> String {
    changes.iter().map(|(field, value)| format!("`{field}: {value}`")).collect::<Vec<_>>().join(", ")
}
