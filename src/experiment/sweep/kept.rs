//! Keeps results that take long to compute, such as estimates, beside the points. Each has a file named by a hash of
//! its inputs, with a checksum.

use std::path::Path;
use std::{fmt, io};

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use xxhash_rust::xxh3::xxh3_128;

use super::error::SweepError;
use super::streams::BUILD;
use crate::console;
use crate::input;
use crate::json;
use crate::output::write_whole;

/// The largest size of such a file, in bytes.
const MAX_BYTES: u64 = 1 << 24;

/// The content of a file.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Kept<T> {
    /// A hash of the inputs, and the build of the program.
    of: String,
    /// XXH3 (128 bits) of the result as compact JSON.
    checksum: String,
    found: T,
}

/// Reads the result that `folder` keeps for `inputs`, or computes and keeps it. `what` names the kind of result,
/// `is_whole` says whether one has all parts.
///
/// # Errors
/// The result cannot be computed or kept.
pub(in super::super) fn kept<T: Serialize + DeserializeOwned>(
    folder: &Path,
    what: &str,
    inputs: &str,
    is_whole: impl Fn(&T) -> bool,
    find: impl FnOnce() -> Result<T, SweepError>,
) -> Result<T, SweepError> {
    let of = format!("{:032x} {BUILD}", xxh3_128(inputs.as_bytes()));
    let path = folder.join(format!("{:032x}.{what}.json", xxh3_128(of.as_bytes())));
    let damaged = |why: &dyn fmt::Display| {
        console::tell(format_args!("{}: it is damaged, and is made again: {why}", path.display()))
    };
    match input::read_text(&path, MAX_BYTES) {
        Ok(text) => match json::read::<Kept<T>>(text.as_bytes()) {
            Ok(kept) if kept.of != of || kept.checksum != checksum(&kept.found) => {
                damaged(&"its checksum does not fit its numbers")
            }
            Ok(kept) if is_whole(&kept.found) => return Ok(kept.found),
            Ok(_) => damaged(&"parts are missing"),
            Err(error) => damaged(&error),
        },
        Err(error) if error.kind() == io::ErrorKind::NotFound => {}
        Err(error) => damaged(&error),
    }
    let found = find()?;
    let kept = Kept { of, checksum: checksum(&found), found };
    let text = json::pretty(&kept).expect("plain data, which JSON can hold");
    write_whole(&path, text.as_bytes()).map_err(|source| SweepError::File { path, source })?;
    Ok(kept.found)
}

fn checksum(found: &impl Serialize) -> String {
    let text = json::line(found).expect("plain data, which JSON can hold");
    format!("{:032x}", xxh3_128(text.as_bytes()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_kept_is_not_found_again_unless_it_is_damaged() {
        let folder = tempfile::tempdir().unwrap();
        let found = |inputs: &str, value: u32| {
            let is_whole = |found: &Vec<u32>| found.len() == 1;
            kept(folder.path(), "numbers", inputs, is_whole, || Ok(vec![value])).unwrap()
        };
        assert_eq!([found("a", 1), found("a", 2), found("b", 3)], [[1], [1], [3]]);
        let file = std::fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().path());
        let file = file.filter(|file| std::fs::read_to_string(file).unwrap().contains("    1\n")).last().unwrap();
        let text = std::fs::read_to_string(&file).unwrap();
        std::fs::write(&file, text.replace("    1\n", "    7\n")).unwrap();
        assert_eq!([found("a", 4), found("a", 5)], [[4], [4]]);
        // Its checksum is right.
        kept(folder.path(), "numbers", "c", |_| true, || Ok(vec![6, 6])).unwrap();
        assert_eq!([found("c", 7), found("c", 8)], [[7], [7]]);
    }
}
