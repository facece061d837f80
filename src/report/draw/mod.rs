//! Drawing: a canvas, forms of plots that several reports use, and what a plot is.

pub mod bars;
pub mod canvas;
pub mod over_frames;
mod plot;

pub use canvas::DrawError;
pub use plot::{Drawing, Plot, draw_all};
