//! The recorded stream and the shipped machines for tests.

use std::path::Path;

use crate::machine::MachineSpec;
use crate::replay::{Fidelity, Replay};
use crate::ron_file;
use crate::stats::MachineStats;
use crate::stream::{Header, Item, StreamReader};

pub(crate) fn on(machine: &MachineSpec, header: &Header, fidelity: &str, stream: &[Item]) -> MachineStats {
    let fidelity: Fidelity = fidelity.parse().unwrap();
    let replay = Replay::new(machine, header).unwrap().fidelity(fidelity);
    replay.run(&stream).unwrap_or_else(|error| panic!("{fidelity}: {error}"))
}

pub(crate) fn quickstart() -> (Header, Vec<Item>) {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("traces/quickstart.rays");
    let reader = StreamReader::open(&file).unwrap();
    let header = reader.header().clone();
    (header, reader.collect::<Result<_, _>>().unwrap())
}

pub(crate) fn shipped(name: &str) -> MachineSpec {
    ron_file::read(&Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("configs/machines/{name}.ron"))).unwrap()
}
