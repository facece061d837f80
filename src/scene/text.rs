//! Lines of the text formats OBJ and MTL: byte order mark, line ends of all systems, continued lines, comments and
//! numbers.

use std::borrow::Cow;

/// A statement's line.
#[derive(Debug)]
pub(super) struct Line<'a> {
    /// The first word.
    pub word: &'a str,
    /// What follows the first word, trimmed. A comment may be part of it: a name can hold a `#`.
    pub rest: &'a str,
}

/// Calls `each` for every statement in `bytes`, until it returns an error. Lines end in LF, CR LF or a lone CR; a `\`
/// as last byte joins a line with the next; empty lines and comment lines are skipped. A byte order mark of UTF-8 is no
/// part of the first line. Names may be in any encoding: bytes that are not UTF-8 become U+FFFD.
///
/// # Errors
/// The first error of `each`, with the number of its line.
pub(super) fn each_line(
    bytes: &[u8],
    mut each: impl FnMut(&Line<'_>) -> Result<(), String>,
) -> Result<(), (usize, String)> {
    let mut rest = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes);
    let mut next = 1;
    while !rest.is_empty() {
        let number = next;
        let mut line = Cow::Borrowed(take_line(&mut rest));
        next += 1;
        while !is_comment(&line) && line.ends_with(b"\\") && !rest.is_empty() {
            let joined = line.to_mut();
            joined.pop();
            joined.push(b' ');
            joined.extend_from_slice(take_line(&mut rest));
            next += 1;
        }
        let text = String::from_utf8_lossy(&line);
        let text = text.trim_matches(|letter: char| letter.is_ascii_whitespace());
        if text.is_empty() || text.starts_with('#') {
            continue;
        }
        let (word, rest) = text.split_once(|letter: char| letter.is_ascii_whitespace()).unwrap_or((text, ""));
        each(&Line { word, rest: rest.trim_ascii() }).map_err(|what| (number, what))?;
    }
    Ok(())
}

/// Takes the first line, without its end.
fn take_line<'a>(rest: &mut &'a [u8]) -> &'a [u8] {
    let end = rest.iter().position(|byte| matches!(byte, b'\n' | b'\r')).unwrap_or(rest.len());
    let (line, tail) = rest.split_at(end);
    *rest = tail.strip_prefix(b"\r\n").unwrap_or_else(|| tail.get(1..).unwrap_or_default());
    line
}

fn is_comment(line: &[u8]) -> bool {
    line.trim_ascii_start().starts_with(b"#")
}

/// The words of a statement. A word that begins with `#` begins a comment. A `#` inside a word is part of it: some C
/// libraries print infinity as `1.#INF`.
pub(super) fn words(text: &str) -> impl Iterator<Item = &str> {
    text.split_ascii_whitespace().take_while(|word| !word.starts_with('#'))
}

/// A name without the comment that may follow.
pub(super) fn without_comment(name: &str) -> &str {
    let end =
        name.match_indices('#').find(|&(at, _)| name[..at].ends_with(|letter: char| letter.is_ascii_whitespace()));
    end.map_or(name, |(at, _)| name[..at].trim_ascii_end())
}

/// A finite number.
pub(super) fn number(word: &str) -> Result<f32, String> {
    match word.parse::<f32>() {
        Ok(number) if number.is_finite() => Ok(number),
        _ => Err(format!("{:?} is not a finite number", shortened(word))),
    }
}

/// The first 60 letters of a word, which may be as long as its file.
pub(super) fn shortened(word: &str) -> &str {
    shortened_to(word, 60)
}

/// The first `most` letters.
pub(super) fn shortened_to(text: &str, most: usize) -> &str {
    text.char_indices().nth(most).map_or(text, |(end, _)| &text[..end])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(bytes: &[u8]) -> Vec<(String, String)> {
        let mut found = Vec::new();
        each_line(bytes, |line| {
            found.push((line.word.to_owned(), line.rest.to_owned()));
            Ok(())
        })
        .unwrap();
        found
    }

    fn line(word: &str, rest: &str) -> (String, String) {
        (word.into(), rest.into())
    }

    #[test]
    fn lines_of_all_systems_are_counted() {
        let text = b"\xEF\xBB\xBFv 1\r\n\r# c\rvt\t2 \n\n f \\\r\n3\\\n 4\\\r5\nlast x\\";
        let expected = [line("v", "1"), line("vt", "2"), line("f", "3  4 5"), line("last", "x\\")];
        assert_eq!(lines(text), expected);
        assert_eq!(lines(b"# a comment is not continued \\\nv 1"), [line("v", "1")]);
        // Errors name the first line of a statement.
        let failing = |bytes: &[u8], word: &str| {
            each_line(bytes, |line| if line.word == word { Err("no".into()) } else { Ok(()) }).unwrap_err().0
        };
        assert_eq!(["v", "vt", "f", "last"].map(|word| failing(text, word)), [1, 4, 6, 10]);
        assert_eq!(failing(b"\n\na", "a"), 3);
    }

    #[test]
    fn comments_begin_a_word() {
        assert_eq!(words("1 2#3 #4 5").collect::<Vec<_>>(), ["1", "2#3"]);
        assert_eq!(without_comment("Material #25 # old"), "Material");
        assert_eq!(without_comment("red#1"), "red#1");
        assert_eq!(without_comment("# all"), "# all");
    }

    #[test]
    fn numbers_are_whole_words_and_finite() {
        assert_eq!(number("-.5e1"), Ok(-5.0));
        for bad in ["-1.#IND", "1.#INF", "1.#QNAN", "nan", "inf", "1e39", "1,5", "0x10", "1f", "\u{0}"] {
            assert!(number(bad).unwrap_err().ends_with("is not a finite number"), "{bad}");
        }
        assert!(number(&"9".repeat(1000)).unwrap_err().len() < 100);
    }
}
