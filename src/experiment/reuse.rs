//! Reuse distances of a recorded stream on a machine.

use std::path::Path;

use crate::engine::{self, ReuseOf, RunError};
use crate::machine::MachineSpec;
use crate::report::reuse::ReuseSummary;
use crate::stream::{StreamError, StreamReader};

/// Measures the stream at `stream` in the caches of `machine`.
pub(crate) fn reuse(machine: &MachineSpec, of: ReuseOf, stream: &Path) -> Result<ReuseSummary, RunError<StreamError>> {
    let header = StreamReader::open(stream).map_err(RunError::Source)?.header().clone();
    let (stats, levels) = engine::reuse(machine, of, &header, || StreamReader::open(stream))?;
    let of = match of {
        ReuseOf::Everything => "all lines".into(),
        ReuseOf::Sample { rate, hot } => format!("{} % of the lines and the {hot} hottest", rate.get() * 100.0),
    };
    let (scene, policy) = (header.scene, header.policy);
    Ok(ReuseSummary { machine: machine.name.clone(), scene, policy, of, stats, levels })
}
