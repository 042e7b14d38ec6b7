//! Parameters, variables and arithmetic whose value is fixed by the text alone: expressions become numbers block by
//! block, in the order of the program. What depends on the run (positions, inputs, system variables) stays unknown.

mod arithmetic;
mod heidenhain;
mod rs274;
mod siemens;

pub(super) use siemens::{Mistake, NoNames, Number, Walk, exponent_end, operand_name_end, with_exponent};

use super::{Batch, Dialect};

/// What a program's own parameters stand at.
#[derive(Debug, Clone)]
pub struct Constants {
    grammar: Grammar,
}

#[derive(Debug, Clone)]
enum Grammar {
    /// A dialect without expressions.
    None,
    Rs274(rs274::Parameters),
    Siemens(siemens::Variables),
    Heidenhain(heidenhain::Parameters),
}

impl Constants {
    /// Nothing assigned yet, in a program of this dialect.
    #[must_use]
    pub fn new(dialect: Dialect) -> Self {
        let grammar = match dialect {
            Dialect::Iso => Grammar::Rs274(rs274::Parameters::default()),
            Dialect::Siemens => Grammar::Siemens(siemens::Variables::default()),
            Dialect::Heidenhain => Grammar::Heidenhain(heidenhain::Parameters::default()),
            Dialect::Apt | Dialect::Csv => Grammar::None,
        };
        Self { grammar }
    }

    /// Goes through the blocks of a batch, the program's next one: expressions whose value is fixed become
    /// [`super::WordForm::Evaluated`] (or `Absolute`, `Incremental`) words.
    pub fn evaluate(&mut self, batch: &mut Batch) {
        match &mut self.grammar {
            Grammar::None => {}
            Grammar::Rs274(parameters) => parameters.evaluate(batch),
            Grammar::Siemens(variables) => variables.evaluate(batch),
            Grammar::Heidenhain(parameters) => parameters.evaluate(batch),
        }
    }
}
