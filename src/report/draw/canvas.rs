//! What all plots are drawn with: a white sheet in pixels, text, colours, ticks, legends.

use plotters::backend::SVGBackend;
use plotters::coord::Shift;
use plotters::drawing::{DrawingArea, IntoDrawingArea};
use plotters::element::{Circle, Drawable, PathElement, PointCollection, Rectangle};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{Color, FontDesc, FontFamily, FontStyle, RGBColor, ShapeStyle, TextStyle};

use crate::stats::TrafficClass;

/// Nothing can be drawn.
#[derive(Debug, thiserror::Error)]
#[error("cannot draw: {0}")]
pub(crate) struct DrawError(String);

/// Colours that people with any colour vision tell apart (Okabe and Ito 2008).
pub(crate) mod palette {
    use plotters::style::RGBColor;

    pub(crate) const ORANGE: RGBColor = RGBColor(0xe6, 0x9f, 0x00);
    pub(crate) const SKY: RGBColor = RGBColor(0x56, 0xb4, 0xe9);
    pub(crate) const GREEN: RGBColor = RGBColor(0x00, 0x9e, 0x73);
    pub(crate) const YELLOW: RGBColor = RGBColor(0xf0, 0xe4, 0x42);
    pub(crate) const BLUE: RGBColor = RGBColor(0x00, 0x72, 0xb2);
    pub(crate) const VERMILLION: RGBColor = RGBColor(0xd5, 0x5e, 0x00);
    pub(crate) const PURPLE: RGBColor = RGBColor(0xcc, 0x79, 0xa7);
    pub(crate) const GREY: RGBColor = RGBColor(0xc4, 0xc8, 0xcc);
    pub(crate) const PAPER: RGBColor = RGBColor(0xff, 0xff, 0xff);
    pub(crate) const INK: RGBColor = RGBColor(0x22, 0x26, 0x2a);
    pub(crate) const FAINT: RGBColor = RGBColor(0x5f, 0x66, 0x6d);
    pub(crate) const GRID: RGBColor = RGBColor(0xe4, 0xe6, 0xe9);
}

use palette::{BLUE, FAINT, GREEN, INK, ORANGE, PURPLE, SKY, VERMILLION, YELLOW};

/// Width of every plot.
pub(crate) const WIDTH: i32 = 960;
/// Where titles and legends begin.
pub(crate) const LEFT: i32 = 16;
/// Height of a line of small text.
pub(crate) const LINE: i32 = 20;

/// The colour of a class of traffic, the same in every plot.
pub(crate) fn class_color(class: TrafficClass) -> RGBColor {
    match class {
        TrafficClass::Node => BLUE,
        TrafficClass::List => GREEN,
        TrafficClass::Triangle => SKY,
        TrafficClass::ModeWord => VERMILLION,
        TrafficClass::PixelCounter => ORANGE,
        TrafficClass::OccluderId => YELLOW,
        TrafficClass::Ray => PURPLE,
    }
}

/// The colour of the policy in place `index` among those that cull.
pub(crate) fn policy_color(index: usize) -> RGBColor {
    const COLORS: [RGBColor; 8] = [BLUE, VERMILLION, GREEN, PURPLE, ORANGE, SKY, INK, YELLOW];
    COLORS[index % COLORS.len()]
}

/// A colour that is less than half as strong, on white.
pub(crate) fn pale(color: RGBColor) -> RGBColor {
    let lighter = |level: u8| (255.0 - 0.45 * f64::from(255 - level)).round() as u8;
    RGBColor(lighter(color.0), lighter(color.1), lighter(color.2))
}

/// How a text looks and to which side of its point it lies.
#[derive(Clone, Copy)]
pub(crate) struct Text {
    size: i32,
    bold: bool,
    color: RGBColor,
    side: HPos,
}

impl Text {
    /// A plot's title.
    pub(crate) const TITLE: Self = Self { size: 17, bold: true, color: INK, side: HPos::Left };
    /// What is named beside the data.
    pub(crate) const LABEL: Self = Self { size: 13, bold: false, color: INK, side: HPos::Left };
    /// Ticks, axes and explanations.
    pub(crate) const NOTE: Self = Self { size: 12, bold: false, color: FAINT, side: HPos::Left };

    /// Ends at its point.
    pub(crate) const fn right(self) -> Self {
        Self { side: HPos::Right, ..self }
    }

    /// Has its point in the middle.
    pub(crate) const fn centered(self) -> Self {
        Self { side: HPos::Center, ..self }
    }

    /// In bold.
    pub(crate) const fn bold(self) -> Self {
        Self { bold: true, ..self }
    }

    /// In another colour.
    pub(crate) const fn colored(self, color: RGBColor) -> Self {
        Self { color, ..self }
    }

    /// The width to keep free for a text. No font is at hand to measure with: it is an estimate for wide fonts.
    pub(crate) fn width(self, text: &str) -> i32 {
        let em = if self.bold { 0.66 } else { 0.6 };
        (text.chars().count() as f64 * f64::from(self.size) * em).ceil() as i32
    }
}

/// A sheet of paper in pixels, from the top left.
pub(crate) struct Canvas<'a> {
    area: DrawingArea<SVGBackend<'a>, Shift>,
}

/// The SVG file of a sheet of [`WIDTH`] and `height` pixels on which `paint` paints.
pub(crate) fn svg(height: i32, paint: impl FnOnce(&Canvas<'_>) -> Result<(), DrawError>) -> Result<String, DrawError> {
    let mut text = String::new();
    let area = SVGBackend::with_string(&mut text, (WIDTH as u32, height as u32)).into_drawing_area();
    area.fill(&palette::PAPER).map_err(failed)?;
    let canvas = Canvas { area };
    paint(&canvas)?;
    canvas.area.present().map_err(failed)?;
    drop(canvas);
    Ok(text)
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

    /// A filled rectangle with opposite corners `from` and `to`.
    pub(crate) fn rect(&self, from: (i32, i32), to: (i32, i32), color: RGBColor) -> Result<(), DrawError> {
        self.draw(&Rectangle::new([from, to], color.filled()))
    }

    /// A line through the points.
    pub(crate) fn line(&self, points: Vec<(i32, i32)>, color: RGBColor, width: u32) -> Result<(), DrawError> {
        self.draw(&PathElement::new(points, ShapeStyle { color: color.to_rgba(), filled: false, stroke_width: width }))
    }

    /// A dashed line from `from` to `to` at height `y`.
    pub(crate) fn dashes(&self, from: i32, to: i32, y: i32, color: RGBColor) -> Result<(), DrawError> {
        (from..to).step_by(10).try_for_each(|x| self.line(vec![(x, y), ((x + 6).min(to), y)], color, 1))
    }

    /// A dot.
    pub(crate) fn dot(&self, at: (i32, i32), radius: i32, color: RGBColor) -> Result<(), DrawError> {
        self.draw(&Circle::new(at, radius, color.filled()))
    }

    /// A text whose middle is at the height of `at`.
    pub(crate) fn text(&self, text: &str, at: (i32, i32), look: Text) -> Result<(), DrawError> {
        let style = if look.bold { FontStyle::Bold } else { FontStyle::Normal };
        // The SVG backend divides sizes by 1.24.
        let font = FontDesc::new(FontFamily::SansSerif, f64::from(look.size) * 1.24, style);
        let style = TextStyle::from(font).color(&look.color).pos(Pos::new(look.side, VPos::Center));
        self.area.draw_text(text, &style, at).map_err(failed)
    }

    /// Title and subtitle at the top; gives the height below them.
    pub(crate) fn titles(&self, title: &str, subtitle: &str) -> Result<i32, DrawError> {
        self.text(title, (LEFT, 22), Text::TITLE)?;
        self.text(subtitle, (LEFT, 45), Text::NOTE)?;
        Ok(TITLES)
    }

    /// A legend in rows from height `top` on; gives the height below it.
    pub(crate) fn legend(&self, top: i32, entries: &[(String, RGBColor)]) -> Result<i32, DrawError> {
        let mut y = top + LINE / 2;
        let mut x = LEFT;
        for (name, color) in entries {
            let width = legend_width(name);
            if x > LEFT && x + width > WIDTH {
                x = LEFT;
                y += LINE;
            }
            self.rect((x, y - 6), (x + 12, y + 6), *color)?;
            self.text(name, (x + 18, y), Text::LABEL)?;
            x += width;
        }
        Ok(y + LINE)
    }
}

/// Height of [`Canvas::titles`].
pub(crate) const TITLES: i32 = 62;

fn legend_width(name: &str) -> i32 {
    18 + Text::LABEL.width(name) + 14
}

/// Height of [`Canvas::legend`].
pub(crate) fn legend_height(entries: &[(String, RGBColor)]) -> i32 {
    let (mut x, mut rows) = (LEFT, 1);
    for (name, _) in entries {
        let width = legend_width(name);
        if x > LEFT && x + width > WIDTH {
            x = LEFT;
            rows += 1;
        }
        x += width;
    }
    rows * LINE + LINE / 2
}

/// The distance of ticks: 1, 2 or 5 times a power of ten, so that `span` has at most `most` of them.
pub(crate) fn tick_step(span: f64, most: u32) -> f64 {
    let least = span / f64::from(most);
    let power = 10f64.powf(least.log10().floor());
    [1.0, 2.0, 5.0, 10.0].map(|step| step * power).into_iter().find(|&step| step >= least * 0.999_999).unwrap_or(least)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_and_few() {
        assert_eq!(tick_step(784.0, 10), 100.0);
        assert_eq!(tick_step(0.52, 5), 0.2);
        assert_eq!(tick_step(50.0, 5), 10.0);
        assert_eq!(tick_step(1.0, 5), 0.2);
    }

    #[test]
    fn a_legend_is_as_high_as_said() {
        for count in [1, 3, 12, 40] {
            let entries = vec![("a class of things".to_owned(), BLUE); count];
            let mut below = 0;
            svg(400, |canvas| {
                below = canvas.legend(100, &entries)?;
                Ok(())
            })
            .unwrap();
            assert_eq!(below, 100 + legend_height(&entries));
        }
    }
}
