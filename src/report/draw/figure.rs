//! A plot of a report: its texts, its data, and a function that paints it at any width.

use minijinja::HtmlEscape;

use super::canvas::{Canvas, DrawError, LEFT, LINE, NARROW, Painted, Text, WIDE, sheet};
use super::palette::Color;
use crate::report::grid::Grid;

/// Names of meanings, each with its colour.
pub(crate) type Key = Vec<(String, Color)>;

/// Maps the width of a sheet to its height.
type Height<'a> = Box<dyn Fn(i32) -> i32 + 'a>;
type Paint<'a> = Box<dyn Fn(&Canvas<'_>) -> Result<(), DrawError> + 'a>;

/// A plot before it is drawn.
pub(crate) struct Figure<'a> {
    /// What the data shows, in a sentence.
    pub title: String,
    /// How to read it.
    pub about: String,
    /// The meaning of colours; may be empty.
    pub key: Key,
    /// The numbers.
    pub data: Grid,
    /// Whether the figure can be painted on a narrow sheet; otherwise a narrow page scrolls the wide sheet.
    pub narrow: bool,
    /// The height of a sheet, by its width.
    pub height: Height<'a>,
    /// Paints the data.
    pub paint: Paint<'a>,
}

/// A plot of data `D` in section `S` of the page.
pub(crate) struct Plot<D, S = ()> {
    /// Its name in files.
    pub name: &'static str,
    /// Its section of the page.
    pub section: S,
    /// Its figure; `None` if there is nothing to show.
    pub figure: for<'a> fn(&'a D) -> Option<Figure<'a>>,
}

/// A drawn plot.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Drawing<S = ()> {
    /// The file's name, without its extension.
    pub name: String,
    /// Its section of the page.
    pub section: S,
    /// What the data shows.
    pub title: String,
    /// How to read it.
    pub about: String,
    /// The meaning of colours.
    pub key: Key,
    /// The numbers.
    pub data: Grid,
    /// The SVG file, with title and key.
    pub file: String,
    /// For wide pages: SVG without title and key.
    pub wide: String,
    /// The same for narrow pages; empty if a narrow page scrolls the wide one.
    pub narrow: String,
}

/// Attributes that thousands of elements of a page share, and the class that stands for them in the style sheet of
/// pages.
const IN_STYLE_SHEET: [(&str, &str); 15] = [
    (" dy=\"0.5ex\" text-anchor=\"start\"", ""),
    (" dy=\"0.5ex\"", ""),
    (" fill=\"currentColor\">", ">"),
    (" font-size=\"12\"", ""),
    ("<polyline fill=\"none\"", "<polyline"),
    (" opacity=\"0.16\" stroke=\"currentColor\"", " class=\"rule\""),
    (" text-anchor=\"middle\" opacity=\"0.78\"", " class=\"tick\""),
    (" text-anchor=\"end\" opacity=\"0.78\"", " class=\"end\""),
    (" text-anchor=\"end\" font-size=\"13\"", " class=\"e\""),
    (" font-size=\"13\" fill=\"currentColor\" font-weight=\"bold\"", " class=\"b\""),
    (" font-size=\"13\"", " class=\"l\""),
    (" opacity=\"0.78\" fill=\"none\" stroke=\"currentColor\"", " class=\"box\""),
    (" opacity=\"0.78\" stroke=\"currentColor\"", " class=\"o\""),
    (" fill=\"var(--card, #fff)\"", " class=\"p\""),
    (" opacity=\"0.55\" fill=\"#9AA1A8\"", " class=\"s\""),
];

impl<S> Drawing<S> {
    /// Draws a figure.
    ///
    /// # Errors
    /// The figure cannot be drawn.
    pub(crate) fn new(name: String, section: S, figure: Figure<'_>) -> Result<Self, DrawError> {
        let file = file(&figure)?;
        let draw = |width, class| {
            let height = (figure.height)(width);
            let Painted { elements, attributes } = sheet(width, height, |canvas| (figure.paint)(canvas))?;
            let elements = IN_STYLE_SHEET.iter().fold(elements, |text, (long, short)| text.replace(long, short));
            Ok(format!(
                "<svg class=\"{class}\" viewBox=\"0 0 {width} {height}\" role=\"img\" aria-labelledby=\"{name}-title\" \
                 aria-describedby=\"{name}-about\"{attributes}>{elements}</svg>"
            ))
        };
        let (wide, narrow) = match figure.narrow {
            true => (draw(WIDE, "wide")?, draw(NARROW, "narrow")?),
            false => (draw(WIDE, "scrolled")?, String::new()),
        };
        let Figure { title, about, key, data, .. } = figure;
        Ok(Self { wide, narrow, name, section, title, about, key, data, file })
    }
}

/// Draws all plots that have data, in order.
///
/// # Errors
/// A plot cannot be drawn.
pub(crate) fn draw_all<D, S: Clone>(data: &D, plots: &[Plot<D, S>]) -> Result<Vec<Drawing<S>>, DrawError> {
    let figures = plots.iter().filter_map(|plot| Some((plot, (plot.figure)(data)?)));
    figures.map(|(plot, figure)| Drawing::new(plot.name.into(), plot.section.clone(), figure)).collect()
}

/// The figure as a file: title, explanation and key above the data.
fn file(figure: &Figure<'_>) -> Result<String, DrawError> {
    let (margin, title_line) = (12, 26);
    let [title, about] = [(&figure.title, Text::TITLE), (&figure.about, Text::NOTE)]
        .map(|(text, look)| wrapped(text, look, WIDE - 2 * LEFT));
    let key = key_places(&figure.key);
    let key_rows = key.last().map_or(0, |(_, y)| y / LINE + 1);
    let first = margin + title_line * title.len() as i32;
    let above = first + (about.len() as i32 + key_rows) * LINE + 8;
    let head = sheet(WIDE, above, |canvas| {
        for (line, y) in title.iter().zip((margin + 10..).step_by(title_line as usize)) {
            canvas.text(line, (LEFT, y), Text::TITLE)?;
        }
        for (line, y) in about.iter().zip((first + 10..).step_by(LINE as usize)) {
            canvas.text(line, (LEFT, y), Text::NOTE)?;
        }
        let top = first + about.len() as i32 * LINE + 12;
        figure.key.iter().zip(&key).try_for_each(|((name, color), (x, y))| {
            canvas.rect((*x, top + y - 6), (x + 12, top + y + 6), *color)?;
            canvas.text(name, (x + 18, top + y), Text::LABEL)
        })
    })?;
    let below = (figure.height)(WIDE);
    let body = sheet(WIDE, below, |canvas| (figure.paint)(canvas))?;
    let (width, height) = (WIDE + 2 * margin, above + below + margin);
    Ok(format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
         viewBox=\"0 0 {width} {height}\" role=\"img\" font-family=\"sans-serif\" \
         style=\"background:#fff;color:#22262a\">\n<title>{}</title>\n<desc>{}</desc>\n\
         <g transform=\"translate({margin})\">{}</g>\n<g transform=\"translate({margin} {above})\">{}</g>\n</svg>\n",
        HtmlEscape(&figure.title),
        HtmlEscape(&figure.about),
        head.elements,
        body.elements.replace("var(--card, #fff)", "#fff"),
    ))
}

/// The places of a key's entries, in rows.
fn key_places(key: &Key) -> Vec<(i32, i32)> {
    let (mut x, mut y) = (LEFT, 0);
    let place = |(name, _): &(String, Color)| {
        let width = 18 + Text::LABEL.width(name) + 14;
        if x > LEFT && x + width > WIDE {
            (x, y) = (LEFT, y + LINE);
        }
        let place = (x, y);
        x += width;
        place
    };
    key.iter().map(place).collect()
}

/// Splits a text into lines of at most `width` pixels; a longer word has a line of its own.
pub(crate) fn wrapped(text: &str, look: Text, width: i32) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        match lines.last_mut() {
            Some(line) if look.width(line) + look.width(word) < width => {
                line.push(' ');
                line.push_str(word);
            }
            _ => lines.push(word.into()),
        }
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::super::palette::BLUE;
    use super::*;

    #[test]
    fn text_is_wrapped_and_keys_stay_on_the_sheet() {
        assert_eq!(wrapped("one two three", Text::NOTE, Text::NOTE.width("one two t")), ["one two", "three"]);
        let key = vec![("a class of things".to_owned(), BLUE); 12];
        let places = key_places(&key);
        assert!(places.iter().all(|(x, _)| x + Text::LABEL.width("a class of things") < WIDE));
        assert!(places.last().unwrap().1 > 0);
    }

    /// A dot halfway along the sheet.
    fn dot(title: String) -> Figure<'static> {
        Figure {
            title,
            about: "how to read".into(),
            key: vec![("thing".into(), BLUE)],
            data: Grid { head: vec!["x".into()], names: 0, rows: vec![vec!["1".into()]] },
            narrow: true,
            height: Box::new(|width| width / 4),
            paint: Box::new(|canvas| canvas.dot((canvas.width() / 2, 9), 3, BLUE)),
        }
    }

    #[test]
    fn the_title_of_a_file_has_as_many_lines_as_it_needs() {
        let [short, long] = ["word", &["word"; 40].join(" ")].map(|title| file(&dot(title.into())).unwrap());
        let lines = |file: &str| file.matches("font-size=\"17\"").count();
        assert_eq!((lines(&short), lines(&long)), (1, 3));
        let height = |file: &str| -> i32 { file.split('"').nth(5).unwrap().parse().unwrap() };
        assert_eq!(height(&long), height(&short) + 2 * 26);
    }

    #[test]
    fn a_figure_is_a_file_and_two_pictures_of_a_page() {
        let drawing = Drawing::new("it".into(), (), dot("a < b".into())).unwrap();
        assert!(drawing.file.contains("<title>a &lt; b</title>") && drawing.file.contains("<desc>how to read</desc>"));
        assert!(drawing.wide.contains("viewBox=\"0 0 960 240\" role=\"img\" aria-labelledby=\"it-title\""));
        assert!(drawing.narrow.contains("viewBox=\"0 0 360 90\"") && drawing.narrow.contains("cx=\"180\""));
    }
}
