//! Drawing: a canvas, colours by meaning, plot types that several reports use, and the parts of a plot.

pub(super) mod bars;
pub(super) mod canvas;
pub(super) mod changes;
pub(super) mod figure;
pub(super) mod marks;
pub(super) mod over_frames;
pub(super) mod palette;
pub(super) mod reach;
pub(super) mod ticks;
pub(super) mod waterfall;

pub(super) use canvas::DrawError;
pub(super) use figure::{Drawing, Figure, Plot, draw_all};
