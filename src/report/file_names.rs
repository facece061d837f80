//! Names of policies and machines as parts of file names.

use std::collections::BTreeSet;

/// The longest part of a file's name that a name gives, in bytes: file systems allow 255 for the whole.
const MAX_LENGTH: usize = 64;

/// A name, and what stands for it in file names.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct FileNamed<'a> {
    /// The name.
    pub(crate) name: &'a str,
    /// The part of file names: ASCII letters, digits, `-` and `_`.
    pub(crate) file: String,
}

/// Gives each name a file name of its own: what is no letter, digit or `-` becomes `_`, and one that another name has
/// already, in small or capital letters, gets a number.
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
