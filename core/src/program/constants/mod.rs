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
    ///
    /// A batch whose expressions have their values already is left as it is.
    pub fn evaluate(&mut self, batch: &mut Batch) {
        if batch.is_evaluated {
            return;
        }
        match &mut self.grammar {
            Grammar::None => {}
            Grammar::Rs274(parameters) => parameters.evaluate(batch),
            Grammar::Siemens(variables) => variables.evaluate(batch),
            Grammar::Heidenhain(parameters) => parameters.evaluate(batch),
        }
    }

    /// The value of an expression that is the whole text, as it is now; `None` if it is not known.
    pub(super) fn value(&mut self, text: &[u8]) -> Option<f64> {
        match &mut self.grammar {
            Grammar::None => None,
            Grammar::Rs274(parameters) => parameters.value_of_text(text),
            Grammar::Siemens(variables) => variables.value_of_text(text),
            Grammar::Heidenhain(parameters) => parameters.value_of_text(text),
        }
    }

    /// Gives a variable the value of an expression and something more. Returns whether its value is known now.
    pub(super) fn count(&mut self, variable: &[u8], from: &[u8], more: &[u8]) -> bool {
        match &mut self.grammar {
            Grammar::Siemens(variables) => variables.assign_text(variable, from, more),
            Grammar::None | Grammar::Rs274(_) | Grammar::Heidenhain(_) => false,
        }
    }

    /// A subprogram with parameters of its own begins. These are its first ones.
    pub(super) fn enter(&mut self, arguments: &[Option<f64>]) {
        if let Grammar::Rs274(parameters) = &mut self.grammar {
            parameters.enter(arguments);
        }
    }

    /// It ends: the caller's parameters hold again.
    pub(super) fn leave(&mut self) {
        if let Grammar::Rs274(parameters) = &mut self.grammar {
            parameters.leave();
        }
    }

    /// A file is called. It does not see the variables that belong to its caller.
    pub(super) fn enter_file(&mut self) {
        match &mut self.grammar {
            Grammar::None | Grammar::Rs274(_) => {}
            Grammar::Siemens(variables) => variables.enter_file(),
            Grammar::Heidenhain(parameters) => parameters.enter_file(),
        }
    }

    /// The file ends: the caller has its variables again.
    pub(super) fn leave_file(&mut self) {
        match &mut self.grammar {
            Grammar::None | Grammar::Rs274(_) => {}
            Grammar::Siemens(variables) => variables.leave_file(),
            Grammar::Heidenhain(parameters) => parameters.leave_file(),
        }
    }
}
