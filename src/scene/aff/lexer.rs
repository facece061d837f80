//! Words and numbers of an AFF file, with the line they are on.

use std::path::Path;

use glam::{DVec2, DVec3};

use crate::scene::error::SceneError;
use crate::scene::limits::{COORDINATE, Range};

/// Splits a file into words. White space separates words; `{` and `}` are words of their own. A word that begins with
/// `#` or `%` begins a comment, which ends with its line. Lines end in LF, CR LF or a lone CR. Bytes are not decoded:
/// some BART files have Latin-1 comments.
#[derive(Clone, Debug)]
pub(super) struct Lexer<'a> {
    path: &'a Path,
    bytes: &'a [u8],
    /// The line of the next byte.
    line: usize,
    /// The line of the word that was read last.
    word_line: usize,
}

impl<'a> Lexer<'a> {
    /// A lexer at the start of `bytes`, after a byte order mark of UTF-8; `path` is for error messages only.
    pub(super) fn new(path: &'a Path, bytes: &'a [u8]) -> Self {
        let bytes = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes);
        Self { path, bytes, line: 1, word_line: 1 }
    }

    /// The file.
    pub(super) fn path(&self) -> &'a Path {
        self.path
    }

    /// The line of the word that was read last.
    pub(super) fn word_line(&self) -> usize {
        self.word_line
    }

    /// An error at the word that was read last.
    pub(super) fn error(&self, what: impl Into<String>) -> SceneError {
        SceneError::Syntax { path: self.path.into(), line: self.word_line, what: what.into() }
    }

    /// The next word, or `None` at the end.
    pub(super) fn next_word(&mut self) -> Option<&'a [u8]> {
        self.skip();
        self.word_line = self.line;
        let length = match self.bytes {
            [] => return None,
            [b'{' | b'}', ..] => 1,
            bytes => bytes.iter().position(|&byte| is_end(byte)).unwrap_or(bytes.len()),
        };
        let (word, rest) = self.bytes.split_at(length);
        self.bytes = rest;
        Some(word)
    }

    /// Skips white space and comments.
    fn skip(&mut self) {
        let mut comment = false;
        while let [byte, rest @ ..] = self.bytes {
            match byte {
                b'\r' | b'\n' => {
                    // CR LF is one end: its CR does not count.
                    self.line += usize::from(*byte == b'\n' || rest.first() != Some(&b'\n'));
                    comment = false;
                }
                b'#' | b'%' => comment = true,
                byte if comment || byte.is_ascii_whitespace() => {}
                _ => break,
            }
            self.bytes = rest;
        }
    }

    /// Whether the next word begins like a number.
    pub(super) fn number_follows(&mut self) -> bool {
        self.skip();
        matches!(self.bytes.first(), Some(b'0'..=b'9' | b'+' | b'-' | b'.'))
    }

    /// The next word; `what` says what it should be.
    pub(super) fn word(&mut self, what: &str) -> Result<&'a [u8], SceneError> {
        match self.next_word() {
            Some(word) => Ok(word),
            None => Err(self.error(format!("the file ends where {what} should be"))),
        }
    }

    /// A name: any word but a brace.
    pub(super) fn name(&mut self, what: &str) -> Result<String, SceneError> {
        match self.word(what)? {
            word @ (b"{" | b"}") => Err(self.found(word, what)),
            word => Ok(String::from_utf8_lossy(word).into_owned()),
        }
    }

    /// Skips the word `expected`.
    pub(super) fn expect(&mut self, expected: &str) -> Result<(), SceneError> {
        let what = format!("`{expected}`");
        match self.word(&what)? {
            word if word == expected.as_bytes() => Ok(()),
            word => Err(self.found(word, &what)),
        }
    }

    /// A number within [`COORDINATE`].
    pub(super) fn number(&mut self, what: &str) -> Result<f64, SceneError> {
        let word = self.word(what)?;
        match std::str::from_utf8(word).ok().and_then(|text| text.parse::<f64>().ok()) {
            Some(number) if COORDINATE.check("", number).is_ok() => Ok(number),
            _ => Err(self.found(word, &format!("{what}, a number {COORDINATE},"))),
        }
    }

    /// A number within `range`.
    pub(super) fn number_within(&mut self, what: &str, range: Range) -> Result<f64, SceneError> {
        let number = self.number(what)?;
        range.check(what, number).map_err(|what| self.error(what))
    }

    /// Three numbers within `range`.
    pub(super) fn vector_within(&mut self, what: &str, range: Range) -> Result<DVec3, SceneError> {
        let vector = self.vector(what)?;
        range.check_vector(what, vector).map_err(|what| self.error(what))
    }

    /// A whole number from `least` to `most`.
    pub(super) fn whole(&mut self, what: &str, least: i64, most: i64) -> Result<i64, SceneError> {
        let word = self.word(what)?;
        match std::str::from_utf8(word).ok().and_then(|text| text.parse().ok()) {
            Some(number) if (least..=most).contains(&number) => Ok(number),
            _ if (least, most) == (i64::MIN, i64::MAX) => Err(self.found(word, &format!("{what}, a whole number,"))),
            _ => Err(self.found(word, &format!("{what}, a whole number from {least} to {most},"))),
        }
    }

    /// The number of `what` that follow. Nothing is allocated by it: a file can announce more than it has.
    pub(super) fn count(&mut self, what: &str, least: i64) -> Result<usize, SceneError> {
        self.whole(&format!("the number of {what}"), least, i64::from(u32::MAX)).map(|count| count as usize)
    }

    /// Two numbers.
    pub(super) fn pair(&mut self, what: &str) -> Result<DVec2, SceneError> {
        Ok(DVec2::new(self.number(what)?, self.number(what)?))
    }

    /// Three numbers.
    pub(super) fn vector(&mut self, what: &str) -> Result<DVec3, SceneError> {
        Ok(DVec3::new(self.number(what)?, self.number(what)?, self.number(what)?))
    }

    /// An error about the word that was read last.
    pub(super) fn found(&self, word: &[u8], allowed: &str) -> SceneError {
        // A binary file may be one long word.
        let shown = String::from_utf8_lossy(&word[..word.len().min(40)]);
        self.error(format!("found `{}`: {allowed} should be here", shown.escape_debug()))
    }
}

fn is_end(byte: u8) -> bool {
    byte.is_ascii_whitespace() || matches!(byte, b'{' | b'}')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn splits_words_braces_and_comments() {
        let mut lexer = Lexer::new(Path::new("a.aff"), b"xs 1 2{l}#c {\r\n% \xF6\nb\x0C-1 %x\n1%x #");
        let words: Vec<_> = std::iter::from_fn(|| lexer.next_word()).map(String::from_utf8_lossy).collect();
        assert_eq!(words, ["xs", "1", "2", "{", "l", "}", "b", "-1", "1%x"]);
    }

    #[test]
    fn errors_name_file_and_line() {
        let error = |text: &str, read: fn(&mut Lexer<'_>) -> Result<(), SceneError>| {
            read(&mut Lexer::new(Path::new("a.aff"), text.as_bytes())).unwrap_err().to_string()
        };
        let number = |lexer: &mut Lexer<'_>| lexer.number("a radius").map(|_| ());
        assert_eq!(
            error("\n# x\r\n 1e31", number),
            "a.aff:3: found `1e31`: a radius, a number from -1e9 to 1e9, should be here"
        );
        for bad in ["nan", "inf", "-inf", "1x", "{", "0x10", "1e999", "-1.#IND", "1.#INF", "1#2"] {
            assert!(error(bad, number).contains(&format!("found `{bad}`")));
        }
        assert_eq!(error("\r\r\n\r", number), "a.aff:4: the file ends where a radius should be");
        assert_eq!(error("\n\n", number), "a.aff:3: the file ends where a radius should be");
        let count = |lexer: &mut Lexer<'_>| lexer.count("corners", 3).map(|_| ());
        for bad in ["2", "-1", "4294967296", "99999999999999999999", "3.0"] {
            assert!(error(bad, count).contains("the number of corners, a whole number from 3 to 4294967295,"));
        }
        assert!(error("x", |lexer| lexer.expect("from")).contains("found `x`: `from` should be here"));
        assert!(error("}", |lexer| lexer.name("a file").map(|_| ())).contains("found `}`: a file should be here"));
    }

    #[test]
    fn reads_numbers() {
        let mut lexer = Lexer::new(Path::new("a.aff"), b" -.5 4. +1 2E-3 -1e9 ");
        let vector = lexer.vector("a point").unwrap();
        assert_eq!(vector, DVec3::new(-0.5, 4.0, 1.0));
        assert!(lexer.number_follows());
        assert_eq!(lexer.pair("a pair").unwrap(), DVec2::new(2e-3, -1e9));
        assert!(!lexer.number_follows());
    }
}
