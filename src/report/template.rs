//! How pages are made of templates: all share a layout, a style sheet and the form of tables.

use minijinja::{Environment, HtmlEscape, Value, context};

use super::draw::Drawing;
use super::grid::Grid;

/// What templates may extend, import or include.
const SHARED: [(&str, &str); 4] = [
    ("layout.html", include_str!("layout.html")),
    ("parts.html", include_str!("parts.html")),
    ("split.html", include_str!("split.html")),
    ("style.css", include_str!("style.css")),
];

/// The page of the template `source`, which is called `name`.
pub(super) fn render(name: &str, source: &str, context: Value) -> Result<String, minijinja::Error> {
    let mut environment = Environment::new();
    environment.add_filter("code", code);
    for (name, source) in SHARED {
        environment.add_template(name, source)?;
    }
    environment.add_template(name, source)?;
    environment.get_template(name)?.render(context)
}

/// Text whose names stand between backticks, as in messages.
fn code(text: &str) -> Value {
    let escaped = HtmlEscape(text).to_string();
    let part = |(at, part): (usize, &str)| if at % 2 == 0 { part.into() } else { format!("<code>{part}</code>") };
    Value::from_safe_string(escaped.split('`').enumerate().map(part).collect())
}

/// The drawings that stand in `section`.
pub(super) fn plots<S: PartialEq>(drawings: &[Drawing<S>], section: &S) -> Vec<Value> {
    let there = drawings.iter().filter(|drawing| drawing.section == *section);
    there.map(|drawing| drawing.svg.as_str().into()).collect()
}

/// A table, as the macro `grid` takes it.
pub(super) fn grid(grid: Grid) -> Value {
    context! { head => grid.head, names => grid.names, rows => grid.rows }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_code_and_text_is_escaped() {
        let page = render("t", "{{ text|code }}", context! { text => "room on `a<b`: 2 > `c`" }).unwrap();
        assert_eq!(page, "room on <code>a&lt;b</code>: 2 &gt; <code>c</code>");
    }
}
