//! Query parameters to documents: dotted names nest, commas separate the elements of an array.

use std::collections::BTreeMap;

use serde::de::value::{MapDeserializer, SeqDeserializer, StrDeserializer};
use serde::de::{DeserializeOwned, Deserializer, Error as _, IntoDeserializer, Visitor};
use thiserror::Error;

use super::Fault;
use super::reading::fault_at;

/// Why a query gives no document.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum QueryFault {
    /// The query is not percent-encoded UTF-8.
    #[error("the query is not percent-encoded UTF-8")]
    Encoding,
    /// Unknown, missing, repeated or mistyped parameters.
    #[error("query parameter {}: {}", .0.pointer, .0.detail)]
    Parameter(Fault),
}

/// Reads the parameters of `query` (the text after `?`) as one document.
///
/// # Errors
/// The first thing that is wrong, with the pointer which the parameter's dotted name stands for.
pub fn read_query<T: DeserializeOwned>(query: &str) -> Result<T, QueryFault> {
    let mut root = BTreeMap::new();
    for pair in query.split('&').filter(|pair| !pair.is_empty()) {
        let (name, value) = pair.split_once('=').unwrap_or((pair, ""));
        let (name, value) = (decode(name)?, decode(value)?);
        insert(&mut root, &name, &name, value)?;
    }
    serde_path_to_error::deserialize(Node::Branch(root))
        .map_err(|error| QueryFault::Parameter(fault_at(error.path(), &error.inner().to_string())))
}

/// The document of an operation that takes no query parameter: any one is unknown.
#[derive(Debug, Clone, Copy, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NoParameters {}

#[derive(Debug, Clone)]
enum Node {
    Leaf(String),
    Branch(BTreeMap<String, Node>),
}

fn insert(
    branch: &mut BTreeMap<String, Node>,
    whole: &str,
    name: &str,
    value: String,
) -> Result<(), QueryFault> {
    let refuse = |detail: String| {
        Err(QueryFault::Parameter(Fault::new(
            format!("/{}", whole.replace('~', "~0").replace('/', "~1").replace('.', "/")),
            detail,
        )))
    };
    let Some((first, rest)) = name.split_once('.') else {
        return match branch.insert(name.to_owned(), Node::Leaf(value)) {
            None => Ok(()),
            Some(_) => refuse(format!("query parameter `{whole}` is given more than once")),
        };
    };
    if whole.matches('.').count() > 8 {
        return refuse(format!("query parameter `{whole}` is nested too deeply"));
    }
    match branch.entry(first.to_owned()).or_insert_with(|| Node::Branch(BTreeMap::new())) {
        Node::Branch(inner) => insert(inner, whole, rest, value),
        Node::Leaf(_) => refuse(format!("query parameter `{whole}` is nested under one that has a value")),
    }
}

fn decode(text: &str) -> Result<String, QueryFault> {
    let mut bytes = Vec::with_capacity(text.len());
    let mut rest = text.as_bytes();
    while let [first, tail @ ..] = rest {
        rest = tail;
        match (first, tail) {
            (b'+', _) => bytes.push(b' '),
            (b'%', [high, low, after @ ..]) => {
                let digit = |byte: u8| char::from(byte).to_digit(16).ok_or(QueryFault::Encoding);
                let value = digit(*high)? * 16 + digit(*low)?;
                bytes.push(u8::try_from(value).unwrap_or_default());
                rest = after;
            }
            (b'%', _) => return Err(QueryFault::Encoding),
            (other, _) => bytes.push(*other),
        }
    }
    String::from_utf8(bytes).map_err(|_not_utf8| QueryFault::Encoding)
}

type Fail = serde::de::value::Error;

impl Node {
    fn leaf(self, wanted: &str) -> Result<String, Fail> {
        match self {
            Self::Leaf(text) => Ok(text),
            Self::Branch(_) => Err(Fail::custom(format_args!("expected {wanted}, found nested parameters"))),
        }
    }

    fn parsed<T: std::str::FromStr>(self, wanted: &str) -> Result<T, Fail> {
        let text = self.leaf(wanted)?;
        text.trim().parse().map_err(|_not_parsed| Fail::custom(format_args!("{text:?} is not {wanted}")))
    }
}

impl IntoDeserializer<'_, Fail> for Node {
    type Deserializer = Self;
    fn into_deserializer(self) -> Self {
        self
    }
}

macro_rules! whole_numbers {
    ($($method:ident $visit:ident $type:ty;)*) => {
        $(
            fn $method<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Fail> {
                visitor.$visit(self.parsed::<$type>("a whole number in range")?)
            }
        )*
    };
}

impl<'de> Deserializer<'de> for Node {
    type Error = Fail;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Fail> {
        match self {
            Self::Leaf(text) => visitor.visit_string(text),
            Self::Branch(_) => self.deserialize_map(visitor),
        }
    }

    whole_numbers! {
        deserialize_i8 visit_i8 i8; deserialize_i16 visit_i16 i16; deserialize_i32 visit_i32 i32;
        deserialize_i64 visit_i64 i64; deserialize_u8 visit_u8 u8; deserialize_u16 visit_u16 u16;
        deserialize_u32 visit_u32 u32; deserialize_u64 visit_u64 u64;
    }

    fn deserialize_bool<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Fail> {
        visitor.visit_bool(self.parsed("true or false")?)
    }

    fn deserialize_f32<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Fail> {
        self.deserialize_f64(visitor)
    }

    fn deserialize_f64<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Fail> {
        let number: f64 = self.parsed("a number")?;
        if !number.is_finite() {
            return Err(Fail::custom(format_args!("{number} is not a finite number")));
        }
        visitor.visit_f64(number)
    }

    /// A query has no null: what is not there is left out, and `null` is a word like any other.
    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Fail> {
        visitor.visit_some(self)
    }

    fn deserialize_seq<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Fail> {
        let text = self.leaf("values separated by commas")?;
        let elements = text.split(',').map(|element| Self::Leaf(element.to_owned()));
        let elements: Vec<Self> = if text.is_empty() { Vec::new() } else { elements.collect() };
        visitor.visit_seq(SeqDeserializer::new(elements.into_iter()))
    }

    fn deserialize_tuple<V: Visitor<'de>>(self, _len: usize, visitor: V) -> Result<V::Value, Fail> {
        self.deserialize_seq(visitor)
    }

    fn deserialize_map<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Fail> {
        match self {
            Self::Branch(branch) => visitor.visit_map(MapDeserializer::new(branch.into_iter())),
            Self::Leaf(text) => Err(Fail::custom(format_args!("expected nested parameters, found {text:?}"))),
        }
    }

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        _name: &'static str,
        _fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Fail> {
        self.deserialize_map(visitor)
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        _name: &'static str,
        _variants: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Fail> {
        let text = self.leaf("one of the names")?;
        visitor.visit_enum(StrDeserializer::new(&text))
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(
        self,
        _name: &'static str,
        visitor: V,
    ) -> Result<V::Value, Fail> {
        visitor.visit_newtype_struct(self)
    }

    serde::forward_to_deserialize_any! {
        char str string bytes byte_buf unit unit_struct tuple_struct identifier ignored_any
    }
}
