//! A sweep's spec, and the machines that it derives from an experiment's machines.

use std::path::{Path, PathBuf};

use ron::value::RawValue;
use rustc_hash::FxHashSet;
use schemars::JsonSchema;
use serde::Deserialize;
use xxhash_rust::xxh3::xxh3_128;

use super::super::files::named;
use super::super::frames::FrameRange;
use super::super::load::{Experiment, Overrides};
use super::super::set;
use super::draw::{Draw, MAX_FIELDS};
use super::error::SweepError;
use super::values::{Tried, Values};
use crate::json;
use crate::machine::MachineSpec;
use crate::named::{Named, twice};
use crate::quantity::Resolution;
use crate::ranged::Within;
use crate::replay::{Cut, Fidelity, Lengths, Share};
use crate::report::format::counted;
use crate::report::sweep::{Change, Own};
use crate::ron_file::{self, ConfigError, Kind};

/// The most machines of a sweep: some years of replays.
const MAX_MACHINES: u128 = 100_000;

/// A sweep: replays one experiment on many machines that differ in the fields of `vary`.
#[derive(Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(crate) struct SweepSpec {
    /// The experiment that gives streams and machines. The path is relative to this file.
    experiment: PathBuf,
    /// Overrides the experiment's frames.
    #[serde(default)]
    frames: Option<FrameRange>,
    /// Overrides the experiment's resolution.
    #[serde(default)]
    resolution: Option<Resolution>,
    /// Overrides the experiment's fidelity level.
    #[serde(default)]
    fidelity: Option<Fidelity>,
    /// Paths of fields in the machine file, each with the values to try. Values are a list; in a space also `Log(256,
    /// 65536)` (each value is twice the previous one) or `Integers(1, 8)`.
    #[schemars(with = "Named<Values>")]
    vary: Named<Box<RawValue>>,
    /// Which combinations of values are tried.
    #[serde(default)]
    points: Points,
}

impl SweepSpec {
    /// The number of replays that a space allows; `None` if the machines are not a space.
    pub(super) fn budget(&self) -> Option<usize> {
        match self.points {
            Points::Space(space) => Some(space.budget.size()),
            Points::Single | Points::All => None,
        }
    }
}

/// What the command line sets in place of the sweep's file.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct ChosenLevel {
    /// The fidelity level.
    pub(crate) fidelity: Option<Fidelity>,
    /// The target error: samples grow until the intervals are within this share.
    pub(crate) target_error: Option<Share>,
}

/// Which combinations of values are tried.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
enum Points {
    /// The baseline machine, and each value alone.
    #[default]
    Single,
    /// All combinations.
    All,
    /// A space: many combinations, of which a few are replayed and the others are predicted.
    Space(SpaceSpec),
}

/// A space of machines: a few replays predict the figures of many machines.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub(in super::super) struct SpaceSpec {
    /// Number of machines in the space. They are spread evenly over all combinations; if there are fewer combinations,
    /// all are taken.
    #[serde(default = "machines_of_a_space")]
    pub(in super::super) machines: Within<2, 10_000>,
    /// Maximum number of replays, all machines and policies together.
    pub(in super::super) budget: Within<1, 10_000>,
}

fn machines_of_a_space() -> Within<2, 10_000> {
    const { Within::literal(1000) }
}

/// A sweep with everything that its files name.
pub(in super::super) struct Sweep {
    /// The sweep's file. Paths in `vary` are relative to its folder.
    path: PathBuf,
    pub(in super::super) experiment: Experiment,
    fields: Vec<Field>,
    /// All machines, in the order of the files, without duplicates.
    machines: Vec<Combination>,
    /// The spec of the space, if the machines are one.
    pub(in super::super) space: Option<SpaceSpec>,
    /// The number of combinations, and of those that are invalid machines.
    pub(in super::super) combined: Combined,
    /// The cut of samples for each of the experiment's machines. All machines derived from it share the cut, so that
    /// the effect of a field can be compared window by window. Empty where nothing is sampled.
    cuts: Vec<Cut>,
    /// For each of the experiment's machines, the baseline of those derived from it: the first of them. Empty where
    /// samples have no target error.
    baselines: Vec<MachineSpec>,
}

/// Combinations of values in a space.
#[derive(Clone, Debug, Default)]
pub(in super::super) struct Combined {
    /// The number of all combinations, for one machine of the experiment.
    pub(in super::super) all: u128,
    /// The number of drawn combinations that are invalid, since their values do not fit together.
    pub(in super::super) left_out: usize,
    /// Why the first invalid combination is invalid.
    pub(in super::super) why: Option<String>,
}

/// A field of a machine's spec, and the values to try.
struct Field {
    path: String,
    values: Vec<String>,
}

/// A machine of the experiment, and the values that some of its fields get.
struct Combination {
    base: usize,
    /// Indices of a field and of one of its values.
    values: Vec<(usize, usize)>,
}

/// A machine of the sweep.
pub(in super::super) struct Machine {
    pub(in super::super) name: String,
    pub(in super::super) changes: Vec<Change>,
    pub(in super::super) spec: MachineSpec,
}

impl Sweep {
    /// Reads the sweep of the file `path` and all files that it names, and checks every machine.
    pub(in super::super) fn load(path: &Path, level: ChosenLevel) -> Result<Self, SweepError> {
        let spec: SweepSpec = ron_file::read(path)?;
        let overrides = Overrides { frames: spec.frames, resolution: spec.resolution, ..Overrides::default() };
        let experiment = Experiment::load(&named(Kind::Experiment, path, &spec.experiment), overrides);
        let mut experiment = experiment.map_err(|error| error.named_in(path))?;
        let wrong = |what: String| ConfigError::Content { path: path.into(), what };
        let fidelity = level.fidelity.or(spec.fidelity).unwrap_or(experiment.spec.fidelity);
        let sampled = level.target_error.map_or(Ok(fidelity), |target| fidelity.with_target_error(target));
        experiment.spec.fidelity = sampled.map_err(wrong)?;
        let mut fields = Vec::new();
        for (field, raw) in spec.vary.iter() {
            let tried = Tried::read(field, raw).map_err(wrong)?;
            if tried.is_range && !matches!(spec.points, Points::Space(_)) {
                let listed = tried.values.join(", ");
                let what = "a range is for a space of machines (`points: Space(budget: 60)`)";
                return Err(
                    wrong(format!("`vary` has a range for `{field}`: {what}; as a list it is [{listed}]")).into()
                );
            }
            if field == "name" {
                return Err(wrong("`vary` has `name`: machines of other names are the same machine".into()).into());
            }
            if let Some(value) = twice(&tried.values) {
                return Err(wrong(format!("`vary` has `{value}` twice for `{field}`")).into());
            }
            fields.push(Field { path: field.into(), values: tried.values });
        }
        let combined = Combined::default();
        let path = path.to_owned();
        let mut sweep = Self {
            path,
            experiment,
            fields,
            machines: Vec::new(),
            space: None,
            combined,
            cuts: Vec::new(),
            baselines: Vec::new(),
        };
        sweep.combine(spec.points).map_err(wrong)?;
        if sweep.experiment.spec.fidelity.samples() {
            for base in 0..sweep.experiment.machines.len() {
                let of_base = (0..sweep.len()).filter(|&machine| sweep.base(machine) == base);
                let of_machine = |machine| Ok::<_, SweepError>(Lengths::new(&sweep.machine(machine)?.spec));
                sweep.cuts.extend(Cut::common(of_base.map(of_machine).collect::<Result<Vec<_>, _>>()?));
                if sweep.experiment.spec.fidelity.has_target() {
                    sweep.baselines.push(sweep.machine(sweep.first(base))?.spec);
                }
            }
        }
        Ok(sweep)
    }

    /// The values that the varied fields have in the machines' files.
    pub(in super::super) fn own_values(&self) -> Vec<Own> {
        let of_machine = |(name, spec): (&str, &MachineSpec)| -> Vec<Own> {
            let own = |field: &Field| {
                let value = set::value(spec, &field.path)?;
                let text = value.as_str().map_or_else(|| value.to_string(), str::to_owned);
                Some(Own { machine: name.into(), field: field.path.clone(), value: text })
            };
            self.fields.iter().filter_map(own).collect()
        };
        self.experiment.machines.iter().flat_map(of_machine).collect()
    }

    /// Paths of the fields that vary.
    pub(in super::super) fn fields(&self) -> impl Iterator<Item = &str> {
        self.fields.iter().map(|field| field.path.as_str())
    }

    /// The number of machines in a space's first set, per machine of the experiment and policy; `None` if the machines
    /// are not a space.
    pub(in super::super) fn first_set(&self) -> Option<usize> {
        let series = self.experiment.machines.len() * self.experiment.spec.policies.len();
        self.space.map(|space| (space.budget.size() / 2 / series.max(1)).max(1))
    }

    /// The index of a machine's base among the experiment's machines.
    pub(in super::super) fn base(&self, index: usize) -> usize {
        self.machines[index].base
    }

    /// The cut of a machine's samples; `None` if nothing is sampled.
    pub(in super::super) fn cut(&self, index: usize) -> Option<Cut> {
        self.cuts.get(self.base(index)).copied()
    }

    /// The baseline of a machine; `None` if samples have no target error.
    pub(in super::super) fn baseline(&self, index: usize) -> Option<&MachineSpec> {
        self.baselines.get(self.base(index))
    }

    /// The first machine that is derived from machine `base` of the experiment.
    pub(in super::super) fn first(&self, base: usize) -> usize {
        self.machines.iter().position(|machine| machine.base == base).unwrap_or_default()
    }

    /// Whether a machine has only the values of its file.
    pub(in super::super) fn is_as_in_its_file(&self, index: usize) -> bool {
        self.machines[index].values.is_empty()
    }

    /// The indices of a machine's values among those tried for its fields.
    pub(in super::super) fn places(&self, index: usize) -> impl Iterator<Item = usize> {
        self.machines[index].values.iter().map(|(_, place)| *place)
    }

    /// The values tried for each field.
    pub(in super::super) fn tried(&self) -> impl Iterator<Item = &[String]> {
        self.fields.iter().map(|field| field.values.as_slice())
    }

    /// The number of machines.
    pub(in super::super) fn len(&self) -> usize {
        self.machines.len()
    }

    /// Builds a machine. Reading the sweep has checked it.
    pub(in super::super) fn machine(&self, index: usize) -> Result<Machine, SweepError> {
        let made = self.make(&self.machines[index]);
        made.map_err(|what| ConfigError::Content { path: self.path.clone(), what }.into())
    }

    /// Finds all machines. A value that a machine's file already has gives no further machine.
    fn combine(&mut self, points: Points) -> Result<(), String> {
        if self.experiment.machines.is_empty() {
            return Err(format!("the experiment `{}` has no machines", self.experiment.spec.name));
        }
        let values = self.fields.iter().map(|field| field.values.len() as u128);
        let each = match points {
            Points::Space(space) => return self.draw(space),
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
                let spec = json::line(&machine.spec).expect("a spec is plain data, which JSON can hold");
                if seen.insert((base, xxh3_128(spec.as_bytes()))) {
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
            Points::Single | Points::Space(_) => {
                // 0 is the machine as it is.
                let all = self.fields.iter().enumerate();
                let mut all = all.flat_map(|(field, of)| (0..of.values.len()).map(move |value| (field, value)));
                number.checked_sub(1).and_then(|number| all.nth(number)).into_iter().collect()
            }
        }
    }

    /// Draws the machines of a space: the same number for each of the experiment's machines.
    fn draw(&mut self, space: SpaceSpec) -> Result<(), String> {
        self.space = Some(space);
        if self.fields.len() > MAX_FIELDS {
            return Err(format!("`vary` has {} fields: up to {MAX_FIELDS} are allowed in a space", self.fields.len()));
        }
        self.try_each_value()?;
        let bases = self.experiment.machines.len();
        let policies = self.experiment.spec.policies.len();
        let least = 2 * (self.fields.len() + 2).max(2 * bases * policies);
        if space.budget.size() < least {
            return Err(format!(
                "`budget` is {}: at least {least} replays are needed to tell {} apart on {} under {}",
                space.budget,
                counted(self.fields.len(), "field"),
                counted(bases, "machine"),
                counted(policies, "policy"),
            ));
        }
        for base in 0..bases {
            let mut draw = Draw::new(self.fields.iter().map(|field| field.values.len()).collect());
            self.combined.all = draw.all();
            let mut seen = FxHashSet::default();
            while seen.len() < space.machines.size().div_ceil(bases) {
                let Some(places) = draw.next() else { break };
                let combination = Combination { base, values: places.into_iter().enumerate().collect() };
                match self.make(&combination) {
                    Ok(machine) => {
                        let spec = json::line(&machine.spec).expect("a spec is plain data, which JSON can hold");
                        if seen.insert(xxh3_128(spec.as_bytes())) {
                            self.machines.push(combination);
                        }
                    }
                    Err(why) => {
                        self.combined.left_out += 1;
                        self.combined.why.get_or_insert(why);
                    }
                }
            }
            if seen.len() < 2 {
                let why = self.combined.why.take().unwrap_or("`vary` has no more combinations".into());
                return Err(format!("the space has {} of the two machines that it needs at least: {why}", seen.len()));
            }
        }
        Ok(())
    }

    /// Sets each value alone, so that an unknown field or a bad value is refused before combinations are tried.
    fn try_each_value(&self) -> Result<(), String> {
        for (name, base) in self.experiment.machines.iter() {
            for Field { path, values } in &self.fields {
                for value in values {
                    let wrong = |what| format!("`vary` has the value `{value}` for `{path}` of `{name}`: {what}");
                    ron_file::beside(&self.path, || set::field(base, path, value)).map_err(wrong)?;
                }
            }
        }
        Ok(())
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
            spec = ron_file::beside(&self.path, || set::field(&spec, field, value)).map_err(wrong)?;
        }
        spec.check().map_err(|error| format!("machine `{name}` with {}: {error}", listed(&changes)))?;
        let changes = changes.into_iter().map(|(field, value)| Change { field: field.into(), value: value.into() });
        Ok(Machine { name: name.into(), changes: changes.collect(), spec })
    }
}

fn listed(changes: &[(&str, &str)]) -> String {
    changes.iter().map(|(field, value)| format!("`{field}: {value}`")).collect::<Vec<_>>().join(", ")
}
