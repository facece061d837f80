//! The points that a sweep keeps: measurements of replays. Each has a file named by a hash of its inputs, with a
//! checksum and the build of the program that made it.

use std::fmt;
use std::io;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use xxhash_rust::xxh3::xxh3_128;

use super::streams::{BUILD, Identity};
use crate::input;
use crate::json;
use crate::machine::MachineSpec;
use crate::output::write_whole;
use crate::replay::{Cut, Fidelity};
use crate::stats::MachineStats;
use crate::stream::Totals;

/// The largest file of a point, in bytes.
const MAX_POINT_BYTES: u64 = 1 << 24;

/// A hash of the inputs of a replay. A point depends only on these inputs and on the program's build.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(into = "String", try_from = "String")]
pub(in super::super) struct Key(u128);

impl Key {
    /// A hash of several keys in order: the identity of a plan.
    pub(super) fn of_all(keys: impl Iterator<Item = Self>) -> Self {
        Self(xxh3_128(&keys.flat_map(|key| key.0.to_le_bytes()).collect::<Vec<u8>>()))
    }

    /// The key of a replay: stream, fidelity level, cut of samples, machine, and baseline if there is one. Machine
    /// names are left out, since they change no result.
    pub(super) fn new(
        stream: Identity,
        (fidelity, cut): (Fidelity, Option<Cut>),
        machine: &MachineSpec,
        baseline: Option<&MachineSpec>,
    ) -> Self {
        let nameless = |machine: &MachineSpec| MachineSpec { name: String::new(), ..machine.clone() };
        let all = json::line(&(stream.to_string(), fidelity, cut, nameless(machine), baseline.map(nameless)));
        Self(xxh3_128(all.expect("plain data, which JSON can hold").as_bytes()))
    }

    /// The file of the point in a folder.
    pub(super) fn file(self, folder: &Path) -> PathBuf {
        folder.join(format!("{self}.json"))
    }
}

impl fmt::Display for Key {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:032x}", self.0)
    }
}

impl From<Key> for String {
    fn from(key: Key) -> Self {
        key.to_string()
    }
}

impl TryFrom<String> for Key {
    type Error = std::num::ParseIntError;

    fn try_from(text: String) -> Result<Self, Self::Error> {
        u128::from_str_radix(&text, 16).map(Self)
    }
}

/// The measurements of a replay, and the tracer's counts in the measured frames of its stream.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(in super::super) struct Measured {
    pub(in super::super) stats: MachineStats,
    pub(in super::super) totals: Totals,
}

/// The content of a point's file.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Point {
    key: Key,
    /// The build of the program that made the point.
    build: String,
    /// XXH3 (128 bits) of the measurements as compact JSON.
    checksum: String,
    measured: Measured,
}

/// Why a kept point is refused.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub(super) enum Refused {
    /// Another build of the program made it.
    #[error("build {0} of the program made it")]
    OtherBuild(String),
    /// The file's content is not what the program wrote.
    #[error("{0}")]
    Damaged(String),
}

fn checksum(measured: &Measured) -> String {
    let text = json::line(measured).expect("plain data, which JSON can hold");
    format!("{:032x}", xxh3_128(text.as_bytes()))
}

/// Reads a kept point; `None` if there is none. A refused point must be made again.
pub(super) fn read(folder: &Path, key: Key) -> Result<Option<Measured>, Refused> {
    let damaged = |why: &dyn fmt::Display| Refused::Damaged(why.to_string());
    let text = match input::read_text(&key.file(folder), MAX_POINT_BYTES) {
        Ok(text) => text,
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
        Err(error) => return Err(damaged(&error)),
    };
    let point: Point = json::read(text.as_bytes()).map_err(|error| damaged(&error))?;
    if point.key != key {
        return Err(damaged(&"it is the point of another replay"));
    }
    if point.checksum != checksum(&point.measured) {
        return Err(damaged(&"its checksum does not fit its numbers"));
    }
    if point.build != BUILD {
        return Err(Refused::OtherBuild(point.build));
    }
    Ok(Some(point.measured))
}

/// Keeps a point.
pub(super) fn write(folder: &Path, key: Key, measured: Measured) -> io::Result<()> {
    let point = Point { key, build: BUILD.into(), checksum: checksum(&measured), measured };
    let text = json::pretty(&point).expect("plain data, which JSON can hold") + "\n";
    write_whole(&key.file(folder), text.as_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_that_was_changed_is_not_taken() {
        let folder = tempfile::tempdir().unwrap();
        let [key, other] = [Key(0x1234), Key(0x5678)];
        assert_eq!(read(folder.path(), key), Ok(None));
        let stats = MachineStats { cycles: crate::quantity::Cycle(1234), ..MachineStats::default() };
        let measured = Measured { stats, totals: Totals::default() };
        write(folder.path(), key, measured.clone()).unwrap();
        assert_eq!(read(folder.path(), key), Ok(Some(measured)));
        let file = key.file(folder.path());
        let text = std::fs::read_to_string(&file).unwrap();
        for (from, to, told) in [
            ("\"cycles\": 1234", "\"cycles\": 91234", "checksum"),
            (BUILD, "another", "build another of the program made it"),
            ("\"stats\"", "\"stat\"", "unknown field"),
            ("}\n}", "", "EOF"),
        ] {
            assert!(text.contains(from), "{from}");
            std::fs::write(&file, text.replacen(from, to, 1)).unwrap();
            let error = read(folder.path(), key).unwrap_err();
            assert_eq!(matches!(error, Refused::OtherBuild(_)), from == BUILD);
            assert!(error.to_string().contains(told), "{error}");
        }
        // A point under the name of another one.
        std::fs::write(other.file(folder.path()), &text).unwrap();
        assert!(read(folder.path(), other).unwrap_err().to_string().contains("another replay"));
    }
}
