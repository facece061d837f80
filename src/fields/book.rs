//! Writes the book's page of all fields.

use std::fmt::Write as _;

use super::root::Root;
use super::table::{Field, fields};

/// The longest line of the page.
const WIDTH: usize = 118;

const HEAD: &str = "\
# All fields of the config files

This page is made from the source by `umbrasim describe --book`; a test holds that it is up to date. `umbrasim describe
PATH` shows a part of it on the terminal. A size is a number of bytes, or text with a unit: kB, MB and GB are powers of
1000, KiB, MiB and GiB of 1024. *Source* says where defaults come from.
";

/// The page, in Markdown.
pub(crate) fn page() -> String {
    let mut page = HEAD.to_owned();
    for root in Root::ALL {
        let all = fields(root);
        let _ = write!(page, "\n## {}\n", root.name());
        for (at, group) in all.iter().enumerate().filter(|(_, field)| field.has_fields) {
            if at > 0 {
                let _ = write!(page, "\n### {}\n", group.path);
            }
            let source = group.source.as_ref().map(|source| format!(" *Source*: {source}")).unwrap_or_default();
            let _ = write!(page, "\n{}\n\n", wrapped(&format!("{}{source}", group.meaning), ""));
            let inside = format!("{}.", group.path);
            let of = |field: &&Field| field.path.strip_prefix(&inside).is_some_and(|name| !name.contains('.'));
            for (name, meaning) in &group.choices {
                page += &wrapped(&format!("`{name}`: {meaning}"), "- ");
                page.push('\n');
            }
            for field in
                all.iter().filter(of).filter(|field| !group.choices.iter().any(|it| it.0.starts_with(field.name())))
            {
                page += &wrapped(&format!("`{}`: {} *{}*", field.name(), field.meaning, field.facts()), "- ");
                page.push('\n');
                for (name, meaning) in field.choices.iter().filter(|_| !field.has_fields) {
                    page += &wrapped(&format!("`{name}`: {meaning}"), "  - ");
                    page.push('\n');
                }
            }
        }
    }
    page
}

/// Wraps `text` at [`WIDTH`], with `bullet` before the first line.
fn wrapped(text: &str, bullet: &str) -> String {
    let mut lines = vec![bullet.to_owned()];
    for word in text.split_whitespace() {
        let line = lines.last_mut().expect("there is a line");
        let is_first = line.len() <= bullet.len();
        if !is_first && line.len() + 1 + word.len() > WIDTH {
            lines.push(format!("{}{word}", " ".repeat(bullet.len())));
        } else {
            if !is_first {
                line.push(' ');
            }
            line.push_str(word);
        }
    }
    lines.join("\n")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_books_page_of_fields_is_up_to_date() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/guide/fields.md");
        if std::env::var_os("UMBRASIM_BLESS").is_some() {
            std::fs::write(path, page()).unwrap();
        }
        let there = std::fs::read_to_string(path).unwrap_or_default();
        assert!(there == page(), "docs/guide/fields.md is out of date: run this test with UMBRASIM_BLESS=1");
    }
}
