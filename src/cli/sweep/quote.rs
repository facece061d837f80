//! Paths as words of a shell.

use std::path::Path;

/// The path as one word of a POSIX shell, in quotes where it needs them.
pub(super) fn shell(path: &Path) -> String {
    let text = path.display().to_string();
    let is_plain = |letter: char| letter.is_ascii_alphanumeric() || "_-./:+,=@%".contains(letter);
    if !text.is_empty() && text.chars().all(is_plain) { text } else { format!("'{}'", text.replace('\'', r"'\''")) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_word_has_quotes_where_a_shell_would_read_it_otherwise() {
        for (path, word) in
            [("a/b-c_1.ron", "a/b-c_1.ron"), ("a b", "'a b'"), ("it's", r"'it'\''s'"), ("", "''"), ("$a", "'$a'")]
        {
            assert_eq!(shell(Path::new(path)), word);
        }
    }
}
