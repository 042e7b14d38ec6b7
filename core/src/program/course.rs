//! What a statement does to the course of a program: which block runs after it. The words are the same for all
//! dialects. A dialect's `flow` file says how its text spells them.

/// Bytes of a block's text, counted from the block's first byte. The end is excluded.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Piece {
    pub(super) start: usize,
    pub(super) end: usize,
}

impl Piece {
    /// The bytes in the text of its block.
    pub(super) fn of(self, block: &[u8]) -> &[u8] {
        block.get(self.start..self.end).unwrap_or_default()
    }
}

/// The name of a place in a program, in upper case. The name of a block number begins with N.
pub(super) type PlaceName = Box<[u8]>;

/// The place name of a block number.
pub(super) fn block_number(number: f64) -> PlaceName {
    format!("N{number}").into_bytes().into()
}

/// The name of a file as a call writes it: without its path, in upper case.
pub(super) fn called_name(written: &[u8]) -> PlaceName {
    let name = written.rsplit(|byte| matches!(byte, b'/' | b'\\' | b':')).next().unwrap_or(written);
    name.trim_ascii().to_ascii_uppercase().into()
}

/// Where a jump looks for its target.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Search {
    Forward,
    Backward,
    /// Forward, then from the beginning of the program.
    Around,
}

/// When a jump takes place.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum When {
    Always,
    /// If the value of this text is not 0.
    Holds(Piece),
    /// If the two values compare in this way.
    Compares(Piece, Comparison, Piece),
}

/// How two values compare.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Comparison {
    Equal,
    Unequal,
    Greater,
    Less,
}

/// A structure of several statements, by the statement that opens or closes it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Structure {
    If,
    While,
    /// `DO … WHILE […]`
    Do,
    /// A number of times.
    Repeat,
    /// `REPEAT … UNTIL`
    Until,
    Loop,
    For,
    /// A subprogram in the text of the program that calls it.
    Sub,
}

/// What a call names.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Callee {
    /// A place in the same file.
    Place,
    /// A program in the same file, or a file.
    Program,
    /// A file.
    File,
}

/// What the end of a program does in a file that is called.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum EndInCall {
    /// It ends the caller too.
    EndsAll,
    /// It returns to the caller.
    Returns,
    /// It is not followed.
    NotFollowed,
}

/// What a statement does to the course.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Step {
    /// It is an ordinary block.
    Plain,
    /// It is an ordinary block that may end the program.
    End(EndInCall),
    /// It is an ordinary block at which a call may enter.
    Entry,
    /// It is the head of a program. In a file that is called it does nothing, if its name is that of the main
    /// program's head or it has none.
    Head,
    /// It is an ordinary block. A file that is called and has it is not followed.
    NotInCall,
    /// It is an ordinary block. In a subprogram with parameters of its own it is not followed.
    NotInSub,
    /// Nothing: the name of a place.
    Label,
    /// Opens a structure. `WHILE` has its condition, `REPEAT` its number of times.
    Open(Structure, Option<Piece>),
    /// Opens a loop that counts a variable up by 1.
    Count {
        variable: Piece,
        first: Piece,
        last: Piece,
    },
    /// Closes a structure; `None` closes every loop of its name. `UNTIL` has its condition.
    Close(Option<Structure>, Option<Piece>),
    /// `ELSEIF` with its condition, `ELSE` without.
    Else(Option<Piece>),
    Break,
    Continue,
    /// Leaves the subprogram. Without a call, it is an ordinary block.
    Return,
    /// The same, without a call nothing.
    ReturnIfCalled,
    /// Calls the subprogram of its name with these arguments and with parameters of its own.
    CallOwn(Vec<Piece>),
    /// Calls its name a number of times. The parameters are the caller's.
    Call(Callee, u32),
    /// Goes back to the place of its name a number of times.
    GoBack(u32),
    /// Jumps to the place of its name. If there is no such place, the program goes on if it `may_lack`.
    Jump {
        search: Search,
        when: When,
        may_lack: bool,
    },
    /// Jumps to the place whose value is that of the first text, or to the place without a value.
    Select {
        value: Piece,
        places: Vec<(Option<Piece>, Search, PlaceName)>,
    },
    /// Its effect is not followed.
    NotFollowed,
}

/// A statement: its step, the name of this place, and the name of the structure, the subprogram or the target.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Statement {
    pub(super) place: Option<PlaceName>,
    pub(super) name: Option<PlaceName>,
    pub(super) step: Step,
}

impl Statement {
    pub(super) const PLAIN: Self = Self::of(Step::Plain);
    pub(super) const NOT_FOLLOWED: Self = Self::of(Step::NotFollowed);

    pub(super) const fn of(step: Step) -> Self {
        Self { place: None, name: None, step }
    }

    pub(super) const fn named(name: PlaceName, step: Step) -> Self {
        Self { place: None, name: Some(name), step }
    }

    /// A place that calls and jumps can name.
    pub(super) const fn at(place: PlaceName, step: Step) -> Self {
        Self { place: Some(place), name: None, step }
    }
}
