//! Names of policies and machines as parts of file names.

use std::collections::BTreeSet;

/// The longest part of a file name that comes from a name, in characters; file systems allow 255 bytes for the whole.
const MAX_LENGTH: usize = 64;

/// A name, and its form in file names.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct FileNamed<'a> {
    /// The name.
    pub(crate) name: &'a str,
    /// The form in file names: ASCII letters, digits, `-` and `_`.
    pub(crate) file: String,
}

/// Gives each name a unique file name. A character that is no letter, digit or `-` becomes `_`; a file name that is
/// already taken, upper and lower case being equal, gets a number.
pub(crate) fn file_names<'a>(names: impl IntoIterator<Item = &'a str>) -> Vec<FileNamed<'a>> {
    let mut taken = BTreeSet::new();
    let unique = |name: &'a str| {
        let safe = |sign: char| if sign.is_ascii_alphanumeric() || sign == '-' { sign } else { '_' };
        let plain: String = name.chars().map(safe).take(MAX_LENGTH).collect();
        let numbered = (2..).map(|number: u64| format!("{plain}-{number}"));
        let free = std::iter::once(plain.clone()).chain(numbered).find(|file| taken.insert(file.to_ascii_lowercase()));
        FileNamed { name, file: free.unwrap_or_default() }
    };
    names.into_iter().map(unique).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_has_a_safe_file_name_of_its_own() {
        let names = ["Off", "a/b ../c", "x y", "x_y", "x_y-2", "off", "太", "郎", &"n".repeat(300)];
        let files: Vec<String> = file_names(names).into_iter().map(|named| named.file).collect();
        let long = "n".repeat(MAX_LENGTH);
        assert_eq!(files, ["Off", "a_b____c", "x_y", "x_y-2", "x_y-2-2", "off-2", "_", "_-2", &long]);
    }
}
