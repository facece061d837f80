//! Programs in the book print what stands below them. One whose interpreter or package is absent is skipped.
//!
//! With `UMBRASIM_UPDATE_BOOK=1` the pages get what the programs print.

use std::fs;
use std::path::Path;
use std::process::Command;

/// A program of a page, and the place of the text that it prints.
struct Example {
    language: String,
    program: String,
    output: std::ops::Range<usize>,
}

/// The blocks of code in a page, each with its language and its place.
fn blocks(page: &str) -> Vec<(String, std::ops::Range<usize>)> {
    let mut found = Vec::new();
    let mut open: Option<(String, usize)> = None;
    let mut at = 0;
    for line in page.split_inclusive('\n') {
        let end = at + line.len();
        if let Some(language) = line.strip_prefix("```") {
            match open.take() {
                None => open = Some((language.trim().to_owned(), end)),
                Some((language, begin)) => found.push((language, begin..at)),
            }
        }
        at = end;
    }
    found
}

/// The programs that a block of text follows.
fn examples(page: &str) -> Vec<Example> {
    let blocks = blocks(page);
    let pairs = blocks.iter().zip(blocks.iter().skip(1));
    let printed = pairs.filter(|((program, _), (output, _))| program != "text" && output == "text");
    printed
        .map(|((language, program), (_, output))| Example {
            language: language.clone(),
            program: page[program.clone()].to_owned(),
            output: output.clone(),
        })
        .collect()
}

fn runs(program: &str, arguments: &[&str]) -> bool {
    Command::new(program).args(arguments).output().is_ok_and(|output| output.status.success())
}

/// What the program prints; `Err` says why it is skipped.
fn printed(example: &Example) -> Result<String, &'static str> {
    let (interpreter, option) = match example.language.as_str() {
        "python" if !runs("python3", &["-c", ""]) => return Err("python3 is absent"),
        "python" if example.program.contains("import pandas") && !runs("python3", &["-c", "import pandas"]) => {
            return Err("pandas is absent");
        }
        "python" => ("python3", "-c"),
        "r" if !runs("Rscript", &["-e", "1"]) => return Err("Rscript is absent"),
        "r" => ("Rscript", "-e"),
        language => panic!("no interpreter is known for `{language}`"),
    };
    let mut command = Command::new(interpreter);
    let output = command.args([option, &example.program]).current_dir(env!("CARGO_MANIFEST_DIR")).output().unwrap();
    assert!(output.status.success(), "{}\n{}", example.program, String::from_utf8_lossy(&output.stderr));
    Ok(String::from_utf8(output.stdout).unwrap())
}

#[test]
fn programs_in_the_book_print_what_stands_below_them() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/guide/results.md");
    let page = fs::read_to_string(&path).unwrap();
    let examples = examples(&page);
    assert_eq!(examples.len(), 3);
    let mut updated = page.clone();
    // From the last on: places of those before it stay.
    for example in examples.iter().rev() {
        match printed(example) {
            Ok(text) => updated.replace_range(example.output.clone(), &text),
            Err(why) => eprintln!("skipped: {why}, a program in {} is not run:\n{}", path.display(), example.program),
        }
    }
    if std::env::var_os("UMBRASIM_UPDATE_BOOK").is_some() {
        return fs::write(&path, &updated).unwrap();
    }
    assert_eq!(updated, page);
}

/// All functions that are tests, by name: those of `proptest!` among them.
fn functions(folder: &Path, found: &mut std::collections::BTreeSet<String>) {
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            functions(&path, found);
        } else if path.extension().is_some_and(|ending| ending == "rs") {
            let text = fs::read_to_string(&path).unwrap();
            let mut is_test = false;
            for line in text.lines().map(str::trim) {
                match line.strip_prefix("fn ") {
                    Some(rest) if is_test => drop(found.insert(rest.split('(').next().unwrap().to_owned())),
                    _ if line.starts_with("#[") && is_test => continue,
                    _ => {}
                }
                is_test = line == "#[test]";
            }
        }
    }
}

#[test]
fn tests_that_the_book_names_are_there() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut tests = std::collections::BTreeSet::new();
    ["src", "tests"].into_iter().for_each(|folder| functions(&root.join(folder), &mut tests));
    let pages = ["files", "pages"].map(|page| root.join(format!("docs/validation/{page}.md")));
    let page = pages.map(|page| fs::read_to_string(page).unwrap()).concat();
    // Names of tests are sentences; other words in code have no underscores.
    let named: Vec<&str> = page
        .split('`')
        .skip(1)
        .step_by(2)
        .filter(|word| word.matches('_').count() > 1 && word.is_ascii() && **word == word.to_lowercase())
        .collect();
    assert!(named.len() > 75, "{named:?}");
    let absent: Vec<&&str> = named.iter().filter(|name| !tests.contains(**name)).collect();
    assert!(absent.is_empty(), "no test has these names: {absent:?}");
}
