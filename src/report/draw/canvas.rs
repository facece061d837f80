//! The canvas of all plots: a sheet in pixels, with text, lines and shapes.

use std::cell::RefCell;

use plotters::backend::SVGBackend;
use plotters::coord::Shift;
use plotters::drawing::{DrawingArea, IntoDrawingArea};
use plotters::element::{Circle, Drawable, PathElement, PointCollection, Polygon, Rectangle};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{Color as _, FontDesc, FontFamily, FontStyle, ShapeStyle, TextStyle};

use super::palette::{Color, FAINT, INK, PAPER};

/// A drawing failed.
#[derive(Debug, thiserror::Error)]
#[error("cannot draw: {0}")]
pub(crate) struct DrawError(String);

/// Width of a plot in a file and on a wide page.
pub(crate) const WIDE: i32 = 960;
/// Width of a plot on a narrow page.
pub(crate) const NARROW: i32 = 360;
/// The column where data and text begin.
pub(crate) const LEFT: i32 = 4;
/// Height of a line of small text.
pub(crate) const LINE: i32 = 20;

/// Size, weight and colour of a text, and the side of its point on which it lies.
#[derive(Clone, Copy)]
pub(crate) struct Text {
    size: i32,
    bold: bool,
    color: Color,
    side: HPos,
}

impl Text {
    /// A plot's title, in files.
    pub(crate) const TITLE: Self = Self { size: 17, bold: true, color: INK, side: HPos::Left };
    /// Names beside the data.
    pub(crate) const LABEL: Self = Self { size: 13, bold: false, color: INK, side: HPos::Left };
    /// Ticks, axes and explanations.
    pub(crate) const NOTE: Self = Self { size: 12, bold: false, color: FAINT, side: HPos::Left };

    /// The text ends at its point.
    pub(crate) const fn right(self) -> Self {
        Self { side: HPos::Right, ..self }
    }

    /// The text is centred on its point.
    pub(crate) const fn centered(self) -> Self {
        Self { side: HPos::Center, ..self }
    }

    /// In bold.
    pub(crate) const fn bold(self) -> Self {
        Self { bold: true, ..self }
    }

    /// In another colour.
    pub(crate) const fn colored(self, color: Color) -> Self {
        Self { color, ..self }
    }

    /// The width to keep free for a text. Fonts cannot be measured here, so this is an estimate for wide fonts.
    pub(crate) fn width(self, text: &str) -> i32 {
        let em = if self.bold { 0.62 } else { 0.57 };
        (text.chars().count() as f64 * f64::from(self.size) * em).ceil() as i32
    }
}

/// A sheet of paper in pixels; the origin is at the top left.
pub(crate) struct Canvas<'a> {
    area: DrawingArea<SVGBackend<'a>, Shift>,
    width: i32,
    attributes: RefCell<String>,
}

/// The SVG of a painted sheet.
pub(crate) struct Painted {
    /// The elements of the SVG.
    pub elements: String,
    /// Attributes for the SVG's root.
    pub attributes: String,
}

/// Makes a sheet of this size and lets `paint` draw on it.
pub(crate) fn sheet(
    width: i32,
    height: i32,
    paint: impl FnOnce(&Canvas<'_>) -> Result<(), DrawError>,
) -> Result<Painted, DrawError> {
    let mut text = String::new();
    let area = SVGBackend::with_string(&mut text, (width as u32, height as u32)).into_drawing_area();
    let canvas = Canvas { area, width, attributes: RefCell::default() };
    paint(&canvas)?;
    canvas.area.present().map_err(failed)?;
    let attributes = canvas.attributes.borrow().clone();
    drop(canvas);
    Ok(Painted { elements: compact(&text), attributes })
}

/// The elements that the backend wrote, without its root and without attributes that are defaults. Ink becomes the
/// text colour, and paper the colour of the card.
fn compact(text: &str) -> String {
    let inside = text.find('>').map_or("", |root| &text[root + 1..]);
    let inside = inside.trim_end().trim_end_matches("</svg>");
    inside
        .replace('\n', "")
        .replace(" opacity=\"1\"", "")
        .replace(" font-family=\"sans-serif\"", "")
        .replace(" stroke=\"none\"", "")
        .replace(" stroke-width=\"1\"", "")
        .replace(".000000000000002\"", "\"")
        .replace(" \"/>", "\"/>")
        .replace("#22262A", "currentColor")
        .replace("#FFFFFF", "var(--card, #fff)")
}

fn failed(error: impl std::error::Error) -> DrawError {
    DrawError(error.to_string())
}

impl<'a> Canvas<'a> {
    fn draw<E>(&self, element: &E) -> Result<(), DrawError>
    where
        for<'b> &'b E: PointCollection<'b, (i32, i32)>,
        E: Drawable<SVGBackend<'a>>,
    {
        self.area.draw(element).map_err(failed)
    }

    /// The sheet's width.
    pub(crate) fn width(&self) -> i32 {
        self.width
    }

    /// Whether the sheet is for a narrow page.
    pub(crate) fn is_narrow(&self) -> bool {
        is_narrow(self.width)
    }

    /// Sets the attribute of the SVG's root that the page's script reads. A sheet has one.
    pub(crate) fn attribute(&self, name: &str, value: &str) {
        *self.attributes.borrow_mut() = format!(" {name}=\"{value}\"");
    }

    /// A filled rectangle with opposite corners `from` and `to`.
    pub(crate) fn rect(&self, from: (i32, i32), to: (i32, i32), color: Color) -> Result<(), DrawError> {
        self.draw(&Rectangle::new([from, to], color.filled()))
    }

    /// The outline of a rectangle.
    pub(crate) fn frame(&self, from: (i32, i32), to: (i32, i32), color: Color, width: u32) -> Result<(), DrawError> {
        self.draw(&Rectangle::new([from, to], stroke(color, width)))
    }

    /// A line through the points.
    pub(crate) fn line(&self, points: Vec<(i32, i32)>, color: Color, width: u32) -> Result<(), DrawError> {
        self.draw(&PathElement::new(points, stroke(color, width)))
    }

    /// A filled polygon.
    pub(crate) fn polygon(&self, points: Vec<(i32, i32)>, color: Color) -> Result<(), DrawError> {
        self.draw(&Polygon::new(points, color.filled()))
    }

    /// A dashed line from `from` to `to` at height `y`.
    pub(crate) fn dashes(&self, from: i32, to: i32, y: i32, color: Color) -> Result<(), DrawError> {
        (from..to).step_by(40).try_for_each(|x| self.line(vec![(x, y), ((x + 24).min(to), y)], color, 1))
    }

    /// A dot.
    pub(crate) fn dot(&self, at: (i32, i32), radius: i32, color: Color) -> Result<(), DrawError> {
        self.draw(&Circle::new(at, radius, color.filled()))
    }

    /// A circle.
    pub(crate) fn ring(&self, at: (i32, i32), radius: i32, color: Color, width: u32) -> Result<(), DrawError> {
        self.draw(&Circle::new(at, radius, stroke(color, width)))
    }

    /// A text that is vertically centred on `at`.
    pub(crate) fn text(&self, text: &str, at: (i32, i32), look: Text) -> Result<(), DrawError> {
        let style = if look.bold { FontStyle::Bold } else { FontStyle::Normal };
        // The SVG backend divides sizes by 1.24.
        let font = FontDesc::new(FontFamily::SansSerif, f64::from(look.size) * 1.24, style);
        let style = TextStyle::from(font).color(&look.color).pos(Pos::new(look.side, VPos::Center));
        self.area.draw_text(text, &style, at).map_err(failed)
    }

    /// A text on a rectangle of paper, which hides the drawing below it.
    pub(crate) fn text_on_paper(&self, text: &str, at: (i32, i32), look: Text) -> Result<(), DrawError> {
        let width = look.width(text);
        let left = match look.side {
            HPos::Left => at.0,
            HPos::Center => at.0 - width / 2,
            HPos::Right => at.0 - width,
        };
        self.rect((left - 3, at.1 - LINE / 2), (left + width + 3, at.1 + LINE / 2), PAPER)?;
        self.text(text, at, look)
    }
}

fn stroke(color: Color, width: u32) -> ShapeStyle {
    ShapeStyle { color, filled: false, stroke_width: width }
}

/// Whether a sheet of this width is for a narrow page.
pub(crate) fn is_narrow(width: i32) -> bool {
    width < (WIDE + NARROW) / 2
}

/// The distance between ticks: 1, 2 or 5 times a power of ten, so that `span` has at most `most` ticks.
pub(crate) fn tick_step(span: f64, most: u32) -> f64 {
    let least = span / f64::from(most);
    let power = 10f64.powf(least.log10().floor());
    [1.0, 2.0, 5.0, 10.0].map(|step| step * power).into_iter().find(|&step| step >= least * 0.999_999).unwrap_or(least)
}

#[cfg(test)]
mod tests {
    use super::super::palette::BLUE;
    use super::*;

    #[test]
    fn ticks_are_round_and_few() {
        assert_eq!(tick_step(784.0, 10), 100.0);
        assert_eq!(tick_step(0.52, 5), 0.2);
        assert_eq!(tick_step(50.0, 5), 10.0);
        assert_eq!(tick_step(1.0, 5), 0.2);
    }

    #[test]
    fn ink_is_the_texts_colour_and_paper_the_cards() {
        let painted = sheet(WIDE, 40, |canvas| {
            canvas.attribute("data-x", "1 2");
            canvas.rect((0, 0), (9, 9), PAPER)?;
            canvas.dot((5, 5), 2, BLUE)?;
            canvas.text("a < b", (20, 20), Text::NOTE)
        });
        let Painted { elements, attributes } = painted.unwrap();
        assert_eq!(attributes, " data-x=\"1 2\"");
        assert!(elements.contains("var(--card, #fff)") && elements.contains("#0072B2"), "{elements}");
        assert!(elements.contains("opacity=\"0.78\" fill=\"currentColor\">a &lt; b</text>"), "{elements}");
        assert!(!elements.contains("svg") && !elements.contains('\n'), "{elements}");
    }
}
