//! Diagnostics of a program, each with its place in the text.

use std::fmt;

use thiserror::Error;

use crate::units::legible;

use super::Address;

/// A few bytes of the program, for messages. A byte that is not printable ASCII is shown as `?`.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct Excerpt {
    bytes: [u8; Self::MAX_BYTES],
    length: u8,
}

impl Excerpt {
    /// A longer text is cut.
    pub const MAX_BYTES: usize = 23;

    /// The beginning of `text`, up to its line end.
    #[must_use]
    pub fn new(text: &[u8]) -> Self {
        let mut excerpt = Self { bytes: [0; Self::MAX_BYTES], length: 0 };
        for (slot, byte) in excerpt.bytes.iter_mut().zip(text) {
            if matches!(byte, b'\r' | b'\n') {
                break;
            }
            *slot = if (b' '..=b'~').contains(byte) { *byte } else { b'?' };
            excerpt.length += 1;
        }
        excerpt
    }

    /// The excerpt as text.
    #[must_use]
    pub fn as_str(&self) -> &str {
        std::str::from_utf8(&self.bytes[..usize::from(self.length)]).unwrap_or_default()
    }
}

impl Default for Excerpt {
    fn default() -> Self {
        Self::new(&[])
    }
}

impl fmt::Display for Excerpt {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.as_str().trim_end())
    }
}

impl fmt::Debug for Excerpt {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:?}", self.as_str())
    }
}

/// The consequence of a diagnostic.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// A part of the program is left unchanged that could otherwise be checked.
    Warning,
    /// The service refuses the whole program.
    Refusal,
}

/// The fact that a diagnostic states.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum DiagnosticCode {
    /// The letter has no number after it.
    #[error("`{text}`: a word needs a number after its letter; add the number or remove the letter")]
    MissingNumber {
        /// From the letter on.
        text: Excerpt,
    },
    /// A number with an exponent. Controls of the dialect read only the digits before the exponent, and then a word E.
    #[error(
        "`{text}`: controls read no exponent after E and take only the digits before E as the number; write the number without an exponent, and put a blank before a word E"
    )]
    Exponent {
        /// From the letter of the number on.
        text: Excerpt,
    },
    /// Text that is not valid at its place in a block of the dialect.
    #[error("`{text}` is not valid at this place in a block; correct or remove the text")]
    UnexpectedText {
        /// From the first byte that does not fit.
        text: Excerpt,
    },
    /// A statement of the dialect that is not read: variables, functions.
    #[error(
        "`{text}`: statements with variables or functions are not read in this dialect; post the program with numbers in their place"
    )]
    StatementNotRead {
        /// From the first byte that is not part of a word on.
        text: Excerpt,
    },
    /// A line of an OSP program that continues the block before it.
    #[error(
        "`{text}`: a line that begins with `$` continues the block before it; write each block on one line"
    )]
    LineContinues {
        /// The line.
        text: Excerpt,
    },
    /// A bracket or a name that is never closed.
    #[error("`{text}` is not closed on its line; add the closing bracket or quotation mark")]
    Unclosed {
        /// From the opening byte on.
        text: Excerpt,
    },
    /// A comment with brackets in it. Some controls end it before words that others take as a part of it.
    #[error(
        "`{text}`: some controls end this comment at its first `)` and run the words after it; remove the brackets inside the comment"
    )]
    NestedComment {
        /// From its opening bracket on.
        text: Excerpt,
    },
    /// A division by zero, the root of a negative number or a similar operation.
    #[error(
        "`{text}` has no value: it divides by zero or gives a function an argument that it does not take; correct the expression"
    )]
    Undefined {
        /// From its first operand or its name on.
        text: Excerpt,
    },
    /// The name before a bracket is not a function.
    #[error("`{text}` is not a function; correct the name or write a number")]
    UnknownFunction {
        /// From the name on.
        text: Excerpt,
    },
    /// More nested brackets, signs or parameters than are read.
    #[error(
        "`{text}`: the expression has more than {max} nested brackets, signs or parameters; divide it into several statements"
    )]
    TooDeep {
        /// From the first bracket that is too deep on.
        text: Excerpt,
        /// The largest depth that is read.
        max: u32,
    },
    /// A number that is too large for any machine.
    #[error("{address} {} is outside ±{max_abs:e}; correct the number", legible(.value))]
    TooLarge {
        /// Address of the word.
        address: Address,
        /// Value of the word, in program units.
        value: f64,
        /// The largest magnitude that is read.
        max_abs: f64,
    },
    /// A line with more words than any block has.
    #[error("the line has more than {max} words; divide it into several blocks")]
    TooManyWords {
        /// The largest number of words that are read.
        max: usize,
    },
    /// A CSV row with the wrong number of cells.
    #[error(
        "the row has {cells} cells, but the header has {columns} columns; write one cell for each column"
    )]
    CellCount {
        /// Cells in the row.
        cells: u32,
        /// Columns in the header.
        columns: u32,
    },
    /// A CSV cell that is not a number.
    #[error("column {column}: `{text}` is not a number; write a decimal number")]
    CellNumber {
        /// Address of the column in the header.
        column: Address,
        /// The text in the cell.
        text: Excerpt,
    },
    /// The contact normal is not a direction. Perhaps its numbers are a point.
    #[error("the contact normal has length {length}, but a unit vector has length 1; give a unit vector")]
    NotADirection {
        /// Length of the normal.
        length: f64,
    },
    /// Control flow. Its effect on later blocks is not known.
    #[error(
        "`{text}`: the service does not follow control flow here; send `flatten` with a compensation, or post the program without jumps, loops, conditions and subprograms"
    )]
    ControlFlow {
        /// The statement.
        text: Excerpt,
    },
    /// The program runs more blocks than are followed. Most likely it never ends.
    #[error(
        "`{text}`: the program has run {max} blocks and statements when it comes here; correct the loop that does not end, or divide the program"
    )]
    RunsTooLong {
        /// The statement that was next.
        text: Excerpt,
        /// The most blocks and statements that are run.
        max: u64,
    },
    /// More calls inside each other than are followed.
    #[error(
        "`{text}`: this is call {} inside calls, and {max} are followed; a subprogram must not call itself", max + 1
    )]
    CallsTooDeep {
        /// The call.
        text: Excerpt,
        /// The most calls inside each other.
        max: usize,
    },
    /// A block of a loop or a call that cannot be written out.
    #[error("`{text}` cannot be written out: {reason}")]
    NotWrittenOut {
        /// The block.
        text: Excerpt,
        /// The reason, and what to do.
        reason: &'static str,
    },
    /// A called file ends, and nothing leads back to its caller.
    #[error(
        "`{text}`: the called file ends here without a return; end the subprogram with M99, ENDSUB or END PGM"
    )]
    NoReturn {
        /// Its last block.
        text: Excerpt,
    },
    /// Template text, which an editor would have to expand first.
    #[error("`{text}` is template text, not a program for a control; expand the template first")]
    TemplateText {
        /// The text.
        text: Excerpt,
    },
    /// A length before the unit of the program is known.
    #[error(
        "{address} is a length, and its unit is not known: give `unit` as mm or inch, state G20 or G21 (G70 or G71, `UNITS/`) in the program, or `program_unit` in the machine's profile"
    )]
    UnitUnknown {
        /// The first such word.
        address: Address,
    },
    /// A block states two units. It depends on the control which of the two holds after the block.
    #[error(
        "G{} and G{} are in one block, and controls differ in the unit that holds after it; keep only the code that is meant", codes[0], codes[1]
    )]
    TwoUnits {
        /// The numbers of the first and the last such code.
        codes: [u32; 2],
    },
    /// A block has the same address twice.
    #[error("the block has address {address} twice; keep only the word that is meant")]
    RepeatedAddress {
        /// The address.
        address: Address,
    },
    /// A call. Its effect is not visible in the text.
    #[error(
        "`{text}`: the service does not follow calls; after this call, modes and positions are unknown until the program states them"
    )]
    Call {
        /// The statement.
        text: Excerpt,
    },
    /// A code with an unknown meaning.
    #[error(
        "`{text}` is not a known code; after this code, modes and positions are unknown until the program states them"
    )]
    UnknownCode {
        /// The word.
        text: Excerpt,
    },
}

impl DiagnosticCode {
    /// The severity of the diagnostic.
    #[must_use]
    pub fn severity(&self) -> Severity {
        match self {
            Self::RepeatedAddress { .. } | Self::Call { .. } | Self::UnknownCode { .. } => Severity::Warning,
            _ => Severity::Refusal,
        }
    }

    /// The wire's `kind`: a name that always stays the same.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self {
            Self::MissingNumber { .. } => "missing_number",
            Self::Exponent { .. } => "exponent",
            Self::UnexpectedText { .. } | Self::StatementNotRead { .. } | Self::LineContinues { .. } => {
                "unexpected_text"
            }
            Self::Unclosed { .. } => "unclosed",
            Self::NestedComment { .. } => "nested_comment",
            Self::Undefined { .. } => "undefined_value",
            Self::UnknownFunction { .. } => "unknown_function",
            Self::TooDeep { .. } => "too_deep",
            Self::TooLarge { .. } => "too_large",
            Self::TooManyWords { .. } => "too_many_words",
            Self::CellCount { .. } => "cell_count",
            Self::CellNumber { .. } => "cell_number",
            Self::NotADirection { .. } => "not_a_direction",
            Self::ControlFlow { .. }
            | Self::RunsTooLong { .. }
            | Self::CallsTooDeep { .. }
            | Self::NoReturn { .. }
            | Self::NotWrittenOut { .. } => "control_flow",
            Self::TemplateText { .. } => "template_text",
            Self::UnitUnknown { .. } | Self::TwoUnits { .. } => "unit_unknown",
            Self::RepeatedAddress { .. } => "repeated_address",
            Self::Call { .. } => "call",
            Self::UnknownCode { .. } => "unknown_code",
        }
    }
}

/// Bytes of the upload, counted from 0. The end is excluded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ByteSpan {
    /// First byte.
    pub start: u64,
    /// One after the last byte.
    pub end: u64,
}

/// A line of a called file, as messages print it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct CalledLine {
    /// The beginning of the file's name.
    pub file: Excerpt,
    /// Its line, counted from 1.
    pub line: u32,
}

/// A fact about one place of the program.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[error("line {line}{}, column {column}: {code}", called_place(*called))]
pub struct Diagnostic {
    /// The fact.
    pub code: DiagnosticCode,
    /// 1-based line of the upload. For a place in a called file, the line of the call.
    pub line: u64,
    /// The called file and the line in it; `None` in the main program.
    pub called: Option<CalledLine>,
    /// 1-based byte within the line.
    pub column: u32,
    /// The bytes that the diagnostic is about.
    pub span: ByteSpan,
}

fn called_place(called: Option<CalledLine>) -> String {
    called
        .map_or_else(String::new, |CalledLine { file, line }| format!(" (called file `{file}`, line {line})"))
}

impl Diagnostic {
    /// The severity of the diagnostic.
    #[must_use]
    pub fn severity(&self) -> Severity {
        self.code.severity()
    }
}

/// Diagnostics in the order of the text. The first hundred of each severity are kept, and all are counted.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Diagnostics {
    kept: Vec<Diagnostic>,
    counts: [u64; 2],
}

impl Diagnostics {
    /// The number of diagnostics of each severity that are kept.
    pub const MAX_KEPT: u64 = 100;

    /// An empty list.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds a diagnostic.
    pub fn push(&mut self, diagnostic: Diagnostic) {
        let count = &mut self.counts[diagnostic.severity() as usize];
        *count += 1;
        if *count <= Self::MAX_KEPT {
            self.kept.push(diagnostic);
        }
    }

    /// Adds all of these diagnostics.
    pub fn extend(&mut self, diagnostics: impl IntoIterator<Item = Diagnostic>) {
        diagnostics.into_iter().for_each(|diagnostic| self.push(diagnostic));
    }

    /// The kept diagnostics, in the order of the text.
    #[must_use]
    pub fn kept(&self) -> &[Diagnostic] {
        &self.kept
    }

    /// The number of diagnostics of this severity, kept or not.
    #[must_use]
    pub fn count(&self, severity: Severity) -> u64 {
        self.counts[severity as usize]
    }

    /// The kept diagnostics that refuse the program; empty if there are none.
    pub fn refusals(&self) -> impl Iterator<Item = &Diagnostic> {
        self.kept.iter().filter(|diagnostic| diagnostic.severity() == Severity::Refusal)
    }
}
