//! A plot of a report, before and after it is drawn.

use super::canvas::DrawError;

/// A plot of data `D` that stands in section `S` of the page.
pub(crate) struct Plot<D, S = ()> {
    /// Its name in files.
    pub name: &'static str,
    /// Where it belongs.
    pub section: S,
    /// Draws an SVG file; none where the data has nothing to show.
    pub draw: fn(&D) -> Result<Option<String>, DrawError>,
}

/// A plot, drawn.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct Drawing<S = ()> {
    /// The file's name, without its end.
    pub name: String,
    /// Where it belongs.
    pub section: S,
    /// The SVG file.
    pub svg: String,
}

/// All plots that there is data for, in order.
///
/// # Errors
/// A plot cannot be drawn.
pub(crate) fn draw_all<D, S: Clone>(data: &D, plots: &[Plot<D, S>]) -> Result<Vec<Drawing<S>>, DrawError> {
    let drawn = plots.iter().map(|Plot { name, section, draw }| {
        let svg = draw(data)?;
        Ok(svg.map(|svg| Drawing { name: (*name).into(), section: section.clone(), svg }))
    });
    drawn.filter_map(Result::transpose).collect()
}
