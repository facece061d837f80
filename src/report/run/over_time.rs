//! What machines did over time: `over_time.csv`, and its rows as data.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use crate::input;
use crate::report::csv_table::CsvTable;
use crate::report::error::ReportError;
use crate::stats::{Cause, MachineStats};

/// The file's name.
const FILE: &str = "over_time.csv";
/// The largest file that is read, in bytes.
const MAX_BYTES: u64 = 1 << 28;
/// Columns before those of units.
const FIRST: [&str; 6] = ["machine", "policy", "frame", "begin", "cycles", "dram_bytes"];

/// A range of cycles of a frame.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(crate) struct Span {
    /// The frame.
    pub frame: u32,
    /// The first cycle, counted from the start of the frame.
    pub begin: u64,
    /// Number of cycles.
    pub cycles: u64,
    /// Bytes that the DRAM moved.
    pub dram_bytes: u64,
    /// Cycles of every kind of unit, summed over its instances, by cause.
    pub units: BTreeMap<String, BTreeMap<Cause, u64>>,
}

impl Span {
    /// The range of cycles in which `stats` was counted.
    pub(crate) fn new(frame: u32, begin: u64, stats: &MachineStats) -> Self {
        let (cycles, dram_bytes) = (stats.cycles.0, stats.moved("dram").0);
        Self { frame, begin, cycles, dram_bytes, units: stats.units.clone() }
    }

    /// Adds the cycles of the next span.
    fn extend(&mut self, next: &Self) {
        self.cycles += next.cycles;
        self.dram_bytes += next.dram_bytes;
        for (unit, causes) in &next.units {
            let all = self.units.entry(unit.clone()).or_default();
            causes.iter().for_each(|(&cause, cycles)| *all.entry(cause).or_default() += cycles);
        }
    }

    /// Joins consecutive spans into one; the default without any.
    pub(crate) fn joined(spans: &[Self]) -> Self {
        let mut joined = spans.first().cloned().unwrap_or_default();
        spans.iter().skip(1).for_each(|next| joined.extend(next));
        joined
    }

    /// The share of a kind of unit's cycles with a cause.
    pub(super) fn share(&self, unit: &str, cause: Cause) -> f64 {
        let Some(causes) = self.units.get(unit) else { return 0.0 };
        let whole: u64 = causes.values().sum();
        causes.get(&cause).map_or(0.0, |&cycles| cycles as f64 / whole.max(1) as f64)
    }
}

/// Spans by machine and policy, in chronological order.
pub(crate) type OverTime = BTreeMap<(String, String), Vec<Span>>;

/// The table of all spans.
pub(super) fn table(all: &OverTime) -> CsvTable {
    let units: BTreeSet<&String> = all.values().flatten().flat_map(|span| span.units.keys()).collect();
    let causes = units.iter().flat_map(|unit| Cause::ALL.map(|cause| format!("units.{unit}.{}", cause.name())));
    let head: Vec<String> = FIRST.map(String::from).into_iter().chain(causes).collect();
    let row = |(machine, policy): &(String, String), span: &Span| -> Vec<String> {
        let numbers = [span.frame.into(), span.begin, span.cycles, span.dram_bytes].map(|it| it.to_string());
        let cycles = units.iter().flat_map(|&unit| {
            let causes = span.units.get(unit);
            Cause::ALL.map(|cause| causes.and_then(|it| it.get(&cause)).map_or_else(String::new, u64::to_string))
        });
        [machine.clone(), policy.clone()].into_iter().chain(numbers).chain(cycles).collect()
    };
    let rows = all.iter().flat_map(|(of, spans)| spans.iter().map(move |span| (of, span)));
    CsvTable::new(FILE, head.iter().map(String::as_str), rows.map(|(of, span)| row(of, span)).collect())
}

/// Reads the spans of the report in `folder`; empty if it has no such file.
///
/// # Errors
/// The file cannot be read, or is no table of spans.
pub(super) fn read(folder: &Path) -> Result<OverTime, ReportError> {
    let path = folder.join(FILE);
    if !path.exists() {
        return Ok(OverTime::new());
    }
    let text = match input::read(&path, MAX_BYTES) {
        Ok(text) => text,
        Err(source) => return Err(ReportError::Read { path, source }),
    };
    parse(&text).map_err(|source| ReportError::BrokenTable { path, source })
}

fn parse(text: &[u8]) -> Result<OverTime, csv::Error> {
    let (mut all, mut sum) = (OverTime::new(), 0u64);
    for row in csv::Reader::from_reader(text).deserialize() {
        let mut row: BTreeMap<String, String> = row?;
        if let Some(column) = FIRST.iter().find(|column| !row.contains_key(**column)) {
            return Err(broken(format!("there is no column `{column}`")));
        }
        let mut name = |column: &str| row.remove(column).unwrap_or_default();
        let of = (name("machine"), name("policy"));
        let mut span = Span::default();
        for (column, text) in row.iter().filter(|(_, text)| !text.is_empty()) {
            let not_a_count = || broken(format!("column {column}: `{text}` is no count"));
            let number: u64 = text.parse().map_err(|_| not_a_count())?;
            // Checked here for all counts of the file together, so that no later sum can overflow.
            sum = sum.checked_add(number).ok_or_else(not_a_count)?;
            match column.as_str() {
                "frame" => span.frame = u32::try_from(number).map_err(|_| not_a_count())?,
                "begin" => span.begin = number,
                "cycles" => span.cycles = number,
                "dram_bytes" => span.dram_bytes = number,
                unit => {
                    let words = unit.strip_prefix("units.").and_then(|unit| unit.rsplit_once('.'));
                    let cause = |name: &str| Cause::ALL.into_iter().find(|cause| cause.name() == name);
                    let Some((unit, cause)) = words.and_then(|(unit, name)| Some((unit, cause(name)?))) else {
                        return Err(broken(format!("column `{column}` is none of this table's")));
                    };
                    span.units.entry(unit.to_owned()).or_default().insert(cause, number);
                }
            }
        }
        all.entry(of).or_default().push(span);
    }
    Ok(all)
}

fn broken(why: String) -> csv::Error {
    std::io::Error::new(std::io::ErrorKind::InvalidData, why).into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spans_survive_their_file_and_are_joined() {
        let units = |busy: u64| BTreeMap::from([("list".to_owned(), BTreeMap::from([(Cause::Busy, busy)]))]);
        let span = |begin, busy| Span { frame: 3, begin, cycles: 10, dram_bytes: 64, units: units(busy) };
        let all = OverTime::from([(("a, b".into(), "off".into()), vec![span(0, 4), span(10, 6)])]);
        let table = table(&all);
        let read = parse(&table.bytes().unwrap()).unwrap();
        assert_eq!(read, all);
        assert_eq!(Span::joined(&[span(0, 4), span(10, 6)]), Span { cycles: 20, dram_bytes: 128, ..span(0, 10) });
    }

    #[test]
    fn what_is_no_table_of_spans_is_told() {
        let refused = |more: &str, row: &str| {
            let text = format!("machine,policy,frame,begin,cycles,dram_bytes{more}\n{row}\n");
            parse(text.as_bytes()).unwrap_err().to_string()
        };
        assert_eq!(refused("", "a,b,x,0,1,2"), "column frame: `x` is no count");
        assert_eq!(refused("", "a,b,4294967296,0,1,2"), "column frame: `4294967296` is no count");
        assert_eq!(refused(",units.list.bored", "a,b,0,0,1,2,3"), "column `units.list.bored` is none of this table's");
        let most = u64::MAX;
        assert_eq!(refused("", &format!("a,b,0,0,{most},{most}")), format!("column dram_bytes: `{most}` is no count"));
        let without = parse(b"machine,policy,frame\na,b,1\n").unwrap_err().to_string();
        assert_eq!(without, "there is no column `begin`");
    }
}
