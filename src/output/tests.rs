//! Tests of folders of results that are written repeatedly.

use std::fs;
use std::path::{Path, PathBuf};

use super::*;

struct Desk(tempfile::TempDir);

impl Desk {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn at(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// All files with their content, by relative path, hidden ones included.
    fn files(&self) -> Vec<(String, String)> {
        let mut found = Vec::new();
        let mut folders = vec![self.at("")];
        while let Some(folder) = folders.pop() {
            for entry in fs::read_dir(folder).unwrap() {
                let path = entry.unwrap().path();
                if path.is_dir() && !path.is_symlink() {
                    folders.push(path.clone());
                }
                let text = fs::read_to_string(&path).unwrap_or_else(|_| "folder".into());
                let text = if path.ends_with(carry::LIST) { "list".into() } else { text };
                found.push((path.strip_prefix(self.0.path()).unwrap().display().to_string(), text));
            }
        }
        found.sort();
        found
    }

    fn names(&self) -> Vec<String> {
        self.files().into_iter().map(|(name, _)| name).collect()
    }
}

/// Fills a report with the files `names`, each with the content `text`.
fn fill(folder: &Path, names: &[&str], text: &str) -> Result<(), FolderError> {
    for name in names {
        let path = folder.join(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, text).unwrap();
    }
    Ok(())
}

#[test]
fn own_files_are_replaced_and_foreign_ones_stay() {
    let desk = Desk::new();
    let rep = desk.at("out/rep");
    ResultsFolder::claim(&rep)
        .unwrap()
        .replace(|dir| fill(dir, &["index.html", "plots/a.svg", "plots/b.svg"], "1"))
        .unwrap();
    fs::write(rep.join("notes.txt"), "mine").unwrap();
    fs::write(rep.join("plots/mine.svg"), "mine").unwrap();
    fs::create_dir(rep.join("empty")).unwrap();
    ResultsFolder::claim(&rep.join("child")).unwrap().replace(|dir| fill(dir, &["index.html"], "child")).unwrap();
    #[cfg(unix)]
    std::os::unix::fs::symlink("nowhere", rep.join("link")).unwrap();
    ResultsFolder::claim(&rep).unwrap().replace(|dir| fill(dir, &["index.html", "plots/c.svg"], "2")).unwrap();
    let expected = [
        ("out", "folder"),
        ("out/rep", "folder"),
        ("out/rep/.report-files", "list"),
        ("out/rep/child", "folder"),
        ("out/rep/child/.report-files", "list"),
        ("out/rep/child/index.html", "child"),
        ("out/rep/empty", "folder"),
        ("out/rep/index.html", "2"),
        ("out/rep/link", "folder"),
        ("out/rep/notes.txt", "mine"),
        ("out/rep/plots", "folder"),
        ("out/rep/plots/c.svg", "2"),
        ("out/rep/plots/mine.svg", "mine"),
    ];
    let expected: Vec<_> = expected.iter().filter(|(name, _)| cfg!(unix) || !name.ends_with("link")).collect();
    let found = desk.files();
    assert_eq!(
        found.iter().map(|(name, text)| (name.as_str(), text.as_str())).collect::<Vec<_>>(),
        expected.into_iter().copied().collect::<Vec<_>>()
    );
}

#[cfg(unix)]
#[test]
fn a_link_to_a_folder_is_followed() {
    let desk = Desk::new();
    fs::create_dir(desk.at("disk")).unwrap();
    std::os::unix::fs::symlink("disk", desk.at("link")).unwrap();
    for text in ["1", "2"] {
        ResultsFolder::claim(&desk.at("link")).unwrap().replace(|dir| fill(dir, &["index.html"], text)).unwrap();
        assert!(desk.at("link").is_symlink());
        assert_eq!(fs::read_to_string(desk.at("disk/index.html")).unwrap(), text);
    }
}

#[test]
fn a_report_that_fails_leaves_everything_as_it_was() {
    let desk = Desk::new();
    let claimed = ResultsFolder::claim(&desk.at("new/deep/rep")).unwrap();
    assert_eq!(desk.names(), ["new", "new/deep", "new/deep/.umbrasim-rep.lock"]);
    let failed = FolderError::Foreign { path: "x".into() };
    claimed.replace(|_| Err(failed)).unwrap_err();
    drop(claimed);
    assert!(desk.names().is_empty(), "{:?}", desk.names());
}

#[test]
fn a_place_is_one_writers_at_a_time() {
    let desk = Desk::new();
    let claimed = ResultsFolder::claim(&desk.at("rep")).unwrap();
    let error = ResultsFolder::claim(&desk.at("rep")).unwrap_err().to_string();
    assert!(error.contains("rep is being written by process "), "{error}");
    drop(claimed);
    ResultsFolder::claim(&desk.at("rep")).unwrap();
}

#[test]
fn what_is_no_report_is_refused() {
    let desk = Desk::new();
    fs::create_dir(desk.at("notes")).unwrap();
    ResultsFolder::claim(&desk.at("notes")).unwrap();
    fs::write(desk.at("notes/todo"), "x").unwrap();
    fs::write(desk.at("file"), "x").unwrap();
    for place in ["notes", "file", "file/rep"] {
        ResultsFolder::claim(&desk.at(place)).unwrap_err();
    }
    assert_eq!(desk.names(), ["file", "notes", "notes/todo"]);
    // A report without a list.
    fs::write(desk.at("notes/summary.json"), r#"{"schema": 1, "policies": {}}"#).unwrap();
    ResultsFolder::claim(&desk.at("notes")).unwrap().replace(|dir| fill(dir, &["summary.json"], "2")).unwrap();
    assert_eq!(desk.names(), ["file", "notes", "notes/.report-files", "notes/summary.json", "notes/todo"]);
}

/// A process can die after it makes a folder and before it writes the list.
#[test]
fn a_folder_that_a_dead_process_only_began_is_taken() {
    let desk = Desk::new();
    fs::create_dir(desk.at("rep")).unwrap();
    fs::write(desk.at("rep/.umbrasim-a.part"), "x").unwrap();
    ResultsFolder::claim(&desk.at("rep")).unwrap().make().unwrap();
    assert_eq!(desk.names(), ["rep", "rep/.report-files"]);
    assert_eq!(fs::read_to_string(desk.at("rep/.report-files")).unwrap().lines().count(), 1, "it names no other file");
}

#[test]
fn a_foreign_file_in_the_way_of_a_new_one_stays_and_the_report_is_kept() {
    let desk = Desk::new();
    let rep = desk.at("rep");
    ResultsFolder::claim(&rep).unwrap().replace(|dir| fill(dir, &["index.html"], "1")).unwrap();
    fs::write(rep.join("frames.csv"), "mine").unwrap();
    let again = ResultsFolder::claim(&rep).unwrap().replace(|dir| fill(dir, &["index.html", "frames.csv"], "2"));
    let error: FolderError = again.unwrap_err();
    assert!(error.to_string().contains("frames.csv is not of the earlier report"), "{error}");
    assert!(error.to_string().contains("the new report is in"), "{error}");
    let found: Vec<_> = desk.files().into_iter().filter(|(_, text)| text != "folder" && text != "list").collect();
    let expected =
        [("rep/frames.csv", "mine"), ("rep/index.html", "1"), ("rep-1/frames.csv", "2"), ("rep-1/index.html", "2")];
    let mut expected: Vec<_> = expected.map(|(name, text)| (name.to_owned(), text.to_owned())).into();
    expected.sort();
    assert_eq!(found, expected);
}

#[test]
fn kept_results_come_one_by_one() {
    let desk = Desk::new();
    let claimed = ResultsFolder::claim(&desk.at("s")).unwrap();
    claimed.make().unwrap();
    fs::create_dir(desk.at("s/points")).unwrap();
    fs::write(desk.at("s/points/a.json"), "a").unwrap();
    // As after a kill: the next process recognises the folder.
    drop(claimed);
    ResultsFolder::claim(&desk.at("s")).unwrap().replace(|dir| fill(dir, &["index.html"], "1")).unwrap();
    assert_eq!(desk.names(), ["s", "s/.report-files", "s/index.html", "s/points", "s/points/a.json"]);
}
