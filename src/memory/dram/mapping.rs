//! The mapping from lines to places in the DRAM.

use std::fmt;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::part::DramPart;
use crate::quantity::LineAddr;

/// A field of the address mapping.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum Field {
    /// This many bits of the channel.
    Channel(u32),
    /// This many bits of the bank group.
    BankGroup(u32),
    /// This many bits of the bank in its group.
    Bank(u32),
    /// This many bits of the line's column in its row.
    Column(u32),
    /// All remaining upper bits: the row. It must be the last field.
    Row,
}

/// The fields of a line number, from the least significant bit upwards.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(transparent)]
pub struct Mapping(pub Vec<Field>);

/// The format of the files: `Column(1) Bank(3) Column(4) Row`.
impl fmt::Display for Mapping {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, field) in self.0.iter().enumerate() {
            write!(f, "{}{field:?}", if index > 0 { " " } else { "" })?;
        }
        Ok(())
    }
}

/// The place of a line.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Place {
    /// The channel.
    pub channel: usize,
    /// The bank in its channel, numbered across bank groups.
    pub bank: usize,
    /// The row of the bank.
    pub row: u64,
    /// Index of the line in the row.
    pub column: u64,
}

impl Mapping {
    /// Checks that the bits fit `channels` of `part`, with lines of `line` bytes.
    pub(super) fn check(&self, channels: u64, part: &DramPart, line: u64) -> Result<(), String> {
        let (mut channel, mut group, mut bank, mut column) = (0, 0, 0, 0);
        for (index, &field) in self.0.iter().enumerate() {
            let sum = match field {
                Field::Channel(bits) => (&mut channel, bits),
                Field::BankGroup(bits) => (&mut group, bits),
                Field::Bank(bits) => (&mut bank, bits),
                Field::Column(bits) => (&mut column, bits),
                Field::Row if index + 1 == self.0.len() => continue,
                Field::Row => {
                    return Err("`dram.mapping` has `Row` before its end: it is allowed as the last field only".into());
                }
            };
            *sum.0 = u32::checked_add(*sum.0, sum.1).ok_or("`dram.mapping` has too many bits")?;
        }
        if self.0.last() != Some(&Field::Row) {
            return Err("`dram.mapping` does not end with `Row`: it must".into());
        }
        let needs = [
            ("Channel", channel, channels, "channels"),
            ("BankGroup", group, part.bank_groups.get(), "bank groups"),
            ("Bank", bank, part.banks.get() / part.bank_groups.get(), "banks a group"),
            ("Column", column, part.row_bytes.get() / line, "lines a row"),
        ];
        for (name, bits, count, what) in needs {
            let right = count.trailing_zeros();
            if bits != right {
                return Err(format!(
                    "`dram.mapping` has {bits} bit(s) of `{name}`: it needs {right}, for {count} {what}"
                ));
            }
        }
        Ok(())
    }

    /// The place of `line` in channels of `part`.
    pub fn place(&self, part: &DramPart, line: LineAddr) -> Place {
        let mut rest = line.0;
        // Channel, group, bank, column: each the value so far and its number of bits.
        let mut parts = [(0u64, 0u32); 4];
        for &field in &self.0 {
            let (index, bits) = match field {
                Field::Channel(bits) => (0, bits),
                Field::BankGroup(bits) => (1, bits),
                Field::Bank(bits) => (2, bits),
                Field::Column(bits) => (3, bits),
                Field::Row => continue,
            };
            let (value, have) = &mut parts[index];
            *value |= (rest & ((1 << bits) - 1)) << *have;
            *have += bits;
            rest >>= bits;
        }
        let [(channel, _), (group, _), (bank, _), (column, _)] = parts;
        let in_group = part.banks.get() / part.bank_groups.get();
        Place { channel: channel as usize, bank: (group * in_group + bank) as usize, row: rest, column }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ranged::PowerOfTwo;

    #[test]
    fn every_line_has_its_own_place() {
        let part = DramPart { bank_groups: PowerOfTwo::new(2).unwrap(), ..DramPart::default() };
        let mapping = Mapping(vec![
            Field::Column(2),
            Field::BankGroup(1),
            Field::Channel(1),
            Field::Bank(2),
            Field::Channel(1),
            Field::Column(3),
            Field::Row,
        ]);
        mapping.check(4, &part, 64).unwrap();
        let mut seen = std::collections::BTreeSet::new();
        for line in 0..4096 {
            let Place { channel, bank, row, column } = mapping.place(&part, LineAddr(line));
            assert!(channel < 4 && bank < 8 && row < 4 && column < 32);
            assert_eq!(part.group(bank) as u64, line >> 2 & 1);
            seen.insert((channel, bank, row, column));
        }
        assert_eq!(seen.len(), 4096);
        assert_eq!(mapping.to_string(), "Column(2) BankGroup(1) Channel(1) Bank(2) Channel(1) Column(3) Row");
    }
}
