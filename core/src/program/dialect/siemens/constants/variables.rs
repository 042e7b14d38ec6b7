//! The values of a Sinumerik program's variables, block by block.
//!
//! A value is known after the block that assigns it from known values. A call, a synchronous action or a block that
//! the operator may skip makes it unknown again. A value that a block assigns does not hold for the other words and
//! assignments of that block. The manuals do not state the order in which these are taken.

use std::collections::{BTreeMap, BTreeSet};

use super::declaration;
use super::elements::Elements;
use super::expression::{Names, Number, Walk, operand_name_end};
use super::functions::rounded;
use crate::program::{Batch, Block, BlockFlags, BlockKind, Keyword, MAX_MAGNITUDE, Word, WordForm};

/// The most elements of all variables together. Elements of later variables stay unknown.
const MAX_ELEMENTS: usize = 100_000;
/// The longest name that a control takes, and room for more.
const MAX_NAME: usize = 64;
/// Decimals of a computed value.
const COMPUTED_DECIMALS: u8 = 4;
/// The most subscripts of a variable.
pub(super) const MAX_DIMENSIONS: usize = 3;

/// The type of a variable's values.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Real,
    /// INT. Values are rounded when they are assigned.
    Whole,
    /// BOOL: 0 or 1.
    Truth,
    /// STRING, CHAR, AXIS, FRAME: values that are not used in computations.
    Other,
}

/// A variable with its elements. The last subscript runs fastest.
#[derive(Debug, Clone)]
pub(super) struct Variable {
    pub(super) kind: Kind,
    /// Number of elements in each direction; 1 if the variable does not have the direction.
    pub(super) sizes: [usize; MAX_DIMENSIONS],
    pub(super) dimensions: usize,
    pub(super) elements: Elements,
    /// The program declares the variable and does not only assign it.
    pub(super) is_declared: bool,
}

impl Variable {
    fn undeclared() -> Self {
        let elements = Elements::new(1, None);
        Self { kind: Kind::Real, sizes: [1; MAX_DIMENSIONS], dimensions: 0, elements, is_declared: false }
    }

    /// The index of the element with these subscripts.
    fn index(&self, subscripts: &[Option<Number>]) -> Option<usize> {
        if subscripts.len() != self.dimensions {
            return None;
        }
        let mut index = 0;
        for (subscript, size) in subscripts.iter().zip(self.sizes) {
            // A whole number stays the same when a control rounds a REAL to an INT.
            let at = subscript.map(|number| number.value).filter(|at| at.fract() == 0.0 && *at >= 0.0)?;
            #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "checked range")]
            let at = if at < 1e9 { at as usize } else { return None };
            if at >= size {
                return None;
            }
            index = index * size + at;
        }
        Some(index)
    }

    /// The value that the variable holds after this value is assigned.
    pub(super) fn stored(&self, value: Number) -> Option<f64> {
        match self.kind {
            Kind::Real => Some(value.value),
            Kind::Whole if value.is_whole => Some(value.value),
            Kind::Whole => rounded(value.value).map(|number| number.value),
            Kind::Truth => Some(f64::from(u8::from(value.value != 0.0))),
            Kind::Other => None,
        }
    }

    /// Gives values to the elements from `first` on. If the values do not fit, no element is known any more. If the
    /// assignment `may_be_skipped`, a value is known only if it is the same both ways.
    pub(super) fn take(&mut self, first: usize, values: &declaration::Values, may_be_skipped: bool) {
        use declaration::{Element, Values};
        let room = self.elements.len().saturating_sub(first);
        if !values.fit(room) {
            return self.elements.fill(None);
        }
        match values {
            Values::One(value) => {
                let new = value.and_then(|value| self.stored(value));
                self.elements.set(first, new, may_be_skipped);
            }
            Values::List(list) => {
                for (at, element) in (first..).zip(list) {
                    if let Element::Value(value) = element {
                        let new = value.and_then(|value| self.stored(value));
                        self.elements.set(at, new, may_be_skipped);
                    }
                }
            }
            Values::Repeated(value, count) => {
                let new = value.and_then(|value| self.stored(value));
                self.elements.repeat(first, count.unwrap_or(room), new, may_be_skipped);
            }
            Values::Unknown => {}
        }
    }
}

/// The variables that the program has declared and assigned so far. R parameters are among the names, as `R12`. Those
/// of a called file have its [mark](mark) before their names.
#[derive(Debug, Clone, Default)]
pub(in crate::program) struct Variables {
    known: BTreeMap<Vec<u8>, Variable>,
    elements: usize,
    /// Names of the variables that may hold a known value. So forgetting costs no more than assigning did.
    live: BTreeSet<Vec<u8>>,
    /// Names that the present block has assigned.
    fresh: BTreeSet<Vec<u8>>,
    /// How many files call the present one, one inside the other. Each has variables of its own.
    depth: u8,
}

/// The form in which a name is kept: upper case, and R parameters without the mark of system variables.
pub(super) fn key(name: &[u8]) -> Vec<u8> {
    let is_parameter =
        name.first() == Some(&b'$') && name.get(1).is_some_and(|byte| byte.eq_ignore_ascii_case(&b'R'));
    let name = if is_parameter { name.get(1..).unwrap_or_default() } else { name };
    name.iter().take(MAX_NAME).map(u8::to_ascii_uppercase).collect()
}

/// `R[12]` is R12.
fn parameter_key(subscripts: &[Option<Number>]) -> Option<Vec<u8>> {
    let [Some(number)] = subscripts else { return None };
    let is_index = number.is_whole && (0.0..100_000.0).contains(&number.value);
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "checked range")]
    is_index.then(|| format!("R{}", number.value as u32).into_bytes())
}

impl Names for Variables {
    fn value(&mut self, name: &[u8], subscripts: &[Option<Number>]) -> Option<Number> {
        let mut key = key(name);
        if key == b"TRUE" || key == b"FALSE" {
            return Some(Number::truth(key == b"TRUE"));
        }
        let mut subscripts = subscripts;
        if key == b"R" {
            key = parameter_key(subscripts)?;
            subscripts = &[];
        }
        if self.fresh.contains(&key) {
            return None;
        }
        let variable = self.known.get(&self.kept(&key))?;
        let value = variable.elements.get(variable.index(subscripts)?)?;
        Some(Number { value, is_whole: matches!(variable.kind, Kind::Whole | Kind::Truth) })
    }
}

impl Variables {
    pub(in crate::program) fn evaluate(&mut self, batch: &mut Batch) {
        for index in 0..batch.blocks.len() {
            let Some(&block) = batch.blocks.get(index) else { break };
            let relevant = block.flags.has(BlockFlags::ASSIGNS) || block.flags.has(BlockFlags::EXPRESSION);
            match block.kind {
                BlockKind::Call => self.forget(),
                BlockKind::Words | BlockKind::Assignment if relevant => self.take_block(batch, index, block),
                _ => {}
            }
            self.forget_after_calls(batch, &block);
        }
    }

    /// Modal calls of the builder's own programs may assign variables at every motion.
    fn forget_after_calls(&mut self, batch: &Batch, block: &Block) {
        let calls = |word: &Word| word.keyword() == Some(Keyword::ModalCall);
        if batch.words(block).iter().any(calls) {
            self.forget();
        }
    }

    /// Another program is called. It has variables of its own. R parameters belong to all programs.
    pub(in crate::program) fn enter_file(&mut self) {
        self.depth += 1;
    }

    /// It ends, and its variables with it.
    pub(in crate::program) fn leave_file(&mut self) {
        let begins = [mark(self.depth)];
        while let Some(last) = self.known.last_entry().filter(|last| last.key().starts_with(&begins)) {
            self.elements = self.elements.saturating_sub(last.remove().elements.len());
        }
        while self.live.last().is_some_and(|last| last.starts_with(&begins)) {
            self.live.pop_last();
        }
        self.depth = self.depth.saturating_sub(1);
    }

    /// A name as the present program's variable is kept.
    fn kept(&self, key: &[u8]) -> Vec<u8> {
        if self.depth == 0 || is_parameter(key) {
            key.to_owned()
        } else {
            [&[mark(self.depth)], key].concat()
        }
    }

    /// After a call any variable may have any value. The declarations stay.
    fn forget(&mut self) {
        for key in std::mem::take(&mut self.live) {
            if let Some(variable) = self.known.get_mut(&key) {
                variable.elements.fill(None);
            }
        }
    }

    fn take_block(&mut self, batch: &mut Batch, index: usize, block: Block) {
        self.fresh.clear();
        let may_be_skipped = block.flags.has(BlockFlags::DELETE);
        let range = block.words_start as usize..block.words_end as usize;
        let mut names_axis = false;
        for at in range.clone() {
            let Some(&word) = batch.words.get(at) else { break };
            let text = batch.text.get(word.start as usize..word.end as usize).unwrap_or_default();
            match word.keyword() {
                Some(Keyword::Declaration) => self.declare(text, may_be_skipped),
                Some(Keyword::Assigned) => {
                    self.assign(text, may_be_skipped);
                }
                Some(Keyword::Named) => {
                    let meaning = self.assign(text, may_be_skipped);
                    names_axis |= meaning != Keyword::Assigned;
                    if let Some(word) = batch.words.get_mut(at) {
                        word.value = f64::from(meaning.number());
                    }
                }
                _ => {}
            }
        }
        for at in range {
            let Some(&word) = batch.words.get(at).filter(|word| word.form == WordForm::Expression) else {
                continue;
            };
            let text = batch.text.get(word.start as usize..word.end as usize).unwrap_or_default();
            let Some((value, form)) = self.word_value(text.get(usize::from(word.lead)..).unwrap_or_default())
            else {
                continue;
            };
            if let Some(word) = batch.words.get_mut(at).filter(|_| value.abs() <= MAX_MAGNITUDE) {
                (word.value, word.form) = (value, form);
                (word.decimals, word.has_point) = (COMPUTED_DECIMALS, true);
            }
        }
        if names_axis && let Some(block) = batch.blocks.get_mut(index) {
            block.kind = BlockKind::Words;
        }
        self.fresh.clear();
    }

    /// The value of an expression that is the whole text; `None` if it is not known.
    pub(in crate::program) fn value_of_text(&mut self, text: &[u8]) -> Option<f64> {
        let mut walk = Walk::new(text, 0, self);
        let value = walk.expression().ok().flatten()?;
        walk.skip_blanks();
        (walk.at >= text.len()).then_some(value.value)
    }

    /// Gives a variable the value of an expression and something more. Returns whether its value is known now.
    pub(in crate::program) fn assign_text(&mut self, variable: &[u8], from: &[u8], more: &[u8]) -> bool {
        self.assign(&[variable, b"=", from, more].concat(), false);
        self.fresh.clear();
        self.value_of_text(variable).is_some()
    }

    /// The value of a word, and from where it counts.
    fn word_value(&mut self, text: &[u8]) -> Option<(f64, WordForm)> {
        let blanks = text.iter().take_while(|byte| matches!(byte, b' ' | b'\t')).count();
        let end = operand_name_end(text, blanks);
        let name = text.get(blanks..end).unwrap_or_default();
        let mut walk = Walk::new(text, end, self);
        let form = if !walk.is_next(b'(') {
            WordForm::Evaluated
        } else if name.eq_ignore_ascii_case(b"IC") {
            WordForm::Incremental
        } else if name.eq_ignore_ascii_case(b"AC") {
            WordForm::Absolute
        } else {
            WordForm::Evaluated
        };
        if form == WordForm::Evaluated {
            walk.at = 0;
        }
        let value = walk.expression().ok().flatten()?;
        // The value must be the whole text: no control takes `IC(2)*3`.
        walk.skip_blanks();
        (walk.at >= text.len()).then_some((value.value, form))
    }

    /// `NAME=…`, with subscripts and lists. Returns what the name is: a variable, a name that may be an axis, or
    /// another name that the program does not declare.
    fn assign(&mut self, text: &[u8], may_be_skipped: bool) -> Keyword {
        let end = operand_name_end(text, 0);
        let name = text.get(..end).unwrap_or_default();
        let mut key = key(name);
        let mut walk = Walk::new(text, end, self);
        let mut subscripts = Vec::new();
        if walk.is_next(b'[') {
            let Ok(list) = walk.list(b']') else { return self.lose(&key) };
            if list.count > list.values().len() {
                return self.lose(&key);
            }
            subscripts.extend_from_slice(list.values());
        }
        if !walk.take_equals() {
            return self.lose(&key);
        }
        let from = walk.at;
        let is_parameter = is_parameter(&key);
        if key == b"R" {
            let Some(parameter) = parameter_key(&subscripts) else {
                // It may assign any variable.
                self.forget();
                return Keyword::Assigned;
            };
            key = parameter;
            subscripts.clear();
        }
        let value_text = text.get(from..).unwrap_or_default();
        let values = declaration::values(value_text, self);
        let known_before = self.known.get(&self.kept(&key)).is_some_and(|variable| variable.is_declared);
        self.put(&key, &subscripts, &values, may_be_skipped);
        self.fresh.insert(key.clone());
        if known_before || is_parameter { Keyword::Assigned } else { undeclared(&key) }
    }

    /// The value of a variable is no longer known.
    fn lose(&mut self, key: &[u8]) -> Keyword {
        let mut declared = false;
        if let Some(variable) = self.known.get_mut(&self.kept(key)) {
            variable.elements.fill(None);
            declared = variable.is_declared;
        }
        self.fresh.insert(key.to_owned());
        if declared { Keyword::Assigned } else { undeclared(key) }
    }

    fn put(
        &mut self,
        key: &[u8],
        subscripts: &[Option<Number>],
        values: &declaration::Values,
        may_be_skipped: bool,
    ) {
        let kept = self.kept(key);
        if !self.known.contains_key(&kept) {
            if self.elements >= MAX_ELEMENTS {
                return;
            }
            self.elements += 1;
            self.known.insert(kept.clone(), Variable::undeclared());
        }
        let Some(variable) = self.known.get_mut(&kept) else { return };
        let first = match (values, variable.dimensions) {
            // A list for the whole array.
            (declaration::Values::List(_) | declaration::Values::Repeated(..), dimensions)
                if dimensions > 0 && subscripts.is_empty() =>
            {
                Some(0)
            }
            _ => variable.index(subscripts),
        };
        match first {
            Some(first) => variable.take(first, values, may_be_skipped),
            None => variable.elements.fill(None),
        }
        self.live.insert(kept);
    }

    fn declare(&mut self, text: &[u8], may_be_skipped: bool) {
        for (key, mut variable) in declaration::read(text, self) {
            if self.elements + variable.elements.len() > MAX_ELEMENTS {
                variable.elements = Elements::new(0, None);
            }
            if may_be_skipped {
                variable.elements.fill(None);
            }
            let key = self.kept(&key);
            let before = self.known.get(&key).map_or(0, |old| old.elements.len());
            self.elements = self.elements - before + variable.elements.len();
            self.live.insert(key.clone());
            self.known.insert(key, variable);
        }
    }
}

/// What comes before the names of a called file's variables. No name begins with it, and it sorts after all names.
const fn mark(depth: u8) -> u8 {
    0x80 | depth
}

fn is_parameter(key: &[u8]) -> bool {
    matches!(key.split_first(), Some((b'R', rest)) if rest.iter().all(u8::is_ascii_digit))
}

/// The kind of a name that the program assigns but does not declare: a variable of the control (no axis begins with an
/// underscore), or perhaps an axis. The first letter tells whether it may be one of the machine's five axes.
fn undeclared(key: &[u8]) -> Keyword {
    match key.first() {
        Some(b'_') => Keyword::Assigned,
        Some(b'A'..=b'C' | b'X'..=b'Z') => Keyword::MachineAxis,
        _ => Keyword::ForeignAxis,
    }
}
