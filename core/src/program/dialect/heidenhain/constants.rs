//! Q parameters of Heidenhain controls.
//!
//! `Q5 = …` formulas and FN 0 to FN 8 of known values are computed. Values that a control or a probing cycle sets
//! (Q100 to Q199, FN 18 and others) are not known. After a call, or a statement whose target cannot be read, no value
//! is known.

use std::collections::BTreeMap;

use crate::program::constants::arithmetic;
use crate::program::number::{MAX_MAGNITUDE, read_unsigned};
use crate::program::{Address, Batch, Block, BlockFlags, BlockKind, Keyword, Word, WordForm};

/// Parameters that the control itself sets.
const OF_THE_CONTROL: std::ops::Range<u32> = 100..200;
/// The most parameters that a control has.
const MAX_NUMBER: u32 = 10_000;
/// From the QL parameters of a program to those of the one that it calls. They come after all others.
const NEXT_PROGRAM: u32 = 3 * MAX_NUMBER;
/// The deepest formula that is computed.
const MAX_DEPTH: u32 = 32;
/// Decimals of a word whose value comes from a parameter.
const DECIMALS: u8 = 4;

/// The values that the program has assigned so far.
#[derive(Debug, Clone, Default)]
pub(in crate::program) struct Parameters {
    values: BTreeMap<u32, f64>,
    /// The cycle that waits for its call makes a hole. It sets no parameter of the program.
    makes_hole: bool,
    /// How many files call the present one, one inside the other. Each has QL parameters of its own.
    depth: u32,
}

impl Parameters {
    pub(in crate::program) fn evaluate(&mut self, batch: &mut Batch) {
        for index in 0..batch.blocks.len() {
            let Some(block) = batch.blocks.get(index).copied() else { break };
            match block.kind {
                BlockKind::Call | BlockKind::Malformed => self.forget(),
                BlockKind::Assignment => self.assign(batch, &block),
                BlockKind::Words => {
                    if block.flags.has(BlockFlags::EXPRESSION) {
                        self.words(batch, &block);
                    }
                    if block.flags.has(BlockFlags::ASSIGNS) {
                        self.cycle(batch, &block);
                    }
                    self.note_cycle(batch.words(&block), block.flags.has(BlockFlags::DELETE));
                    if calls(batch.words(&block), self.makes_hole) {
                        self.forget();
                    }
                }
                _ => {}
            }
        }
    }

    /// Any parameter may have any value, and any cycle may be defined.
    fn forget(&mut self) {
        self.values.clear();
        self.makes_hole = false;
    }

    /// Notes which cycle waits for its call.
    fn note_cycle(&mut self, words: &[Word], may_be_skipped: bool) {
        for keyword in words.iter().filter_map(Word::keyword) {
            match keyword {
                Keyword::Hole => self.makes_hole = !may_be_skipped || self.makes_hole,
                Keyword::OtherCycle => self.makes_hole = false,
                _ => {}
            }
        }
    }

    /// Another program is called. It has QL parameters of its own, whose values are not known.
    pub(in crate::program) fn enter_file(&mut self) {
        self.depth += 1;
    }

    /// It ends, and its QL parameters with it.
    pub(in crate::program) fn leave_file(&mut self) {
        while let Some(last) =
            self.values.last_entry().filter(|last| *last.key() >= self.depth * NEXT_PROGRAM)
        {
            last.remove();
        }
        self.depth = self.depth.saturating_sub(1);
    }

    /// Words whose parameter is known take its value.
    fn words(&self, batch: &mut Batch, block: &Block) {
        let Batch { text, words, .. } = batch;
        let words = words.get_mut(block.words_start as usize..block.words_end as usize).unwrap_or_default();
        for word in words.iter_mut().filter(|word| word.form == WordForm::Expression) {
            let written = text.get(word.start as usize..word.end as usize).unwrap_or_default();
            let value = written.get(usize::from(word.lead)..).unwrap_or_default();
            let mut formula = Formula { text: value, at: 0, parameters: self };
            let Some(value) = formula.signed().filter(|_| formula.is_done()) else { continue };
            // In this form the condition also refuses NaN.
            if !matches!(value.abs(), size if size <= MAX_MAGNITUDE) {
                continue;
            }
            let incremental =
                word.lead == 2 && written.first().is_some_and(|byte| byte.eq_ignore_ascii_case(&b'I'));
            word.value = value + 0.0;
            word.decimals = DECIMALS;
            word.form = if incremental { WordForm::Incremental } else { WordForm::Evaluated };
        }
    }

    /// `Q5 = formula`, `FN 1: Q1 = +Q2 + +5`
    fn assign(&mut self, batch: &Batch, block: &Block) {
        let text = statement(batch, block);
        let body = match memchr::memchr(b':', text) {
            Some(colon) if starts_with(text, b"FN") => text.get(colon + 1..).unwrap_or_default(),
            _ => text,
        };
        if starts_with(body, b"QS") {
            // A text parameter.
            return;
        }
        let mut head = Formula { text: body, at: 0, parameters: self };
        if head.word(b"SYSREAD").is_none() {
            head.at = 0;
        }
        let is_told = head.at > 0;
        let Some(name) = head.name() else {
            // A table's row may set several parameters, and a name may be one that is not read. So all values are in
            // doubt.
            self.values.clear();
            return;
        };
        if is_told {
            self.values.remove(&name);
            return;
        }
        head.skip_blanks();
        let rest = body.get(head.at..).unwrap_or_default();
        let Some((b'=', formula)) = rest.split_first() else {
            self.values.remove(&name);
            return;
        };
        let value =
            if starts_with(text, b"FN") { self.function(text, formula) } else { self.formula(formula) };
        let certain = !block.flags.has(BlockFlags::DELETE);
        match value.filter(|value| certain && value.is_finite()) {
            Some(value) => {
                self.values.insert(name, value);
            }
            None => {
                self.values.remove(&name);
            }
        }
    }

    /// The value of one operand with its sign that is the whole text; `None` if it is not known.
    pub(in crate::program) fn value_of_text(&self, text: &[u8]) -> Option<f64> {
        let mut formula = Formula { text, at: 0, parameters: self };
        formula.signed().filter(|_| formula.is_done())
    }

    fn formula(&self, text: &[u8]) -> Option<f64> {
        let mut formula = Formula { text, at: 0, parameters: self };
        let value = formula.sum(0)?;
        formula.is_done().then_some(value)
    }

    /// The right side of `FN n: Q = …`.
    fn function(&self, text: &[u8], right: &[u8]) -> Option<f64> {
        let digits = text.get(2..)?.trim_ascii_start();
        let number = read_unsigned(digits, 0)?;
        let number: u32 = std::str::from_utf8(digits.get(..number.end)?).ok()?.parse().ok()?;
        let mut formula = Formula { text: right, at: 0, parameters: self };
        let value = match number {
            0 => formula.signed()?,
            1 => {
                let a = formula.signed()?;
                formula.symbol(b'+')?;
                a + formula.signed()?
            }
            2 => {
                let a = formula.signed()?;
                formula.symbol(b'-')?;
                a - formula.signed()?
            }
            3 => {
                let a = formula.signed()?;
                formula.symbol(b'*')?;
                a * formula.signed()?
            }
            4 => {
                let a = formula.signed()?;
                formula.word(b"DIV")?;
                a / formula.signed()?
            }
            5 => {
                formula.word(b"SQRT")?;
                arithmetic::sqrt(formula.signed()?)?
            }
            6 => {
                formula.word(b"SIN")?;
                arithmetic::sin_deg(formula.signed()?)?
            }
            7 => {
                formula.word(b"COS")?;
                arithmetic::cos_deg(formula.signed()?)?
            }
            8 => {
                let a = formula.signed()?;
                formula.word(b"LEN")?;
                let b = formula.signed()?;
                (a * a + b * b).sqrt()
            }
            _ => return None,
        };
        formula.is_done().then_some(value)
    }

    /// `Q200=+2 ;SET-UP CLEARANCE` lines of a cycle. They set these parameters.
    fn cycle(&mut self, batch: &Batch, block: &Block) {
        let text = batch.text.get(block.start as usize..block.body_end as usize).unwrap_or_default();
        for line in text.split(|byte| matches!(byte, b'\n' | b'\r')) {
            let line = line.get(..memchr::memchr(b';', line).unwrap_or(line.len())).unwrap_or_default();
            let line = line.trim_ascii().trim_ascii_end();
            let line = line.strip_suffix(b"~").unwrap_or(line);
            let mut head = Formula { text: line, at: 0, parameters: self };
            let Some(name) = head.name() else { continue };
            head.skip_blanks();
            let Some((b'=', value)) = line.get(head.at..).and_then(<[u8]>::split_first) else { continue };
            let certain = !block.flags.has(BlockFlags::DELETE);
            match self.formula(value).filter(|value| certain && value.is_finite()) {
                Some(value) => self.values.insert(name, value),
                None => self.values.remove(&name),
            };
        }
    }
}

/// Whether the block runs unseen text that may set any parameter. A cycle that makes a hole sets none.
fn calls(words: &[Word], makes_hole: bool) -> bool {
    words.iter().any(|word| match word.keyword() {
        Some(keyword) => {
            matches!(
                keyword,
                Keyword::CallLabel
                    | Keyword::RepeatLabel
                    | Keyword::CycleCall
                    | Keyword::Probe
                    | Keyword::ToolCall
                    | Keyword::UnknownStatement
            ) || (keyword == Keyword::CycleCallHere && !makes_hole)
        }
        None if word.address == Address::M => match word.code_tenths() {
            Some(990) => !makes_hole,
            code => matches!(code, Some(60 | 890)),
        },
        None => false,
    })
}

fn starts_with(text: &[u8], word: &[u8]) -> bool {
    text.get(..word.len()).is_some_and(|start| start.eq_ignore_ascii_case(word))
}

/// The statement without block number and comment.
fn statement<'a>(batch: &'a Batch, block: &Block) -> &'a [u8] {
    let text = batch.text.get(block.start as usize..block.body_end as usize).unwrap_or_default();
    let open = |byte: &u8| matches!(byte, b' ' | b'\t' | b'/') || byte.is_ascii_digit();
    let from = text.iter().take_while(|byte| open(byte)).count();
    let to = memchr::memchr(b';', text).unwrap_or(text.len()).max(from);
    text.get(from..to).unwrap_or_default().trim_ascii()
}

/// The state of a formula that is being computed.
struct Formula<'a> {
    text: &'a [u8],
    at: usize,
    parameters: &'a Parameters,
}

impl Formula<'_> {
    fn byte(&self) -> u8 {
        self.text.get(self.at).copied().unwrap_or(0)
    }

    fn skip_blanks(&mut self) {
        while matches!(self.byte(), b' ' | b'\t') {
            self.at += 1;
        }
    }

    fn is_done(&mut self) -> bool {
        self.skip_blanks();
        self.at >= self.text.len()
    }

    fn symbol(&mut self, symbol: u8) -> Option<()> {
        self.skip_blanks();
        (self.byte() == symbol).then(|| self.at += 1)
    }

    fn word(&mut self, word: &[u8]) -> Option<()> {
        self.skip_blanks();
        let found = self.text.get(self.at..self.at + word.len())?.eq_ignore_ascii_case(word);
        found.then(|| self.at += word.len())
    }

    /// `Q5`, `QL5`, `QR5`, each as a unique number.
    fn name(&mut self) -> Option<u32> {
        self.skip_blanks();
        let from = self.at;
        if !self.byte().eq_ignore_ascii_case(&b'Q') {
            return None;
        }
        self.at += 1;
        let kind = match self.byte().to_ascii_uppercase() {
            b'L' => 1,
            b'R' => 2,
            _ => 0,
        };
        self.at += usize::from(kind > 0);
        let digits = self.at;
        while self.byte().is_ascii_digit() {
            self.at += 1;
        }
        let number: Option<u32> =
            std::str::from_utf8(self.text.get(digits..self.at)?).ok().and_then(|text| text.parse().ok());
        let number = number.filter(|number| *number < MAX_NUMBER);
        if number.is_none() {
            self.at = from;
        }
        let program = if kind == 1 { self.parameters.depth * NEXT_PROGRAM } else { 0 };
        number.map(|number| program + kind * MAX_NUMBER + number)
    }

    /// A number or a parameter, with the signs before it.
    fn signed(&mut self) -> Option<f64> {
        self.skip_blanks();
        let negative = self.byte() == b'-';
        if negative || self.byte() == b'+' {
            self.at += 1;
        }
        let value = self.plain()?;
        Some(if negative { 0.0 - value } else { value })
    }

    fn plain(&mut self) -> Option<f64> {
        self.skip_blanks();
        if self.byte().eq_ignore_ascii_case(&b'Q') {
            let name = self.name()?;
            return self.parameters.values.get(&name).copied().filter(|_| !OF_THE_CONTROL.contains(&name));
        }
        let number = super::conversational_number(self.text, self.at)?;
        self.at = number.1;
        Some(number.0)
    }

    fn sum(&mut self, depth: u32) -> Option<f64> {
        let mut value = self.product(depth)?;
        loop {
            self.skip_blanks();
            match self.byte() {
                b'+' => {
                    self.at += 1;
                    value += self.product(depth)?;
                }
                b'-' => {
                    self.at += 1;
                    value -= self.product(depth)?;
                }
                _ => return Some(value),
            }
        }
    }

    fn product(&mut self, depth: u32) -> Option<f64> {
        let mut value = self.power(depth)?;
        loop {
            self.skip_blanks();
            match self.byte() {
                b'*' => {
                    self.at += 1;
                    value *= self.power(depth)?;
                }
                b'/' => {
                    self.at += 1;
                    value /= self.power(depth)?;
                }
                _ => return Some(value),
            }
        }
    }

    /// `a ^ b`. The order of a sign and a power, and of two powers, is not defined. Neither is computed.
    fn power(&mut self, depth: u32) -> Option<f64> {
        self.skip_blanks();
        let has_sign = matches!(self.byte(), b'-' | b'+');
        let base = self.operand(depth)?;
        self.skip_blanks();
        if self.byte() != b'^' {
            return Some(base);
        }
        if has_sign {
            return None;
        }
        self.at += 1;
        let exponent = self.operand(depth)?;
        self.skip_blanks();
        if self.byte() == b'^' {
            return None;
        }
        arithmetic::power(base, exponent)
    }

    fn operand(&mut self, depth: u32) -> Option<f64> {
        if depth > MAX_DEPTH {
            return None;
        }
        self.skip_blanks();
        match self.byte() {
            b'-' => {
                self.at += 1;
                Some(0.0 - self.operand(depth + 1)?)
            }
            b'+' => {
                self.at += 1;
                self.operand(depth + 1)
            }
            b'(' => {
                self.at += 1;
                let value = self.sum(depth + 1)?;
                self.symbol(b')')?;
                Some(value)
            }
            byte if byte.is_ascii_alphabetic() && !byte.eq_ignore_ascii_case(&b'Q') => self.called(depth),
            _ => self.plain(),
        }
    }

    /// `SIN Q5`, `SQRT ( … )`: a function of the next operand.
    fn called(&mut self, depth: u32) -> Option<f64> {
        let from = self.at;
        while self.byte().is_ascii_alphabetic() {
            self.at += 1;
        }
        let mut name = [0; 4];
        let written = self.text.get(from..self.at)?;
        for (slot, byte) in name.get_mut(..written.len())?.iter_mut().zip(written) {
            *slot = byte.to_ascii_uppercase();
        }
        let name = name.get(..written.len())?;
        if name == b"PI" {
            return Some(std::f64::consts::PI);
        }
        let value = self.operand(depth + 1)?;
        match name {
            b"SIN" => arithmetic::sin_deg(value),
            b"COS" => arithmetic::cos_deg(value),
            b"TAN" => arithmetic::tan_deg(value),
            b"ASIN" => arithmetic::asin_deg(value),
            b"ACOS" => arithmetic::acos_deg(value),
            b"ATAN" => Some(arithmetic::atan2_deg(value, 1.0)),
            b"SQ" => Some(value * value),
            b"SQRT" => arithmetic::sqrt(value),
            b"LN" => arithmetic::ln(value),
            b"EXP" => arithmetic::exp(value),
            b"NEG" => Some(0.0 - value),
            b"INT" => Some(value.trunc()),
            b"ABS" => Some(value.abs()),
            b"FRAC" => Some(value - value.trunc()),
            // The sign of zero is 0 on some controls and 1 on others.
            b"SGN" => (value.abs() > 0.0).then_some(1.0_f64.copysign(value)),
            _ => None,
        }
    }
}
