//! The points of a sweep as data, to be written to a file.

use serde::Serialize;
use serde_json::{Map, Value};

use super::super::set;
use super::super::split::Role;
use super::error::SweepError;
use super::plan::{Plan, Point};
use super::spec::Sweep;
use crate::machine::MachineSpec;

/// The points of a sweep, in the order of its files.
pub(crate) struct Listing {
    /// Paths of the fields that vary.
    pub(crate) fields: Vec<String>,
    /// The points.
    pub(crate) points: Vec<Listed>,
}

/// A point: a replay of a policy's stream on a machine.
#[derive(Serialize)]
pub(crate) struct Listed {
    /// The point's number in the plan, from 1.
    pub(crate) index: usize,
    /// The machine's name.
    pub(crate) machine: String,
    /// The policy's name.
    pub(crate) policy: String,
    /// The machine's role.
    pub(crate) role: &'static str,
    /// Values of the fields that vary, without those of a unit that the machine does not have in this role.
    pub(crate) fields: Map<String, Value>,
    /// A hash of the inputs of the replay.
    pub(crate) identity: String,
    /// Expected cost: the number of rays whose replay without culling takes as long.
    pub(crate) cost: u64,
}

impl Listing {
    pub(super) fn new(sweep: &Sweep, plan: &Plan) -> Result<Self, SweepError> {
        let fields: Vec<String> = sweep.fields().map(str::to_owned).collect();
        let policies: Vec<&str> = sweep.experiment.policy_names().collect();
        let listed = |(index, point): (usize, &Point)| {
            let machine = sweep.machine(point.machine)?;
            let spec = point.role.machine(&machine.spec);
            Ok(Listed {
                index: index + 1,
                machine: machine.name,
                policy: policies[point.policy].into(),
                role: point.role.name(),
                fields: values(&spec, point.role, &fields),
                identity: point.key.to_string(),
                cost: point.cost,
            })
        };
        let points = plan.points.iter().enumerate().map(listed).collect::<Result<_, SweepError>>()?;
        Ok(Self { fields, points })
    }
}

/// The fields' values in a machine, without those that do not exist in this role.
fn values(machine: &MachineSpec, role: Role, fields: &[String]) -> Map<String, Value> {
    let has = |field: &&String| role.has_field(field);
    fields.iter().filter(has).filter_map(|field| Some((field.clone(), set::value(machine, field)?))).collect()
}
