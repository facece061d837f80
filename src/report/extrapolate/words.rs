//! Predictions in a table and in sentences.

use super::data::{Extrapolation, Prediction};
use crate::quantity::Bytes;
use crate::report::format::{bytes, exact, joules, or_absent, short, signed};
use crate::report::grid::Grid;

/// Minimum of rays per frame and pool entry. With fewer rays, a frame is mostly its beginning and end, and it is
/// chance which rays a model has there: docs/validation/extrapolate.md.
const FEW: f64 = 32.0;

/// Measured and predicted figures: a row per model, then the large machine.
pub(crate) fn grid(found: &Extrapolation) -> Grid {
    let name = format!("{}, {}", found.machine, found.policy);
    let head = [name.as_str(), "cycles", "L2 bytes", "DRAM bytes", "energy"].map(String::from);
    let shown = |[cycles, l2, dram]: [f64; 3], energy: Option<f64>| {
        [exact(cycles.round() as u64), amount(l2), amount(dram), or_absent(energy, joules)]
    };
    let row = |name: String, cells: [String; 4]| [name].into_iter().chain(cells).collect::<Vec<String>>();
    let mut rows: Vec<_> = found
        .models
        .iter()
        .map(|model| row(format!("model of {}", cores(model.cores)), shown(model.figures.all(), model.joules)))
        .collect();
    let predicted =
        |name: String, of: fn(Prediction) -> f64| row(name, shown(found.predicted.all().map(of), found.joules.map(of)));
    rows.push(predicted(format!("{} cores, predicted", found.cores), |it| it.value));
    rows.push(predicted("  from".into(), |it| it.low));
    rows.push(predicted("  to".into(), |it| it.high));
    if let (Some(checked), Some(errors)) = (found.checked, found.errors()) {
        rows.push(row(
            format!("{} cores, Event", found.cores),
            shown(checked.all().map(|it| it as f64), found.checked_joules),
        ));
        rows.push(row("  the prediction is off".into(), errors.map(|off| or_absent(off, signed))));
    }
    Grid { head: head.to_vec(), names: 1, rows }
}

/// A number with its decimal prefix, before a unit: `1.77 G`.
fn prefixed(value: f64) -> String {
    let text = short(value);
    if text.contains(' ') { text } else { format!("{text} ") }
}

fn amount(value: f64) -> String {
    bytes(Bytes(value.round() as u64))
}

fn cores(count: u64) -> String {
    if count == 1 { "1 core".into() } else { format!("{count} cores") }
}

/// The result of the table, in sentences.
pub(crate) fn verdict(found: &Extrapolation) -> String {
    let Prediction { value, low, high, .. } = found.predicted.cycles;
    let range = format!("{} to {}", exact(low.round() as u64), exact(high.round() as u64));
    let predicted = format!(
        "{} would take {} cycles ({range} by other laws), trace {}rays/s and move {} of DRAM traffic.",
        found.name(),
        exact(value.round() as u64),
        prefixed(found.rays_per_second),
        amount(found.predicted.dram_bytes.value),
    );
    let checked = found.errors().map(|errors| errors.map(|off| or_absent(off, signed)));
    let checked = checked.map(|[cycles, l2, dram, energy]| {
        let energy =
            if found.checked_joules.is_some() { format!(", and {energy} of the energy") } else { String::new() };
        format!(" By Event, the prediction is off by {cycles} of cycles, {l2} of L2 and {dram} of DRAM bytes{energy}.")
    });
    let few = (found.rays_an_entry < FEW).then(|| {
        format!(
            "\nFew rays: {:.0} a frame for each entry of the pool. It is chance which of them a model has where the \
             frame begins and ends: a larger picture tells more.",
            found.rays_an_entry
        )
    });
    format!("{predicted}{}{}\nThe large machine: {}.", checked.unwrap_or_default(), few.unwrap_or_default(), found.dram)
}
