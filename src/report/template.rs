//! Renders pages from templates, which share a layout, a style sheet and the form of tables.

use minijinja::{Environment, HtmlEscape, Value, context};

use super::draw::Drawing;
use super::draw::palette::{Color, css};
use super::grid::Grid;

/// Files that templates may extend, import or include.
const SHARED: [(&str, &str); 5] = [
    ("layout.html", include_str!("layout.html")),
    ("parts.html", include_str!("parts.html")),
    ("script.js", include_str!("script.js")),
    ("split.html", include_str!("split.html")),
    ("style.css", include_str!("style.css")),
];

/// Renders the template `source` under the name `name`.
pub(super) fn render(name: &str, source: &str, context: Value) -> Result<String, minijinja::Error> {
    let mut environment = Environment::new();
    environment.add_filter("code", code);
    environment.add_filter("prose", prose);
    for (name, source) in SHARED {
        environment.add_template(name, source)?;
    }
    environment.add_template(name, source)?;
    environment.get_template(name)?.render(context)
}

/// Converts names between backticks, as in messages, to HTML code elements.
fn code(text: &str) -> Value {
    let escaped = HtmlEscape(text).to_string();
    let part = |(at, part): (usize, &str)| if at % 2 == 0 { part.into() } else { format!("<code>{part}</code>") };
    Value::from_safe_string(escaped.split('`').enumerate().map(part).collect())
}

/// Text of a paragraph: a no-break space keeps a percent sign with its number.
fn prose(text: &str) -> String {
    text.replace(" %", "\u{a0}%")
}

/// The drawings of `section`, as the macro `figures` takes them.
pub(super) fn plots<S: PartialEq>(drawings: &[Drawing<S>], section: &S) -> Vec<Value> {
    let there = drawings.iter().filter(|drawing| drawing.section == *section);
    let value = |it: &Drawing<S>| {
        context! {
            name => it.name.as_str(), title => it.title.as_str(), about => it.about.as_str(),
            key => key(&it.key), data => grid(it.data.clone()),
            wide => it.wide.as_str(), narrow => it.narrow.as_str(),
        }
    };
    there.map(value).collect()
}

/// The meaning of colours, as the macro `key` takes it.
pub(super) fn key(key: &[(String, Color)]) -> Vec<Value> {
    key.iter().map(|(name, color)| context! { name, color => css(*color) }).collect()
}

/// A table, as the macro `grid` takes it.
pub(super) fn grid(grid: Grid) -> Value {
    defined(grid, &[])
}

/// A table with the meanings of its columns, where `meanings` has them.
pub(super) fn defined(grid: Grid, meanings: &[(&str, &str)]) -> Value {
    let meaning = |name: &String| {
        meanings.iter().find(|(of, _)| of == name).map_or_else(String::new, |(_, meaning)| (*meaning).into())
    };
    let about: Vec<String> = grid.head.iter().map(meaning).collect();
    context! { head => grid.head, names => grid.names, rows => grid.rows, about }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_code_and_text_is_escaped() {
        let page = render("t", "{{ text|code }}", context! { text => "room on `a<b`: 2 > `c`" }).unwrap();
        assert_eq!(page, "room on <code>a&lt;b</code>: 2 &gt; <code>c</code>");
    }

    #[test]
    fn a_percent_sign_stays_with_its_number() {
        let page = render("t.html", "{{ text|prose }}", context! { text => "busy in 66.7 % of <all>" }).unwrap();
        assert_eq!(page, "busy in 66.7\u{a0}% of &lt;all&gt;");
    }
}
