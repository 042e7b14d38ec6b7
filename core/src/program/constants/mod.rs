//! Parameters, variables and arithmetic whose value is fixed by the text alone: expressions become numbers block by
//! block, in the order of the program. What depends on the run (positions, inputs, system variables) stays unknown.

pub(super) mod arithmetic;

use super::dialect::{Arithmetic, heidenhain, iso, siemens};
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
    Rs274(iso::constants::Parameters),
    Siemens(siemens::constants::Variables),
    Heidenhain(heidenhain::constants::Parameters),
}

impl Constants {
    /// Nothing assigned yet, in a program of this dialect.
    #[must_use]
    pub fn new(dialect: Dialect) -> Self {
        let grammar = match dialect.rules().arithmetic {
            Arithmetic::None => Grammar::None,
            Arithmetic::Rs274 => Grammar::Rs274(iso::constants::Parameters::default()),
            Arithmetic::Siemens => Grammar::Siemens(siemens::constants::Variables::default()),
            Arithmetic::Heidenhain => Grammar::Heidenhain(heidenhain::constants::Parameters::default()),
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
