//! The configuration as run, with deviations from defaults marked.

use minijinja::{Value, context};

/// The lines of a configuration in RON with half their indentation, one field per line. Each line tells whether its
/// path is one of `changed`.
pub(super) fn lines(config: &str, changed: &[String]) -> Vec<Value> {
    let mut path: Vec<String> = Vec::new();
    let line = |line: &str| {
        let text = line.trim();
        let (name, rest) = text.split_once(": ").unwrap_or(("", text));
        let name = name.trim_matches('"');
        let mut full = path.clone();
        full.push(name.to_owned());
        full.retain(|name| !name.is_empty());
        let full = full.join(".");
        let differs = !name.is_empty() && changed.contains(&full);
        if text.starts_with([')', ']', '}']) {
            path.pop();
        }
        if rest.ends_with(['(', '[', '{']) {
            path.push(name.to_owned());
        }
        let indentation = (line.len() - line.trim_start().len()) / 2;
        context! { text => format!("{:indentation$}{}", "", line.trim_start()), differs }
    };
    config.lines().map(line).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_found_by_their_path() {
        let config = "(\n    machines: {\n        \"small\": (\n            clock_mhz: 400,\n            l2: (\n                \
                      ways: [\n                    1,\n                ],\n                banks: 2,\n            ),\n        \
                      ),\n        \"other\": (\n            clock_mhz: 400,\n        ),\n    },\n)";
        let marked = lines(config, &["machines.small.clock_mhz".into(), "machines.small.l2.banks".into()]);
        let differs = |line: &Value| line.get_attr("differs").unwrap().is_true();
        let found: Vec<usize> = (0..).zip(&marked).filter(|(_, line)| differs(line)).map(|(index, _)| index).collect();
        assert_eq!(found, [3, 8]);
    }
}
