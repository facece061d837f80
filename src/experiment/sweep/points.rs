//! Results of replays that a sweep keeps, each in a file named by a hash of all that it depends on, with a checksum.

use std::fmt;
use std::io;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use xxhash_rust::xxh3::xxh3_128;

use super::streams::{BUILD, Identity};
use crate::input;
use crate::machine::MachineSpec;
use crate::output::write_whole;
use crate::replay::Fidelity;
use crate::stats::MachineStats;

/// The largest file of a point, in bytes.
const MAX_POINT_BYTES: u64 = 1 << 24;

/// All that a replay's result depends on, as a hash.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(into = "String", try_from = "String")]
pub(super) struct Key(u128);

impl Key {
    /// The key of a replay of a stream. A machine's name changes no result.
    pub(super) fn new(stream: Identity, fidelity: Fidelity, machine: &MachineSpec) -> Self {
        let machine = MachineSpec { name: String::new(), ..machine.clone() };
        let all = serde_json::to_vec(&(stream.to_string(), fidelity, machine));
        Self(xxh3_128(&all.expect("plain data, which JSON can hold")))
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

/// A point as its file holds it.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Point {
    key: Key,
    /// The build of the program that made it.
    build: String,
    /// XXH3 (128 bits) of the statistics as compact JSON.
    checksum: String,
    stats: MachineStats,
}

fn checksum(stats: &MachineStats) -> String {
    let text = serde_json::to_vec(stats).expect("plain data, which JSON can hold");
    format!("{:032x}", xxh3_128(&text))
}

/// Reads a kept point; none if there is none. The error says what is wrong with it: it is to be made again.
pub(super) fn read(folder: &Path, key: Key) -> Result<Option<MachineStats>, String> {
    let text = match input::read_text(&key.file(folder), MAX_POINT_BYTES) {
        Ok(text) => text,
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
        Err(error) => return Err(error.to_string()),
    };
    let point: Point = serde_json::from_str(&text).map_err(|error| error.to_string())?;
    if point.key != key || point.build != BUILD {
        return Err("it is the point of another replay".into());
    }
    if point.checksum != checksum(&point.stats) {
        return Err("its checksum does not fit its numbers".into());
    }
    Ok(Some(point.stats))
}

/// Keeps a point.
pub(super) fn write(folder: &Path, key: Key, stats: &MachineStats) -> io::Result<()> {
    let point = Point { key, build: BUILD.into(), checksum: checksum(stats), stats: stats.clone() };
    let mut text = serde_json::to_vec_pretty(&point).expect("plain data, which JSON can hold");
    text.push(b'\n');
    write_whole(&key.file(folder), &text)
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
        write(folder.path(), key, &stats).unwrap();
        assert_eq!(read(folder.path(), key), Ok(Some(stats)));
        let file = key.file(folder.path());
        let text = std::fs::read_to_string(&file).unwrap();
        for (from, to, told) in [
            ("\"cycles\": 1234", "\"cycles\": 91234", "checksum"),
            (BUILD, "another", "another replay"),
            ("\"stats\"", "\"stat\"", "unknown field"),
            ("}\n}", "", "EOF"),
        ] {
            assert!(text.contains(from), "{from}");
            std::fs::write(&file, text.replacen(from, to, 1)).unwrap();
            let error = read(folder.path(), key).unwrap_err();
            assert!(error.contains(told), "{error}");
        }
        // A point under the name of another one.
        std::fs::write(other.file(folder.path()), &text).unwrap();
        assert!(read(folder.path(), other).unwrap_err().contains("another replay"));
    }
}
