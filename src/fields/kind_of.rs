//! Finds the kind of a config file by the names at its top level.

use super::root::Root;
use super::table::fields;
use crate::ron_file;

/// The kind of the file `text`, by its `#![type]` line or the names at its top level, even if the text has errors.
pub(crate) fn kind_of(text: &str) -> Option<Root> {
    let typed = |root: &Root| text.contains(&format!("#![type = \"umbrasim::{}\"]", root.type_name()));
    if let Some(root) = Root::ALL.into_iter().find(typed) {
        return Some(root);
    }
    let names = ron_file::top_names(text);
    // A scene is one of several variants; `Obj` is an older name of `Files`.
    let scenes: Vec<String> = fields(Root::Scene).into_iter().map(|field| field.path).collect();
    let is_scene = |name: &String| name == "Obj" || scenes.contains(&format!("scene.{name}"));
    if names.first().is_some_and(is_scene) {
        return Some(Root::Scene);
    }
    let score = |root: Root| {
        let known: Vec<String> = fields(root).into_iter().map(|field| field.path).collect();
        let has = |name: &String| known.iter().any(|path| path.strip_prefix(root.name()) == Some(&format!(".{name}")));
        let known = names.iter().filter(|name| has(name)).count() as i64;
        2 * known - names.len() as i64
    };
    let mut scores = Root::ALL.map(|root| (score(root), root));
    scores.sort_by_key(|(score, _)| -score);
    (scores[0].0 > scores[1].0 && scores[0].0 > 0).then_some(scores[0].1)
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    #[test]
    fn shipped_configs_are_of_the_kind_of_their_folder() {
        for (folder, kind) in [("machines", Root::Machine), ("scenes", Root::Scene), ("dram", Root::Dram)] {
            let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("configs").join(folder);
            for file in std::fs::read_dir(folder).unwrap() {
                let path = file.unwrap().path();
                assert_eq!(kind_of(&std::fs::read_to_string(&path).unwrap()), Some(kind), "{}", path.display());
            }
        }
    }

    #[test]
    fn every_shipped_experiment_and_study_tells_its_kind() {
        for folder in ["experiments", "studies"] {
            let files = Path::new(env!("CARGO_MANIFEST_DIR")).join("configs").join(folder);
            for file in std::fs::read_dir(files).unwrap() {
                let path = file.unwrap().path();
                let kind = kind_of(&std::fs::read_to_string(&path).unwrap());
                let name = path.file_stem().unwrap().to_string_lossy().into_owned();
                let by_name = match name.split('_').next().unwrap() {
                    "pareto" => Root::Pareto,
                    "identities" => Root::Identities,
                    "paper" => Root::PaperTable,
                    "sweep" | "space" => Root::Sweep,
                    _ => Root::Experiment,
                };
                // The folder of studies has experiments and sweeps.
                let is_right = if folder == "studies" { kind.is_some() } else { kind == Some(by_name) };
                assert!(is_right, "{name}: {kind:?}");
            }
        }
    }

    #[test]
    fn names_at_the_top_tell_the_kind_whatever_else_is_wrong() {
        for (text, kind) in [
            ("(name: \"a\", scene: \"b\", policis: {\"Off\": Off", Some(Root::Experiment)),
            ("( // clock_mhz: 5\n experiment: \"x\", vary: {\"l2: (\": [1]})", Some(Root::Sweep)),
            ("Obj(path: \"a.obj\")", Some(Root::Scene)),
            ("(name: \"a\")", None),
            ("#![type = \"umbrasim::Dram\"]\n(name: \"a\")", None),
            ("#![type = \"umbrasim::DramPart\"]\n(name: \"a\")", Some(Root::Dram)),
            ("hello", None),
        ] {
            assert_eq!(kind_of(text), kind, "{text}");
        }
    }
}
