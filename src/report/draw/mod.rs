//! Drawing: a canvas, forms of plots that several reports use, and what a plot is.

pub(super) mod bars;
pub(super) mod canvas;
pub(super) mod over_frames;
mod plot;

pub(super) use canvas::DrawError;
pub(super) use plot::{Drawing, Plot, draw_all};
