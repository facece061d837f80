//! Colours by meaning: each meaning has one colour in all plots and pictures of all pages.
//!
//! People with any type of colour vision can tell the hues apart (Okabe and Ito 2008).

use plotters::style::RGBAColor;

use crate::stats::{Cause, TrafficClass};

/// A colour and its opacity, for light and dark paper.
pub(crate) type Color = RGBAColor;

pub(crate) const ORANGE: Color = RGBAColor(0xe6, 0x9f, 0x00, 1.0);
pub(crate) const SKY: Color = RGBAColor(0x56, 0xb4, 0xe9, 1.0);
pub(crate) const GREEN: Color = RGBAColor(0x00, 0x9e, 0x73, 1.0);
pub(crate) const YELLOW: Color = RGBAColor(0xf0, 0xe4, 0x42, 1.0);
pub(crate) const BLUE: Color = RGBAColor(0x00, 0x72, 0xb2, 1.0);
pub(crate) const VERMILLION: Color = RGBAColor(0xd5, 0x5e, 0x00, 1.0);
pub(crate) const PURPLE: Color = RGBAColor(0xcc, 0x79, 0xa7, 1.0);
pub(crate) const GREY: Color = RGBAColor(0x9a, 0xa1, 0xa8, 0.55);
/// The paper: white in files, the card's colour in pages.
pub(crate) const PAPER: Color = RGBAColor(0xff, 0xff, 0xff, 1.0);
/// Text. In files and pages it is `currentColor`, so that dark pages have light text.
pub(crate) const INK: Color = RGBAColor(0x22, 0x26, 0x2a, 1.0);
pub(crate) const FAINT: Color = RGBAColor(0x22, 0x26, 0x2a, 0.78);
pub(crate) const GRID: Color = RGBAColor(0x22, 0x26, 0x2a, 0.16);

/// Decided dark, though the light is visible.
pub(crate) const FALSE_DARK: Color = VERMILLION;
/// Decided lit, though the light is hidden.
pub(crate) const FALSE_LIT: Color = YELLOW;
/// Rounding differs.
pub(crate) const NUMERIC: Color = SKY;

/// The colour of savings.
pub(crate) const SAVED: Color = GREEN;
/// The colour of costs.
pub(crate) const PAID: Color = VERMILLION;

/// A class of traffic.
pub(crate) fn class_color(class: TrafficClass) -> Color {
    match class {
        TrafficClass::Node => BLUE,
        TrafficClass::List => GREEN,
        TrafficClass::Triangle => SKY,
        TrafficClass::ModeWord => VERMILLION,
        TrafficClass::PixelCounter => ORANGE,
        TrafficClass::OccluderId => YELLOW,
        TrafficClass::Ray => PURPLE,
        TrafficClass::FrameBuffer => RGBAColor(PURPLE.0, PURPLE.1, PURPLE.2, 0.65),
        TrafficClass::Texture => RGBAColor(PURPLE.0, PURPLE.1, PURPLE.2, 0.35),
        TrafficClass::Build => GREY,
    }
}

/// A cause of a unit's cycles: its name and colour.
pub(crate) fn cause_look(cause: Cause) -> (&'static str, Color) {
    match cause {
        Cause::Busy => ("busy", GREEN),
        Cause::Pipeline => ("all rays in the pipeline", SKY),
        Cause::Memory => ("waits for memory", VERMILLION),
        Cause::Blocked => ("blocked by a neighbour", PURPLE),
        Cause::Intake => ("intake full", YELLOW),
        Cause::Starved => ("starved: no ray", GREY),
    }
}

/// The run without culling.
pub(crate) const WITHOUT: Color = RGBAColor(0x80, 0x88, 0x90, 1.0);

/// The colour of the policy or machine number `index`; the run without culling is not counted.
pub(crate) fn series_color(index: usize) -> Color {
    const COLORS: [Color; 8] = [BLUE, VERMILLION, GREEN, PURPLE, ORANGE, SKY, INK, YELLOW];
    COLORS[index % COLORS.len()]
}

/// The colour with an opacity of 0.42.
pub(crate) fn pale(color: Color) -> Color {
    faded(color, 0.42)
}

/// The colour with another opacity, from 0 to 1.
pub(crate) fn faded(color: Color, strength: f64) -> Color {
    RGBAColor(color.0, color.1, color.2, strength)
}

/// A colour as CSS; ink is the text colour.
pub(crate) fn css(color: Color) -> String {
    let RGBAColor(red, green, blue, strength) = color;
    match color {
        _ if (red, green, blue) == (INK.0, INK.1, INK.2) => "currentColor".into(),
        _ if strength < 1.0 => format!("rgb({red} {green} {blue} / {strength})"),
        _ => format!("#{red:02x}{green:02x}{blue:02x}"),
    }
}
