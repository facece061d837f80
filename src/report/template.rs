//! How pages are made of templates: all share a layout, a style sheet and the form of tables.

use minijinja::{Environment, Value, context};

use super::table::Grid;

/// What templates may extend, import or include.
const SHARED: [(&str, &str); 4] = [
    ("layout.html", include_str!("layout.html")),
    ("parts.html", include_str!("parts.html")),
    ("split.html", include_str!("split.html")),
    ("style.css", include_str!("style.css")),
];

/// The page of the template `source`, which is called `name`.
pub fn render(name: &str, source: &str, context: Value) -> Result<String, minijinja::Error> {
    let mut environment = Environment::new();
    for (name, source) in SHARED {
        environment.add_template(name, source)?;
    }
    environment.add_template(name, source)?;
    environment.get_template(name)?.render(context)
}

/// A table, as the macro `grid` takes it.
pub fn grid(grid: Grid) -> Value {
    context! { head => grid.head, names => grid.names, rows => grid.rows }
}
