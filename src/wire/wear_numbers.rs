//! One number or many: a request and its answer have the same form.

#[cfg(test)]
use std::borrow::Cow;
use std::fmt;

use serde::de::{Error as _, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};
#[cfg(test)]
use utoipa::openapi::schema::{ArrayBuilder, ObjectBuilder, OneOfBuilder, SchemaType, Type};
#[cfg(test)]
use utoipa::openapi::{RefOr, Schema};
#[cfg(test)]
use utoipa::{PartialSchema, ToSchema};

/// One number for all elements, or one number for each.
#[derive(Debug, Clone, PartialEq)]
pub enum Numbers {
    /// The same number for all elements.
    One(f64),
    /// One number for each element.
    Many(Vec<f64>),
}

impl Numbers {
    /// How many numbers there are, if there are many.
    #[must_use]
    pub fn count(&self) -> Option<usize> {
        match self {
            Self::One(_) => None,
            Self::Many(numbers) => Some(numbers.len()),
        }
    }

    /// The number of the element with this index; NaN if the list is shorter.
    #[must_use]
    pub fn at(&self, index: usize) -> f64 {
        match self {
            Self::One(number) => *number,
            Self::Many(numbers) => numbers.get(index).copied().unwrap_or(f64::NAN),
        }
    }

    /// All numbers as written.
    #[must_use]
    pub fn written(&self) -> &[f64] {
        match self {
            Self::One(number) => std::slice::from_ref(number),
            Self::Many(numbers) => numbers,
        }
    }
}

struct OneOrMany;

impl<'de> Visitor<'de> for OneOrMany {
    type Value = Numbers;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a number or an array of numbers")
    }

    fn visit_f64<E: serde::de::Error>(self, number: f64) -> Result<Numbers, E> {
        Ok(Numbers::One(number))
    }

    fn visit_u64<E: serde::de::Error>(self, number: u64) -> Result<Numbers, E> {
        Ok(Numbers::One(number as f64))
    }

    fn visit_i64<E: serde::de::Error>(self, number: i64) -> Result<Numbers, E> {
        Ok(Numbers::One(number as f64))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<Numbers, A::Error> {
        let mut numbers = Vec::new();
        while let Some(number) = seq.next_element()? {
            numbers.push(number);
        }
        if numbers.is_empty() {
            return Err(A::Error::invalid_length(0, &"at least one number"));
        }
        Ok(Numbers::Many(numbers))
    }
}

impl<'de> Deserialize<'de> for Numbers {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(OneOrMany)
    }
}

impl Serialize for Numbers {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::One(number) => serializer.serialize_f64(*number),
            Self::Many(numbers) => numbers.serialize(serializer),
        }
    }
}

/// Answers in the form of the request; null if there is no answer.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[serde(untagged)]
pub enum Answers {
    /// For a request with single numbers.
    One(Option<f64>),
    /// For a request with arrays.
    Many(Vec<Option<f64>>),
}

impl Answers {
    /// The answers to a request with arrays, or the only answer.
    #[must_use]
    pub fn of(many: bool, answers: Vec<Option<f64>>) -> Self {
        if many { Self::Many(answers) } else { Self::One(answers.first().copied().flatten()) }
    }

    /// The answer for the element with this index.
    #[must_use]
    pub fn at(&self, index: usize) -> Option<f64> {
        match self {
            Self::One(answer) => *answer,
            Self::Many(answers) => answers.get(index).copied().flatten(),
        }
    }
}

#[cfg(test)]
fn one_or_many(kind: &SchemaType) -> RefOr<Schema> {
    let number = || ObjectBuilder::new().schema_type(kind.clone());
    OneOfBuilder::new().item(number()).item(ArrayBuilder::new().items(number())).into()
}

#[cfg(test)]
impl PartialSchema for Numbers {
    fn schema() -> RefOr<Schema> {
        one_or_many(&SchemaType::Type(Type::Number))
    }
}

#[cfg(test)]
impl ToSchema for Numbers {
    fn name() -> Cow<'static, str> {
        Cow::Borrowed("NumbersOrOne")
    }
}

#[cfg(test)]
impl PartialSchema for Answers {
    fn schema() -> RefOr<Schema> {
        one_or_many(&SchemaType::from_iter([Type::Number, Type::Null]))
    }
}

#[cfg(test)]
impl ToSchema for Answers {
    fn name() -> Cow<'static, str> {
        Cow::Borrowed("NumbersOrNull")
    }
}
