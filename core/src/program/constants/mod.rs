//! Parameters, variables and arithmetic whose values follow from the text alone. Expressions become numbers block by
//! block, in the order of the program. Values that depend on the run (positions, inputs, system variables) stay
//! unknown.

pub(super) mod arithmetic;

use super::dialect::{Arithmetic, heidenhain, iso, siemens};
use super::{Batch, Dialect};

/// The present values of a program's own parameters.
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
    /// The parameters of a program of this dialect before any assignment.
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

    /// Goes through the blocks of a batch, which must be the program's next one. Expressions with a fixed value become
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
