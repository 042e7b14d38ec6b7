//! What there is to say about a program, with the place it is said of.

use std::fmt;

use thiserror::Error;

use super::Address;

/// A few bytes of the program, for messages. What is not printable ASCII shows as `?`.
#[derive(Clone, Copy, PartialEq, Eq)]
pub struct Excerpt {
    bytes: [u8; Self::MAX_BYTES],
    length: u8,
}

impl Excerpt {
    /// Longer texts are cut.
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

    /// As text.
    #[must_use]
    pub fn as_str(&self) -> &str {
        std::str::from_utf8(&self.bytes[..usize::from(self.length)]).unwrap_or_default()
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

/// What follows from a diagnostic.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// Something is left alone that could have been looked at.
    Warning,
    /// The program as a whole has to be refused.
    Refusal,
}

/// What is the matter.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum DiagnosticCode {
    /// The address has no number behind it.
    #[error("`{text}`: a word needs a number behind its letter")]
    MissingNumber {
        /// From the letter on.
        text: Excerpt,
    },
    /// A number with an exponent, of which controls of the dialect read the digits before it and a word E.
    #[error(
        "`{text}`: controls read no exponent behind E, and take the digits before it for the number; write the number without an exponent, and a blank before a word E"
    )]
    Exponent {
        /// From the letter of the number on.
        text: Excerpt,
    },
    /// Something that no block of the dialect contains.
    #[error("`{text}` is not part of a block")]
    UnexpectedText {
        /// From the first byte that does not fit.
        text: Excerpt,
    },
    /// A statement of the dialect that is not read: variables, functions.
    #[error(
        "`{text}`: statements with variables or functions are not read in this dialect; post the program with numbers in their place"
    )]
    StatementNotRead {
        /// From its first byte that is no word on.
        text: Excerpt,
    },
    /// A bracket or name that is never closed.
    #[error("`{text}` is not closed on its line")]
    Unclosed {
        /// From the opening byte on.
        text: Excerpt,
    },
    /// A comment with brackets in it, which some controls end before words that others take for a part of it.
    #[error(
        "`{text}`: some controls end this comment at its first `)` and run the words behind it; remove the brackets inside the comment"
    )]
    NestedComment {
        /// From its opening bracket on.
        text: Excerpt,
    },
    /// A division by zero, the root of a negative number and the like.
    #[error("`{text}` has no value: a division by zero or an argument that the function does not take")]
    Undefined {
        /// From its first operand or its name on.
        text: Excerpt,
    },
    /// A name before a bracket that no function has.
    #[error("`{text}` is not a function")]
    UnknownFunction {
        /// From the name on.
        text: Excerpt,
    },
    /// Too many brackets within each other.
    #[error("`{text}`: too many brackets within each other")]
    TooDeep {
        /// From the bracket on that is one too many.
        text: Excerpt,
    },
    /// A number no machine has use for.
    #[error("{address} {value:e} is beyond ±{max_abs:e}")]
    TooLarge {
        /// Of the word.
        address: Address,
        /// Its value in program units.
        value: f64,
        /// Largest magnitude read.
        max_abs: f64,
    },
    /// A line with more words than any block has.
    #[error("too many words on one line; at most {max} are read")]
    TooManyWords {
        /// Most words read.
        max: usize,
    },
    /// A CSV row with the wrong number of cells.
    #[error("the row has {cells} cells, the header {columns} columns")]
    CellCount {
        /// Cells in the row.
        cells: u32,
        /// Columns in the header.
        columns: u32,
    },
    /// A CSV cell that is not a number.
    #[error("column {column}: `{text}` is not a number")]
    CellNumber {
        /// Of the header.
        column: Address,
        /// What stands in the cell.
        text: Excerpt,
    },
    /// A contact normal that is no direction: perhaps a point.
    #[error("the contact normal has length {length}; 1 is wanted")]
    NotADirection {
        /// Its length.
        length: f64,
    },
    /// Control flow, whose effect on later blocks cannot be told.
    #[error("`{text}`: control flow is not followed")]
    ControlFlow {
        /// The statement.
        text: Excerpt,
    },
    /// Template text, which an editor would have to expand first.
    #[error("`{text}` is template text, not a program for a control")]
    TemplateText {
        /// The text.
        text: Excerpt,
    },
    /// A length before anybody said in which unit the program counts.
    #[error(
        "{address} is a length, and its unit is not known: give `unit` as mm or inch, state G20 or G21 (G70 or G71, `UNITS/`) in the program, or `program_unit` in the machine's profile"
    )]
    UnitUnknown {
        /// The first such word.
        address: Address,
    },
    /// A block states two units: which of the two holds behind it depends on the control.
    #[error(
        "G{} and G{} stand in one block, and controls differ in the unit that holds behind it: keep the one that is meant", codes[0], codes[1]
    )]
    TwoUnits {
        /// The numbers of the first and the last such code.
        codes: [u32; 2],
    },
    /// An address stands twice in one block.
    #[error("address {address} stands twice in the block")]
    RepeatedAddress {
        /// The address.
        address: Address,
    },
    /// A call: what it does cannot be seen.
    #[error("`{text}`: a call is not followed; modes and positions are unknown behind it")]
    Call {
        /// The statement.
        text: Excerpt,
    },
    /// A code whose meaning is not known.
    #[error("`{text}` is not a known code; modes and positions are unknown behind it")]
    UnknownCode {
        /// The word.
        text: Excerpt,
    },
}

impl DiagnosticCode {
    /// What follows from it.
    #[must_use]
    pub fn severity(&self) -> Severity {
        match self {
            Self::RepeatedAddress { .. } | Self::Call { .. } | Self::UnknownCode { .. } => Severity::Warning,
            _ => Severity::Refusal,
        }
    }

    /// A name that stays the same: the wire's `kind`.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self {
            Self::MissingNumber { .. } => "missing_number",
            Self::Exponent { .. } => "exponent",
            Self::UnexpectedText { .. } | Self::StatementNotRead { .. } => "unexpected_text",
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
            Self::ControlFlow { .. } => "control_flow",
            Self::TemplateText { .. } => "template_text",
            Self::UnitUnknown { .. } | Self::TwoUnits { .. } => "unit_unknown",
            Self::RepeatedAddress { .. } => "repeated_address",
            Self::Call { .. } => "call",
            Self::UnknownCode { .. } => "unknown_code",
        }
    }
}

/// Bytes of the upload, counted from 0, the end excluded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ByteSpan {
    /// First byte.
    pub start: u64,
    /// One past the last.
    pub end: u64,
}

/// A fact about one place of the program.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[error("line {line}, column {column}: {code}")]
pub struct Diagnostic {
    /// What is the matter.
    pub code: DiagnosticCode,
    /// 1-based line of the upload.
    pub line: u64,
    /// 1-based byte within the line.
    pub column: u32,
    /// The bytes meant.
    pub span: ByteSpan,
}

impl Diagnostic {
    /// What follows from it.
    #[must_use]
    pub fn severity(&self) -> Severity {
        self.code.severity()
    }
}

/// Diagnostics in the order of the text: the first hundred of each severity are kept, all are counted.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Diagnostics {
    kept: Vec<Diagnostic>,
    counts: [u64; 2],
}

impl Diagnostics {
    /// How many of each severity are kept.
    pub const MAX_KEPT: u64 = 100;

    /// None yet.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds one.
    pub fn push(&mut self, diagnostic: Diagnostic) {
        let count = &mut self.counts[diagnostic.severity() as usize];
        *count += 1;
        if *count <= Self::MAX_KEPT {
            self.kept.push(diagnostic);
        }
    }

    /// Adds all of these.
    pub fn extend(&mut self, diagnostics: impl IntoIterator<Item = Diagnostic>) {
        diagnostics.into_iter().for_each(|diagnostic| self.push(diagnostic));
    }

    /// Those kept, in the order of the text.
    #[must_use]
    pub fn kept(&self) -> &[Diagnostic] {
        &self.kept
    }

    /// How many there were of this severity, kept or not.
    #[must_use]
    pub fn count(&self, severity: Severity) -> u64 {
        self.counts[severity as usize]
    }

    /// The reasons to refuse the program that were kept; empty if there are none.
    pub fn refusals(&self) -> impl Iterator<Item = &Diagnostic> {
        self.kept.iter().filter(|diagnostic| diagnostic.severity() == Severity::Refusal)
    }
}
