//! Checks the commands of a DRAM channel against the timing of its part. The table of rules is independent of the
//! engines. It checks the logs of both engines and of users' runs.

use super::command::{Column, Command, LoggedCommand};
use super::part::DramPart;
use super::spec::{DramSpec, Page};

/// Kinds of commands that rules constrain.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Activate,
    Read,
    Write,
    Precharge,
    Refresh,
}

/// The moment of an event from which a rule counts clocks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Moment {
    Command,
    DataEnd,
}

/// The pairs of banks that a rule holds for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Scope {
    Bank,
    Group,
    OtherGroup,
    Channel,
}

/// At least `clocks` clocks lie between `first` and `then`.
#[derive(Clone, Copy, Debug)]
struct Rule {
    name: &'static str,
    first: Kind,
    from: Moment,
    then: Kind,
    scope: Scope,
    clocks: u64,
}

fn table(part: &DramPart) -> Vec<Rule> {
    use Kind::{Activate, Precharge, Read, Refresh, Write};
    use Moment::{Command, DataEnd};
    use Scope::{Bank, Channel, Group, OtherGroup};
    let t = &part.timing;
    let mut rules = vec![
        ("rc", Activate, Command, Activate, Bank, t.rc.get()),
        ("rrd_l", Activate, Command, Activate, Group, t.rrd_l.get()),
        ("rrd_s", Activate, Command, Activate, OtherGroup, t.rrd_s.get()),
        ("rp", Precharge, Command, Activate, Bank, t.rp.get()),
        ("rcd", Activate, Command, Read, Bank, t.rcd.get()),
        ("rcd", Activate, Command, Write, Bank, t.rcd.get()),
        ("ras", Activate, Command, Precharge, Bank, t.ras.get()),
        ("rtp", Read, Command, Precharge, Bank, t.rtp.get()),
        ("wr", Write, DataEnd, Precharge, Bank, t.wr.get()),
        ("wtr_l", Write, DataEnd, Read, Group, t.wtr_l.get()),
        ("wtr_s", Write, DataEnd, Read, OtherGroup, t.wtr_s.get()),
        ("rfc", Refresh, Command, Activate, Channel, t.rfc.get()),
        ("rfc", Refresh, Command, Refresh, Channel, t.rfc.get()),
        ("rp", Precharge, Command, Refresh, Channel, t.rp.get()),
        ("rc", Activate, Command, Refresh, Channel, t.rc.get()),
    ];
    for (first, then) in [(Read, Read), (Read, Write), (Write, Read), (Write, Write)] {
        rules.push(("ccd_l", first, Command, then, Group, t.ccd_l.get()));
        rules.push(("ccd_s", first, Command, then, OtherGroup, t.ccd_s.get()));
    }
    let rule = |(name, first, from, then, scope, clocks)| Rule { name, first, from, then, scope, clocks };
    rules.into_iter().map(rule).collect()
}

/// A violated constraint.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("clock {clock}: `{rule}` is violated{}", from(.legal_at))]
pub struct Violation {
    /// The clock of the command.
    pub clock: u64,
    /// The violated rule: a timing parameter, or `bus`, `state`, `command`.
    pub rule: &'static str,
    /// The first clock in which the rule allows the command; `None` if waiting does not help.
    pub legal_at: Option<u64>,
}

fn from(legal_at: &Option<u64>) -> String {
    legal_at.map_or_else(String::new, |at| format!(", which allows it from clock {at} on"))
}

#[derive(Clone, Copy, Debug)]
struct Event {
    kind: Kind,
    bank: Option<usize>,
    clock: u64,
    data_end: u64,
}

/// Checks the commands of one channel as they come.
#[derive(Clone, Debug)]
pub(crate) struct TimingChecker {
    part: DramPart,
    page: Page,
    bursts: u64,
    rules: Vec<Rule>,
    /// The last event of each kind and bank.
    last: Vec<Event>,
    /// Open rows.
    open: Vec<Option<u64>>,
    bus_free: u64,
    reads_last: bool,
    /// The clocks of the last four activates, oldest first.
    activates: Vec<u64>,
    refreshes: u64,
    last_command: Option<u64>,
    found: Vec<Violation>,
}

impl TimingChecker {
    /// A checker for a channel with lines of `line` bytes that has had no command.
    pub(crate) fn new(spec: &DramSpec, line: u64) -> Self {
        Self {
            page: spec.page,
            bursts: line / spec.part.burst_bytes.get(),
            rules: table(&spec.part),
            last: Vec::new(),
            open: vec![None; spec.part.banks.size()],
            bus_free: 0,
            reads_last: false,
            activates: Vec::new(),
            refreshes: 0,
            last_command: None,
            found: Vec::new(),
            part: spec.part.clone(),
        }
    }

    /// Checks the next command; the error is its first violation.
    pub(crate) fn check(&mut self, command: LoggedCommand) -> Result<(), Violation> {
        self.command(command);
        self.found.first().map_or(Ok(()), |&violation| Err(violation))
    }

    /// Ends the run after clock `clock`; an error if a refresh is missing by then.
    pub(crate) fn finish(mut self, clock: u64) -> Result<(), Violation> {
        self.end(clock);
        self.found.first().map_or(Ok(()), |&violation| Err(violation))
    }

    fn due(&self) -> u64 {
        (self.refreshes + 1) * self.part.timing.refi.get()
    }

    fn violated(&mut self, clock: u64, rule: &'static str, legal_at: Option<u64>) {
        self.found.push(Violation { clock, rule, legal_at });
    }

    /// Whether a scope covers an earlier event in bank `before` and a command to `bank`.
    fn applies(&self, scope: Scope, before: Option<usize>, bank: Option<usize>) -> bool {
        let (Some(before), Some(bank)) = (before, bank) else { return true };
        let in_group = self.part.banks.size() / self.part.bank_groups.size();
        match scope {
            Scope::Channel => true,
            Scope::Bank => before == bank,
            Scope::Group => before / in_group == bank / in_group,
            Scope::OtherGroup => before / in_group != bank / in_group,
        }
    }

    /// The first clock in which each rule allows `kind` in `bank`, given the past events.
    fn earliest(&self, kind: Kind, bank: Option<usize>) -> impl Iterator<Item = (&'static str, u64)> {
        self.rules.iter().filter(move |rule| rule.then == kind).flat_map(move |rule| {
            let events = self.last.iter().filter(|event| event.kind == rule.first);
            let events = events.filter(move |event| self.applies(rule.scope, event.bank, bank));
            events.map(|event| {
                let from = if rule.from == Moment::DataEnd { event.data_end } else { event.clock };
                (rule.name, from + rule.clocks)
            })
        })
    }

    fn event(&mut self, kind: Kind, bank: Option<usize>, clock: u64) {
        let mut broken: Vec<_> = self.earliest(kind, bank).filter(|&(_, at)| clock < at).collect();
        broken.dedup();
        broken.into_iter().for_each(|(rule, at)| self.violated(clock, rule, Some(at)));
        let data_end = match kind {
            Kind::Read => self.data(clock, self.part.timing.cl.get(), false),
            Kind::Write => self.data(clock, self.part.timing.cwl.get(), true),
            Kind::Activate | Kind::Precharge | Kind::Refresh => clock,
        };
        self.happened(Event { kind, bank, clock, data_end });
    }

    fn happened(&mut self, event: Event) {
        self.last.retain(|other| other.kind != event.kind || other.bank != event.bank);
        self.last.push(event);
    }

    /// Puts a burst on the bus; returns the clock in which its data ends.
    fn data(&mut self, clock: u64, latency: u64, write: bool) -> u64 {
        let turn = if write && self.reads_last { self.part.timing.turn.get() } else { 0 };
        self.reads_last = !write;
        let free = self.bus_free + turn;
        if clock + latency < free {
            self.violated(clock, "bus", Some(free - latency));
        }
        self.bus_free = clock + latency + self.part.burst_clocks.get();
        self.bus_free
    }

    fn command(&mut self, LoggedCommand { clock, command }: LoggedCommand) {
        if let Some(before) = self.last_command.filter(|&before| before >= clock) {
            self.violated(clock, "command", Some(before + 1));
        }
        self.last_command = Some(clock);
        if clock >= self.due() && !matches!(command, Command::PrechargeAll | Command::Refresh) {
            self.violated(clock, "refi", None);
        }
        let legal_state = match command {
            Command::Activate { bank, .. } => self.open[bank].is_none(),
            Command::Read(column) | Command::Write(column) => self.column_fits(&column),
            Command::Precharge { bank } => self.open[bank].is_some(),
            Command::PrechargeAll => self.open.iter().any(Option::is_some),
            Command::Refresh => self.open.iter().all(Option::is_none) && clock >= self.due(),
        };
        if !legal_state {
            self.violated(clock, "state", None);
        }
        match command {
            Command::Activate { bank, row } => {
                self.event(Kind::Activate, Some(bank), clock);
                if let &[fourth_last, _, _, _] = self.activates.as_slice() {
                    let at = fourth_last + self.part.timing.faw.get();
                    if clock < at {
                        self.violated(clock, "faw", Some(at));
                    }
                    self.activates.remove(0);
                }
                self.activates.push(clock);
                self.open[bank] = Some(row);
            }
            Command::Read(column) => self.column(Kind::Read, &column, clock),
            Command::Write(column) => self.column(Kind::Write, &column, clock),
            Command::Precharge { bank } => self.close(bank, clock),
            Command::PrechargeAll => {
                let open: Vec<_> = (0..self.open.len()).filter(|&bank| self.open[bank].is_some()).collect();
                open.into_iter().for_each(|bank| self.close(bank, clock));
            }
            Command::Refresh => {
                self.event(Kind::Refresh, None, clock);
                self.refreshes += 1;
            }
        }
    }

    /// Whether the row is open and holds the burst, and auto-precharge is set exactly where the page policy requires
    /// it.
    fn column_fits(&self, column: &Column) -> bool {
        let last_of_line = column.column % self.bursts == self.bursts - 1;
        self.open[column.bank] == Some(column.row)
            && column.column < self.part.row_bytes.get() / self.part.burst_bytes.get()
            && column.auto_precharge == (last_of_line && self.page == Page::Closed)
    }

    fn column(&mut self, kind: Kind, column: &Column, clock: u64) {
        let bank = Some(column.bank);
        self.event(kind, bank, clock);
        if column.auto_precharge {
            let by_itself = self.earliest(Kind::Precharge, bank).map(|(_, at)| at).max().unwrap_or(clock).max(clock);
            self.happened(Event { kind: Kind::Precharge, bank, clock: by_itself, data_end: by_itself });
            self.open[column.bank] = None;
        }
    }

    fn close(&mut self, bank: usize, clock: u64) {
        self.event(Kind::Precharge, Some(bank), clock);
        self.open[bank] = None;
    }

    /// A refresh can be late by at most the time to close all rows.
    fn end(&mut self, clock: u64) {
        let t = &self.part.timing;
        let data = t.cwl.get() + self.part.burst_clocks.get() + t.wr.get();
        let late = t.ras.get().max(t.rtp.get()).max(data) + t.rc.get().max(t.rp.get()) + 2;
        if self.due() + late < clock {
            self.violated(clock, "refi", None);
        }
    }
}

/// All violations in a channel's log of a run up to clock `end`, with lines of `line` bytes.
#[cfg(test)]
pub(crate) fn violations(spec: &DramSpec, line: u64, commands: &[LoggedCommand], end: u64) -> Vec<Violation> {
    let mut checker = TimingChecker::new(spec, line);
    commands.iter().for_each(|&command| checker.command(command));
    checker.end(end);
    checker.found
}
