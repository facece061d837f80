//! Reads RON files; errors show the place and the cause.

use std::cell::RefCell;
use std::fmt;
use std::marker::PhantomData;
use std::path::{Path, PathBuf};

use ron::error::SpannedError;
use ron::extensions::Extensions;
use serde::Deserializer;
use serde::de::value::MapAccessDeserializer;
use serde::de::{DeserializeOwned, Error, MapAccess, Visitor};

pub(crate) use crate::shipped::Kind;
use crate::{alike, input, shipped};

/// Why a config cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum ConfigError {
    /// The file cannot be read.
    #[error("cannot read {}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The file has an error at one place.
    #[error("{0}")]
    At(Box<Place>),
    /// The file's parts don't fit together.
    #[error("{}: {what}", path.display())]
    Content {
        /// The file.
        path: PathBuf,
        /// What does not fit, and what would.
        what: String,
    },
}

/// A place in a config, and what is wrong there.
#[derive(Debug)]
pub struct Place {
    path: PathBuf,
    line: usize,
    column: usize,
    source_line: String,
    what: String,
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { path, line, column, source_line, what } = self;
        let number = line.to_string();
        let margin = " ".repeat(number.len());
        writeln!(f, "{}:{line}:{column}: {what}", path.display())?;
        writeln!(f, " {margin} |")?;
        writeln!(f, " {number} | {source_line}")?;
        write!(f, " {margin} | {}^", " ".repeat(column.saturating_sub(1)))
    }
}

/// Reads `path` as RON. `Some` may be left out around optional values, and the inner brackets of `Variant((field: 1))`.
///
/// # Errors
/// As [`parse`], or the file cannot be read.
pub fn read<T: DeserializeOwned>(path: &Path) -> Result<T, ConfigError> {
    parse(&text(path)?, path)
}

/// The text of the config at `path`.
///
/// # Errors
/// The file cannot be read.
pub(crate) fn text(path: &Path) -> Result<String, ConfigError> {
    let text = match shipped::text(path) {
        Some(text) => text.map(str::to_owned),
        None => input::read_text(path, input::MAX_CONFIG_BYTES),
    };
    text.map_err(|source| ConfigError::Read { path: path.into(), source })
}

/// The names of the outermost fields, or the name in front of the outermost brackets.
pub(crate) fn top_names(text: &str) -> Vec<String> {
    let mut names = Vec::new();
    let (mut depth, mut in_text, mut word) = (0usize, false, String::new());
    for line in text.lines().filter(|line| !line.trim_start().starts_with("#!")) {
        let mut letters = line.chars().peekable();
        while let Some(letter) = letters.next() {
            if in_text {
                if letter == '\\' {
                    letters.next();
                }
                in_text = letter != '"';
                continue;
            }
            match letter {
                '/' if letters.peek() == Some(&'/') => break,
                '"' => in_text = true,
                '(' | '[' | '{' => {
                    if depth == 0 && !word.is_empty() {
                        names.push(std::mem::take(&mut word));
                    }
                    depth += 1;
                }
                ')' | ']' | '}' => depth = depth.saturating_sub(1),
                ':' if depth == 1 && !word.is_empty() => names.push(std::mem::take(&mut word)),
                letter if letter.is_alphanumeric() || letter == '_' => {
                    word.push(letter);
                    continue;
                }
                letter if letter.is_whitespace() => continue,
                _ => {}
            }
            word.clear();
        }
    }
    names
}

/// Reads `text`, which came from `path`, as RON.
///
/// # Errors
/// The text is not RON, or does not fit `T`; the error points at the line.
pub fn parse<T: DeserializeOwned>(text: &str, path: &Path) -> Result<T, ConfigError> {
    let options = ron::Options::default().with_default_extension(extensions());
    let parsed = beside(path, || options.from_str(text));
    parsed.map_err(|error| ConfigError::At(Box::new(place(text, path, &error))))
}

thread_local! {
    /// The folder of the file that is being read: the deserializer of a field that names a file has no other way to
    /// know it.
    static FOLDER: RefCell<PathBuf> = const { RefCell::new(PathBuf::new()) };
}

/// Calls `read` with names of files taken relative to the folder of `path`.
pub(crate) fn beside<T>(path: &Path, read: impl FnOnce() -> T) -> T {
    let outer = FOLDER.replace(path.parent().unwrap_or(Path::new("")).into());
    let found = read();
    FOLDER.replace(outer);
    found
}

/// Deserializes a struct from its values, or from the name of a file that holds them: a path relative to the naming
/// file, or a shipped config of that kind. It is serialized as its values.
pub(crate) fn values_or_file<'de, D: Deserializer<'de>, T: DeserializeOwned>(
    from: D,
    kind: Kind,
) -> Result<T, D::Error> {
    struct ValuesOrFile<T>(Kind, PhantomData<T>);

    impl<'de, T: DeserializeOwned> Visitor<'de> for ValuesOrFile<T> {
        type Value = T;

        fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
            f.write_str("the name of a file, or its values in brackets")
        }

        fn visit_str<E: Error>(self, file: &str) -> Result<T, E> {
            let file = FOLDER.with_borrow(|folder| shipped::named(self.0, folder, Path::new(file)));
            read(&file).map_err(|error| match error {
                ConfigError::Read { source, .. } => {
                    E::custom(format!("cannot read {}: {source}{}", file.display(), proposal(&file)))
                }
                error => E::custom(error),
            })
        }

        fn visit_map<A: MapAccess<'de>>(self, values: A) -> Result<T, A::Error> {
            T::deserialize(MapAccessDeserializer::new(values))
        }
    }

    from.deserialize_any(ValuesOrFile(kind, PhantomData))
}

/// RON extensions that all files may use: no `Some` around optional values, no second brackets in `Variant((a: 1))`.
pub fn extensions() -> Extensions {
    Extensions::IMPLICIT_SOME | Extensions::UNWRAP_VARIANT_NEWTYPES
}

fn place(text: &str, path: &Path, error: &SpannedError) -> Place {
    let found = (error.span.start.line, error.span.start.col);
    let what = if error.code == ron::Error::ExpectedComma && letter_at(text, found) == Some('.') {
        // RON reads the whole number before the fraction, and then reports a missing comma.
        "a whole number is allowed here, without a fraction".to_owned()
    } else {
        told(&error.code)
    };
    let (line, column) = named_field(&what, text).unwrap_or(found);
    Place {
        path: path.into(),
        line,
        column,
        source_line: text.lines().nth(line.saturating_sub(1)).unwrap_or_default().replace('\t', " "),
        what,
    }
}

/// The message of an error; for an unknown name, with a similar name and the allowed ones.
fn told(error: &ron::Error) -> String {
    let unknown = |what: &str, found: &str, allowed: &[&str]| {
        let alike = alike::closest(found, allowed);
        let alike = alike.map(|alike| format!("did you mean `{alike}`? Allowed: ")).unwrap_or("allowed: ".into());
        let allowed = allowed.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ");
        format!("unknown {what} `{found}`; {alike}{allowed}")
    };
    match error {
        ron::Error::NoSuchStructField { expected, found, .. } => unknown("field", found, expected),
        ron::Error::NoSuchEnumVariant { expected, found, .. } => unknown("name", found, expected),
        ron::Error::ExpectedString => "a text in quotes is needed here".into(),
        ron::Error::ExpectedInteger => "a whole number is needed here".into(),
        ron::Error::IntegerOutOfBounds => "this number is too large or below zero".into(),
        ron::Error::ExpectedNamedStructLike(_) | ron::Error::ExpectedStructLike => {
            "the fields of a config are needed here, in brackets".into()
        }
        error => error.to_string(),
    }
}

/// An addition to the error of a missing file that a config names. If it is a name, not a path: that no shipped config
/// has this name, and a similar name.
fn proposal(file: &Path) -> String {
    let Some(name) = file.file_name().and_then(|name| name.to_str()).filter(|name| shipped::is_name(name)) else {
        return String::new();
    };
    let names: Vec<&str> = Kind::ALL.into_iter().flat_map(shipped::names).collect();
    let closest = alike::closest(name, &names).map(|other| format!("; did you mean `{other}`?"));
    format!(", and no shipped config has this name{}", closest.unwrap_or_default())
}

/// Changes the error of a file that cannot be read: it then shows where the config at `config` names that file. Other
/// errors stay as they are.
pub fn named_in(config: &Path, error: ConfigError) -> ConfigError {
    let ConfigError::Read { path, source } = error else { return error };
    let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let text = text(config).unwrap_or_default();
    // The program contains configs, but no scenes' files.
    let hint = if shipped::text(config).is_some() {
        let name = config.file_stem().unwrap_or_default().to_string_lossy();
        format!(
            "\nThe program has this config in it, but not the files that it names. Write a copy with \
             `umbrasim new scene FILE.ron --from {name}`, and set its paths"
        )
    } else {
        String::new()
    };
    let found = text.lines().enumerate().find_map(|(at, line)| Some((at, line, line.find(&name)?)));
    match found {
        Some((at, line, start)) => ConfigError::At(Box::new(Place {
            path: config.into(),
            line: at + 1,
            column: line[..start].chars().count() + 1,
            source_line: line.replace('\t', " "),
            what: format!("cannot read {}: {source}{}{hint}", path.display(), proposal(&path)),
        })),
        None => ConfigError::Read { path, source },
    }
}

/// The letter at a line and column, both counted from 1.
fn letter_at(text: &str, (line, column): (usize, usize)) -> Option<char> {
    text.lines().nth(line.checked_sub(1)?)?.chars().nth(column.checked_sub(1)?)
}

/// Line and column of the field that an error begins with, such as `` `timing.rc` is 100 ``. RON reports an error
/// about several values only at their end.
fn named_field(what: &str, text: &str) -> Option<(usize, usize)> {
    let (path, _) = what.strip_prefix('`')?.split_once('`')?;
    let lines = text.lines().map(|line| line.split("//").next().unwrap_or_default());
    let mut names = path.split('.').peekable();
    for (number, line) in lines.enumerate() {
        let mut from = 0;
        while let Some(&name) = names.peek()
            && let Some(at) = field_at(&line[from..], name)
        {
            names.next();
            if names.peek().is_none() {
                return Some((number + 1, line[..from + at].chars().count() + 1));
            }
            from += at + name.len();
        }
    }
    None
}

/// The position of a field with this name in a line.
fn field_at(line: &str, name: &str) -> Option<usize> {
    let is_field = |&(at, _): &(usize, &str)| {
        let inside = |letter: char| letter.is_alphanumeric() || letter == '_';
        !line[..at].ends_with(inside) && line[at + name.len()..].trim_start().starts_with(':')
    };
    line.match_indices(name).find(is_field).map(|(at, _)| at)
}

#[cfg(test)]
mod tests {
    use serde::Deserialize;

    use super::*;
    use crate::ranged::Within;

    #[derive(Debug, Deserialize)]
    #[serde(deny_unknown_fields)]
    #[allow(dead_code, reason = "only its errors are looked at")]
    struct Cache {
        ways: Within<1, 64>,
        name: Option<String>,
    }

    fn message(text: &str) -> String {
        parse::<Cache>(text, Path::new("x.ron")).unwrap_err().to_string()
    }

    #[test]
    fn a_typo_is_shown_with_its_line_and_what_is_allowed() {
        insta::assert_snapshot!(message("(\n    ways: 4,\n    nmae: \"L1\",\n)"), @r#"
        x.ron:3:5: unknown field `nmae`; did you mean `name`? Allowed: `ways`, `name`
           |
         3 |     nmae: "L1",
           |     ^
        "#);
    }

    #[test]
    fn a_number_out_of_range_is_shown_with_its_line_and_what_is_allowed() {
        insta::assert_snapshot!(message("(\n    ways: 65,\n)"), @r"
        x.ron:2:11: 65 is not allowed here: a whole number from 1 to 64 is
           |
         2 |     ways: 65,
           |           ^
        ");
    }

    #[test]
    fn a_fraction_where_a_whole_number_belongs_is_told() {
        assert!(message("(ways: 4.0)").starts_with("x.ron:1:9: a whole number is allowed here, without a fraction"));
        assert!(message("(ways: 4 name: None)").contains("Expected comma"));
    }

    #[test]
    fn an_error_that_names_a_field_is_shown_there() {
        let text = "// rc: 1\n(\n    rc: 3,\n    timing: (rcd: 4, rc : 5),\n)";
        assert_eq!(named_field("`timing.rc` is 5: 6 is allowed", text), Some((4, 22)));
        assert_eq!(named_field("`rc` is 3: 6 is allowed", text), Some((3, 5)));
        assert_eq!(named_field("`rp` is 3: 6 is allowed", text), None);
        assert_eq!(named_field("3 is not allowed: `rc`", text), None);
    }

    #[test]
    fn options_need_no_some() {
        let cache: Cache = parse("(ways: 4, name: \"L1\")", Path::new("x.ron")).unwrap();
        assert_eq!(cache.name.as_deref(), Some("L1"));
    }
}
