//! The tables and sentences of a space.

use super::data::{Accuracy, Design, Errors, SpaceSummary};
use crate::quantity::Bytes;
use crate::report::format::{bytes, counted, exact, joules, or_absent, percent, short};
use crate::report::grid::Grid;
use crate::report::sweep::shown;

/// Fidelity levels without an error.
const EXACT: [&str; 2] = ["Event", "Cycle"];

impl SpaceSummary {
    /// Paths of the fields that vary.
    pub(super) fn fields(&self) -> Vec<&str> {
        let mut fields: Vec<&str> = Vec::new();
        for change in self.designs.iter().flat_map(|design| &design.changes) {
            if !fields.contains(&change.field.as_str()) {
                fields.push(&change.field);
            }
        }
        fields
    }

    /// Whether replays have no error.
    pub(super) fn is_exact(&self) -> bool {
        EXACT.contains(&self.fidelity.as_str())
    }

    /// Whether the experiment has several machines.
    fn has_machines(&self) -> bool {
        self.designs.iter().any(|design| design.machine != self.designs[0].machine)
    }

    /// The designs of the front, the fastest first, each with its number.
    pub(crate) fn front(&self) -> Vec<(usize, &Design)> {
        let mut front: Vec<(usize, &Design)> =
            self.designs.iter().enumerate().filter(|(_, design)| design.front).collect();
        front.sort_by(|a, b| a.1.cycles.total_cmp(&b.1.cycles));
        front
    }

    /// The front as a table, at most `most` designs: figures, then the fields' values.
    pub(crate) fn front_grid(&self, most: usize) -> Grid {
        self.grid(&self.front()[..self.front().len().min(most)], false)
    }

    /// Designs as a table.
    pub(super) fn grid(&self, designs: &[(usize, &Design)], with_state: bool) -> Grid {
        let fields = self.fields();
        let mut head = vec!["design".to_owned(), "policy".into()];
        if self.has_machines() {
            head.push("machine".into());
        }
        let names = head.len();
        if with_state {
            head.push("figures are".into());
        }
        head.extend(["cycles", "DRAM bytes", "energy", "wrong pixels"].map(Into::into));
        head.extend(fields.iter().map(|field| field.replace(['.', '_'], " ")));
        let row = |(number, design): &(usize, &Design)| {
            let mut row = vec![format!("{}", number + 1), design.policy.clone()];
            if self.has_machines() {
                row.push(design.machine.clone());
            }
            if with_state {
                row.push(if design.replayed { "replayed".into() } else { "predicted".into() });
            }
            row.push(short(design.cycles));
            row.push(bytes(Bytes(design.dram_bytes.round() as u64)));
            row.push(or_absent(design.joules, joules));
            row.push(exact(design.wrong_pixels));
            row.extend(fields.iter().map(|field| or_absent(design.value(field), |value| shown(field, value))));
            row
        };
        Grid { head, names, rows: designs.iter().map(row).collect() }
    }

    /// The effect of each field on each figure, as a table: the value with the least figure and the value with the
    /// largest.
    pub(super) fn sensitivity_grid(&self) -> Grid {
        let head = ["field", "policy", "figure", "least with", "change", "most with", "change", "explains"];
        let signed = |change: f64| if change > 0.0 { format!("+{}", percent(change)) } else { percent(change) };
        let row = |it: &super::data::Sensitivity| {
            vec![
                it.field.clone(),
                it.policy.clone(),
                it.figure.replace('_', " "),
                shown(&it.field, &it.least.0),
                signed(it.least.1),
                shown(&it.field, &it.most.0),
                signed(it.most.1),
                percent(it.share),
            ]
        };
        Grid { head: head.map(Into::into).to_vec(), names: 3, rows: self.sensitivities.iter().map(row).collect() }
    }

    /// The accuracy of predictions, as a table.
    pub(crate) fn accuracy_grid(&self) -> Grid {
        let head =
            ["figure", "predictions", "how many", "median error", "90 % below", "largest", "within 3 %", "in interval"];
        let row = |figure: &str, of: &str, errors: &Errors| {
            let mut row = vec![figure.replace('_', " "), of.to_owned(), exact(errors.count)];
            let shares = [errors.median, errors.ninth, errors.most, errors.within, errors.holds];
            row.extend(shares.map(|share| if errors.count > 0 { percent(share) } else { or_absent(None, percent) }));
            row
        };
        let rows = |(figure, Accuracy { foreseen, left_out }): (&String, &Accuracy)| {
            [row(figure, "before a replay", foreseen), row(figure, "cross-validated", left_out)]
        };
        Grid { head: head.map(Into::into).to_vec(), names: 2, rows: self.accuracy.iter().flat_map(rows).collect() }
    }

    /// The result, in sentences.
    pub(crate) fn finding(&self) -> String {
        let front = self.front();
        let size = &self.size;
        let mut found = format!(
            "{} of {} replayed are unbeaten in cycles, DRAM bytes, energy and wrong pixels.",
            counted(front.len(), "design"),
            exact(size.replays),
        );
        if let Some(widest) = self.widest("cycles") {
            found += &format!(" {widest}.");
        }
        found += &match size.unsure {
            0 => " No other design may be on the front.".into(),
            count => format!(
                " {} more may be on the front and {} not replayed: a larger `budget` than {} tells.",
                counted(count as usize, "design"),
                if count == 1 { "was" } else { "were" },
                size.budget
            ),
        };
        found
    }

    /// The size of the space and the effort, in sentences.
    pub(crate) fn scope(&self) -> String {
        let size = &self.size;
        let mut told = format!(
            "{} of {} combinations, {}, {} and {} over streams.",
            counted(size.machines as usize, "machine"),
            short(size.combinations),
            counted(self.designs.len(), "design"),
            counted(size.replays as usize, "replay"),
            if size.passes == 1 { "1 pass".into() } else { format!("{} passes", size.passes) },
        );
        if let Some(why) = &size.why {
            told +=
                &format!(" {} drawn are no machines, such as: {why}.", counted(size.left_out as usize, "combination"));
        }
        told
    }

    /// The field that moves a figure most, in a sentence without a full stop.
    pub(super) fn widest(&self, figure: &str) -> Option<String> {
        let of = self.sensitivities.iter().filter(|it| it.figure == figure);
        let widest = of.max_by(|a, b| (a.most.1 - a.least.1).total_cmp(&(b.most.1 - b.least.1)))?;
        let signed = |change: f64| if change > 0.0 { format!("+{}", percent(change)) } else { percent(change) };
        Some(format!(
            "{} moves {} most: {} with {}, {} with {} ({})",
            widest.field,
            figure.replace("dram", "DRAM").replace("joules", "energy").replace('_', " "),
            signed(widest.least.1),
            shown(&widest.field, &widest.least.0),
            signed(widest.most.1),
            shown(&widest.field, &widest.most.0),
            widest.policy,
        ))
    }
}

impl Design {
    /// The design's value of a field; `None` if the machine lacks the field's unit.
    pub(super) fn value(&self, field: &str) -> Option<&str> {
        self.changes.iter().find(|change| change.field == field).map(|change| change.value.as_str())
    }
}
