//! The pages of reports in a browser: what a reader sees and can do. Each test says that it skips where Chromium is
//! absent.

#[path = "browser/chromium.rs"]
mod chromium;
mod common;

use std::path::{Path, PathBuf};

use chromium::Browser;
use common::Desk;
use serde_json::{Value, json};

/// A folder with a page of each kind that is made in a moment, and the paths of the pages.
fn pages() -> (Desk, Vec<PathBuf>) {
    let desk = Desk::with_experiment();
    desk.put("sweep.ron", "(experiment: \"tiny.ron\", vary: {\"traversal.cache.bytes\": [4096, 16384, 65536]})");
    let both = "points: All, vary: {\"clock_mhz\": [400, 800], \"traversal.count\": [2, 4]}";
    desk.put("both.ron", &format!("(experiment: \"tiny.ron\", {both})"));
    let levels = "experiments: [(file: \"tiny.ron\", frames: \"0..4\")], machines: [\"small.ron\"]";
    desk.put("levels.ron", &format!("({levels}, rungs: [Bound, Profile])"));
    let fields = "\"traversal.count\": Integers(1, 4), \"shadow_cache.cache.bytes\": Log(128, 1024)";
    let points = "frames: \"0..2\", points: Space(machines: 12, budget: 8)";
    desk.put("space.ron", &format!("(experiment: \"tiny.ron\", {points}, vary: {{{fields}}})"));
    desk.succeed(&["trace", "tiny.ron", "-o", "x.rays"]);
    desk.succeed(&["run", "tiny.ron", "--out", "run"]);
    desk.succeed(&["sweep", "sweep.ron", "--out", "sweep"]);
    desk.succeed(&["sweep", "both.ron", "--out", "both"]);
    desk.succeed(&["sweep", "space.ron", "--out", "space"]);
    desk.succeed(&["pareto", "levels.ron", "--out", "pareto"]);
    desk.succeed(&["stress", "--case", "C1,C7,C8,C13,Plain", "--out", "stress"]);
    desk.succeed(&["chart", "run", "--out", "chart"]);
    desk.succeed(&["run", "tiny.ron", "--set", "clock_mhz=800", "--out", "faster"]);
    desk.succeed(&["diff", "run", "faster", "--out", "diff"]);
    desk.succeed(&["profile", "x.rays", "--machine", "small.ron", "--out", "profile"]);
    desk.succeed(&["ladder-map", "--quick", "--axis", "updates", "--axis", "skew", "--out", "ladder"]);
    let models = ["extrapolate", "x.rays", "--machine", "small.ron", "--cores", "8,16", "--check", "--out", "models"];
    desk.succeed(&models);
    let kinds = ["run", "sweep", "both", "space", "pareto", "stress", "chart", "profile", "diff", "ladder", "models"];
    let pages = kinds.map(|kind| desk.path(kind).join("index.html")).into();
    (desk, pages)
}

#[test]
fn pages_are_quiet_fit_the_window_and_print() {
    let Some(mut browser) = chromium::start() else { return };
    let (_desk, pages) = pages();
    for page in &pages {
        for width in [390, 1024, 1400] {
            browser.open(page, width);
            assert_eq!(browser.complaints(), Vec::<String>::new(), "{} at {width}", page.display());
            let wide = browser.value("document.documentElement.scrollWidth");
            assert!(wide.as_u64().unwrap() <= width.into(), "{} is {wide} wide at {width}", page.display());
            if width >= 1024 {
                // The tables of policies and machines are seen as a whole.
                let cut = "[...document.querySelectorAll('#policies .scroll')]\
                           .filter((it) => it.scrollWidth > it.clientWidth + 1).length";
                assert_eq!(browser.value(cut), 0, "{} at {width}", page.display());
            }
        }
        let count = browser.printed();
        assert!((1..=6).contains(&count), "{}: {count} pages on paper", page.display());
        dark(&mut browser, page);
        accessible(&mut browser, page);
    }
    sliders_and_tables(&mut browser, &pages[0]);
}

/// Pictures of a page in the book: the end of the name, width, height, and what the reader prefers.
const PICTURES: [(&str, u32, u32, &str); 4] = [
    ("light", 1200, 1000, "light"),
    ("dark", 1200, 1000, "dark"),
    ("phone", 390, 844, "light"),
    ("print", 794, 1123, "print"),
];

/// The sweep of the book's recipe, of small pictures.
const SWEEP: &str = "(experiment: \"quickstart\", frames: \"0..4:2\", resolution: (width: 48, height: 48), vary: {
    \"shadow_cache.cache.bytes\": [\"512 B\", \"1 KiB\", \"2 KiB\", \"4 KiB\", \"8 KiB\", \"16 KiB\"],
})";

#[test]
fn the_book_shows_a_runs_page_as_it_is() {
    the_book_shows("page", &Path::new(common::ROOT).join("reports/sample/index.html"));
}

#[test]
fn the_book_shows_a_sweeps_page_as_it_is() {
    let desk = Desk::new();
    desk.put("words.ron", SWEEP);
    desk.succeed(&["sweep", "words.ron", "--out", "words"]);
    the_book_shows("sweep", &desk.path("words/index.html"));
}

/// The book's pictures are of the page as it is, but for how a system's fonts are drawn. `UMBRASIM_BLESS=1` makes them.
fn the_book_shows(kind: &str, page: &Path) {
    let Some(mut browser) = chromium::start() else { return };
    for (end, width, height, look) in PICTURES {
        let name = format!("{kind}-{end}");
        browser.prefer(look);
        browser.open(page, width);
        let found = browser.picture(width, height);
        let file = Path::new(common::ROOT).join(format!("docs/guide/images/{name}.png"));
        if std::env::var_os("UMBRASIM_BLESS").is_some() {
            std::fs::write(&file, &found).unwrap();
        }
        let [found, known] = [blocks(&found), blocks(&std::fs::read(&file).unwrap())];
        assert_eq!(found.len(), known.len(), "{name} has another size: make it again with UMBRASIM_BLESS=1");
        let differ = found.iter().zip(&known).filter(|(a, b)| (*a - *b).abs() > 12.0).count();
        let most = found.len() / 20;
        assert!(differ <= most, "{name}: {differ} of {} blocks differ: look, and make it again", found.len());
    }
}

/// The mean brightness, 0 to 255, of each block of 20x20 pixels of a PNG.
fn blocks(picture: &[u8]) -> Vec<f64> {
    const SIDE: usize = 20;
    let mut decoder = png::Decoder::new(std::io::Cursor::new(picture));
    decoder.set_transformations(png::Transformations::normalize_to_color8());
    let mut reader = decoder.read_info().unwrap();
    let mut bytes = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut bytes).unwrap();
    let (samples, columns) = (info.color_type.samples(), (info.width as usize).div_ceil(SIDE));
    let mut sums = vec![(0.0, 0.0); columns * (info.height as usize).div_ceil(SIDE)];
    for (row, pixels) in bytes.chunks(info.line_size).enumerate() {
        for (column, pixel) in pixels.chunks_exact(samples).enumerate() {
            let (sum, count) = &mut sums[row / SIDE * columns + column / SIDE];
            *sum += pixel[..3].iter().map(|&part| f64::from(part)).sum::<f64>() / 3.0;
            *count += 1.0;
        }
    }
    sums.into_iter().map(|(sum, count)| sum / f64::max(count, 1.0)).collect()
}

/// Plots on dark pages have light ink on dark paper.
fn dark(browser: &mut Browser, page: &Path) {
    let shade =
        "(color) => { const [r, g, b] = color.match(/[\\d.]+/g).map(Number); return 0.2 * r + 0.7 * g + 0.1 * b; }";
    let ink = "getComputedStyle(document.querySelector('.plot svg text')).fill";
    let paper = "getComputedStyle(document.querySelector('.plot')).backgroundColor";
    for (scheme, is_dark) in [("dark", true), ("light", false)] {
        browser.prefer(scheme);
        browser.open(page, 1024);
        let shades = browser.value(&format!("[{ink}, {paper}].map({shade})"));
        let [ink, paper] = [0, 1].map(|at| shades[at].as_f64().unwrap());
        assert_eq!(ink > paper, is_dark, "{}, {scheme}: ink {ink}, paper {paper}", page.display());
        assert!((ink - paper).abs() > 150.0, "{}, {scheme}: ink {ink}, paper {paper}", page.display());
    }
}

/// What axe-core, a checker of accessibility, calls serious or worse.
fn accessible(browser: &mut Browser, page: &Path) {
    let Some(axe) = axe() else { return };
    browser.value(&format!("{axe}; true"));
    let run = "axe.run().then((it) => it.violations.filter((rule) => ['serious', 'critical'].includes(rule.impact))\
               .map((rule) => `${rule.id}: ${rule.nodes.slice(0, 3)\
               .map((node) => node.html.slice(0, 200)).join(' | ')}`))";
    let found = browser.value(run);
    assert_eq!(found, json!([]), "{}", page.display());
}

/// The script of axe-core, where it is installed.
fn axe() -> Option<String> {
    let file = "node_modules/axe-core/axe.min.js";
    let folder = std::env::var("AXE_FOLDER").unwrap_or_else(|_| common::ROOT.into());
    let script = std::fs::read_to_string(Path::new(&folder).join(file));
    if script.is_err() {
        println!("skipped: axe-core is absent, accessibility is not checked");
    }
    script.ok()
}

fn sliders_and_tables(browser: &mut Browser, page: &Path) {
    browser.open(page, 1400);
    let frame = |browser: &mut Browser| browser.value("document.querySelector('.frames output').textContent");
    let cursor = |browser: &mut Browser| {
        let x = browser.value("document.querySelector('svg.wide .cursor').getAttribute('x1')");
        x.as_str().unwrap().parse::<f64>().unwrap()
    };

    // By mouse to the last frame, by keyboard to the one before.
    browser.click(".frames input", (0.999, 0.5));
    assert_eq!(frame(browser), "frame 3");
    let last = cursor(browser);
    browser.key("ArrowLeft", 37);
    assert_eq!(frame(browser), "frame 2");
    assert!(cursor(browser) < last);
    assert_eq!(browser.value("document.querySelector('.frames input').ariaValueText"), "frame 2");
    assert!(browser.value("document.querySelector('.frames dl').textContent").as_str().unwrap().contains("wrong"));

    // The strip of time frames the frame that is chosen, and a click into it or a plot chooses another.
    let framed = |browser: &mut Browser| {
        let shown = "document.querySelectorAll('svg.wide[data-strips] .cursor:not([data-hidden])').length";
        browser.value(shown).as_u64().unwrap()
    };
    let strip = browser.value("document.querySelector('svg.wide[data-strips]').dataset.strips");
    let first = strip.as_str().unwrap().split(' ').next().unwrap().to_owned();
    let inside = "(() => { const [, x, y, right, bottom] = document.querySelector('svg.wide[data-strips]')\
                  .dataset.strips.split(' ').map(Number); const { width, height } = document\
                  .querySelector('svg.wide[data-strips]').viewBox.baseVal;\
                  return [(x + right) / 2 / width, (y + bottom) / 2 / height]; })()";
    let inside = browser.value(inside);
    let [x, y] = [0, 1].map(|at| inside[at].as_f64().unwrap());
    browser.click("svg.wide[data-strips]", (x, y));
    assert_eq!(frame(browser), format!("frame {first}"));
    assert!(framed(browser) > 0);
    browser.click("svg.wide[data-frames]", (0.08, 0.3));
    assert_eq!(frame(browser), "frame 0");
    assert_eq!(framed(browser), 0, "frame 0 warms up, and has no strip");
    browser.click(".frames input", (0.6, 0.5));

    let cut = |browser: &mut Browser| {
        let style = "document.querySelector('.compare:not([data-hidden])').style.getPropertyValue('--cut')";
        browser.value(style).as_str().unwrap().trim_end_matches('%').parse::<f64>().unwrap()
    };
    browser.click(".compare:not([data-hidden]) .cut", (0.8, 0.5));
    let right = cut(browser);
    assert!(right > 60.0, "{right}");
    browser.key("ArrowLeft", 37);
    assert_eq!(cut(browser), right - 1.0);

    // The table of machines, by its fourth column.
    let column = "document.querySelectorAll('#policies table.sort')[1]";
    let values = |browser: &mut Browser| {
        let rows = format!("[...{column}.tBodies[0].rows].map((row) => parseFloat(row.cells[2].textContent))");
        let Value::Array(values) = browser.value(&rows) else { panic!("no table") };
        values.iter().map(|value| value.as_f64().unwrap()).collect::<Vec<_>>()
    };
    let sorted = |browser: &mut Browser| browser.value(&format!("{column}.rows[0].cells[2].ariaSort"));
    assert_eq!(sorted(browser), "none");
    browser.click("#policies > div:nth-of-type(2) th:nth-child(3) button", (0.5, 0.5));
    assert_eq!(sorted(browser), "ascending");
    assert!(values(browser).is_sorted());
    browser.key("Enter", 13);
    assert_eq!(sorted(browser), "descending");
    assert!(values(browser).iter().rev().is_sorted());

    // Without its script the page has everything, too.
    browser.call("Emulation.setScriptExecutionDisabled", json!({ "value": true }));
    browser.open(page, 1024);
    let hidden = "[...document.querySelectorAll('.compare, table, .plot')].filter((it) => !it.checkVisibility()\
                  && !it.closest('details:not([open])')).length";
    assert_eq!(browser.value(hidden), 0);
    browser.call("Emulation.setScriptExecutionDisabled", json!({ "value": false }));
}
