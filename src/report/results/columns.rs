//! The columns of `results.csv`.

use super::row::{Amount, Row};

/// The name of the file.
pub(super) const RESULTS_FILE: &str = "results.csv";

/// A column.
pub(super) struct Column {
    /// Its header.
    pub name: &'static str,
    /// The meaning of its values.
    pub about: &'static str,
    /// Its value for a row.
    pub of: Of,
}

/// A column's value for a row, by type.
pub(super) enum Of {
    /// A name; empty where it does not apply.
    Text(for<'a> fn(&Row<'a>) -> &'a str),
    /// A frame's number.
    Frame(fn(&Row<'_>) -> Option<u32>),
    /// A measured number.
    Number(fn(&Row<'_>) -> Option<Amount>),
}

/// Columns before the varied fields.
pub(super) const NAMES: [Column; 7] = [
    Column { name: "run", about: "name of the experiment", of: Of::Text(|row| row.of.run) },
    Column { name: "scene", about: "name of the scene", of: Of::Text(|row| row.of.scene) },
    Column {
        name: "scope",
        about: "total: all measured frames together (of rows without a machine, all traced frames); \
                frame: one frame; warmup: one frame that is in no total, since it warms the machine up",
        of: Of::Text(|row| row.of.scope.name()),
    },
    Column { name: "frame", about: "number of the frame; empty of totals", of: Of::Frame(|row| row.of.frame) },
    Column { name: "policy", about: "name of the culling policy", of: Of::Text(|row| row.of.policy) },
    Column {
        name: "machine",
        about: "name of the machine; empty of what the tracer counted",
        of: Of::Text(|row| row.of.machine.map_or("", |(name, _)| name)),
    },
    Column {
        name: "fidelity",
        about: "fidelity level that the machine was replayed at; empty of what the tracer counted",
        of: Of::Text(|row| row.of.machine.map_or("", |(_, fidelity)| fidelity)),
    },
];

/// Columns after the varied fields.
pub(super) const VALUES: [Column; 7] = [
    Column {
        name: "part",
        about: "level of memory, cache, unit, queue, kind of rays, part with energy, light, or answer to \
                an open question; empty of a whole machine",
        of: Of::Text(|row| row.part.unwrap_or_default()),
    },
    Column {
        name: "class",
        about: "class of memory traffic, or cause of a unit's cycles; of split.cycles, split.dram and split.joules \
                which of three replays",
        of: Of::Text(|row| row.class.unwrap_or_default()),
    },
    Column {
        name: "metric",
        about: "what the number is: see the rows of this file whose entry is metric",
        of: Of::Text(|row| &row.metric.name),
    },
    Column { name: "value", about: "the number; empty where a sample cannot tell it", of: Of::Number(|row| row.value) },
    Column { name: "unit", about: "unit of value and half_width", of: Of::Text(|row| row.metric.unit) },
    Column {
        name: "half_width",
        about: "half the width of the number's 95 % interval: 0 of an exact number, \
                empty where the interval is not known",
        of: Of::Number(|row| row.half_width.map(Amount::Real)),
    },
    Column { name: "reason", about: "why half_width, or value with it, is empty", of: Of::Text(|row| row.reason()) },
];

/// The meaning of a varied field's column.
pub(super) const VARIED: &str = "varied field of the machine's file; empty where the value is the file's own";
