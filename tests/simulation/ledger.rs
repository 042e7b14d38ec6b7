//! What a run was answered: facts that nothing may take back.

use std::collections::BTreeSet;

/// Something that a client was told.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Fact {
    /// A machine has this revision, whose profile has this name; none where a calibration made it.
    Machine { machine: String, revision: i64, name: Option<String> },
    /// A machine was deleted.
    MachineGone { machine: String },
    /// A tool of a machine has this revision with this number.
    Tool { machine: String, tool: String, revision: i64, number: i64 },
    /// It was deleted.
    ToolGone { machine: String, tool: String },
    /// A run of a calibration is stored.
    Calibration { id: String, note: String },
    /// Wear entries are stored, in this order.
    Wear { ids: Vec<String>, note: String },
    /// An entry was withdrawn.
    Withdrawn { id: String, at: String },
    /// A key allows this and no more.
    Key { id: String, name: String, scopes: String },
    /// It opens nothing any more.
    Revoked { id: String },
    /// Webhooks are signed with this.
    Secret { secret: String },
    /// A job is accepted.
    Job { id: String, name: String, input_sha256: String, told: bool },
    /// It has ended so.
    Ended { id: String, state: String, finished_at: String, output_sha256: Option<String> },
    /// It was cancelled, or will be.
    Cancelled { id: String },
    /// A program was answered at once; its job has these files.
    Answered { id: String, input_sha256: String },
    /// The end of a job was told and taken.
    Told { id: String },
    /// The end of a job is to be told once more.
    ToldAgain { id: String },
}

/// A request: what it is about, when it was sent, and when what was answered.
#[derive(Debug, Clone)]
pub(crate) struct Line {
    /// Names of what it may change.
    pub(crate) about: Vec<String>,
    /// How long the log was when it was sent first.
    pub(crate) sent: usize,
    /// How long it was when its answer came; none where none came.
    pub(crate) answered: Option<usize>,
    pub(crate) facts: Vec<Fact>,
    /// What the wall clock showed then \[ms since the beginning\].
    pub(crate) shown_ms: i64,
    /// What would repeat it, and the id that it must be answered with.
    pub(crate) repeat: Option<(crate::world::Ask, String)>,
}

/// Every request of a run.
#[derive(Debug, Clone, Default)]
pub(crate) struct Ledger {
    pub(crate) lines: Vec<Line>,
    /// The key that opens everything.
    pub(crate) admin: Option<String>,
    /// The wall clock at the end \[ms since the beginning\], and the next id.
    pub(crate) shown_ms: i64,
    pub(crate) next_id: u64,
    /// Whether the disk was ill while the run went on.
    pub(crate) ill: bool,
    /// How long the log was when a start was first allowed to forget old jobs, if ever.
    pub(crate) forgets_from: Option<usize>,
}

impl Ledger {
    /// What had been answered when the log was so long.
    pub(crate) fn facts_by(&self, length: usize) -> impl Iterator<Item = &Fact> {
        let told = self.lines.iter().filter(move |line| line.answered.is_some_and(|at| at <= length));
        told.flat_map(|line| &line.facts)
    }

    /// What was asked for by then and not answered: it may have happened or not.
    pub(crate) fn open_at(&self, length: usize) -> impl Iterator<Item = &Line> {
        let answered = move |line: &Line| line.answered.is_some_and(|at| at <= length);
        self.lines.iter().filter(move |line| line.sent < length.max(1) && !answered(line))
    }

    /// What the wall clock showed then \[ms since the beginning\].
    pub(crate) fn shown_ms_at(&self, length: usize) -> i64 {
        let sent = self.lines.iter().rev().find(|line| line.sent <= length);
        sent.map_or(0, |line| line.shown_ms)
    }

    /// Names of what may be in either state then.
    pub(crate) fn doubtful_at(&self, length: usize) -> BTreeSet<&str> {
        self.open_at(length).flat_map(|line| &line.about).map(String::as_str).collect()
    }
}
