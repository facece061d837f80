//! Reuse distances of a recorded stream on a machine.

use std::path::Path;

use crate::machine::MachineSpec;
use crate::replay::{Replay, ReuseOf, RunError, StreamFile};
use crate::report::reuse::ReuseSummary;
use crate::stream::StreamReader;

/// Measures the reuse of the stream at `stream` in the caches of `machine`.
pub(crate) fn reuse(machine: &MachineSpec, of: ReuseOf, stream: &Path) -> Result<ReuseSummary, RunError> {
    let header = StreamReader::open(stream)?.header().clone();
    let (stats, levels) = Replay::new(machine, &header)?.reuse(of, &StreamFile(stream))?;
    let of = match of {
        ReuseOf::Everything => "all lines".into(),
        ReuseOf::Sample { rate, hot } => format!("{} % of the lines and the {hot} hottest", rate.get() * 100.0),
    };
    let (scene, policy) = (header.scene, header.policy);
    Ok(ReuseSummary { machine: machine.name.clone(), scene, policy, of, stats, levels })
}
