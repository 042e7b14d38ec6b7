//! Query parameters to documents: dotted names nest, commas separate the elements of an array. Names of work
//! offsets contain dots of their own: `work_offsets_mm.G54.1 P3` is the offset `G54.1 P3`.

use std::collections::BTreeMap;

use serde::de::value::{MapDeserializer, SeqDeserializer, StrDeserializer};
use serde::de::{DeserializeOwned, Deserializer, Error as _, IntoDeserializer, Visitor};
use thiserror::Error;

use super::Fault;
use super::reading::{escape, fault_at};

/// Why a query cannot be read as a document.
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
/// The first fault, with the pointer that the parameter's dotted name represents.
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

/// The document of an operation without query parameters: any parameter is unknown.
#[derive(Debug, Clone, Copy, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NoParameters {}

#[derive(Debug, Clone)]
enum Node {
    Leaf(String),
    Branch(BTreeMap<String, Node>),
}

/// The object whose members the caller names: everything after its dot is one name.
const OF_NAMES: &str = "work_offsets_mm";

/// The pointer that a parameter's name represents.
fn pointer(name: &str) -> String {
    let mut pointer = String::new();
    let mut rest = Some(name);
    while let Some(name) = rest {
        let (first, inner) = name.split_once('.').map_or((name, None), |(first, inner)| (first, Some(inner)));
        for part in [Some(first), inner.filter(|_| first == OF_NAMES)].into_iter().flatten() {
            pointer.push('/');
            pointer.push_str(&escape(part));
        }
        rest = inner.filter(|_| first != OF_NAMES);
    }
    pointer
}

fn insert(
    branch: &mut BTreeMap<String, Node>,
    whole: &str,
    name: &str,
    value: String,
) -> Result<(), QueryFault> {
    let refuse = |detail: String| Err(QueryFault::Parameter(Fault::new(pointer(whole), detail)));
    let leaf = |branch: &mut BTreeMap<String, Node>, name: &str, value| match branch
        .insert(name.to_owned(), Node::Leaf(value))
    {
        None => Ok(()),
        Some(_) => refuse(format!("query parameter `{whole}` is given more than once")),
    };
    let Some((first, rest)) = name.split_once('.') else {
        return leaf(branch, name, value);
    };
    if whole.matches('.').count() > 8 {
        return refuse(format!("query parameter `{whole}` is nested too deeply"));
    }
    match branch.entry(first.to_owned()).or_insert_with(|| Node::Branch(BTreeMap::new())) {
        Node::Branch(inner) if first == OF_NAMES => leaf(inner, rest, value),
        Node::Branch(inner) => insert(inner, whole, rest, value),
        Node::Leaf(_) => {
            refuse(format!("query parameter `{whole}` is nested under a parameter that has a value"))
        }
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

    /// A query has no null: an absent value is left out, and `null` is an ordinary word.
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

#[cfg(test)]
mod tests {
    use super::super::CcParameters;
    use super::*;

    #[test]
    fn names_of_work_offsets_have_dots_and_blanks_of_their_own() {
        let query =
            "work_offsets_mm.G54=1,2,3&work_offsets_mm.G54.1+P3=4,5,6&work_offsets_mm.G54.1%20P4=7,8,9";
        let offsets = read_query::<CcParameters>(query).unwrap().work_offsets_mm.unwrap();
        let expected =
            [("G54", [1.0, 2.0, 3.0]), ("G54.1 P3", [4.0, 5.0, 6.0]), ("G54.1 P4", [7.0, 8.0, 9.0])];
        assert_eq!(offsets.iter().collect::<Vec<_>>(), expected);
    }

    #[test]
    fn a_fault_stands_at_the_place_that_the_dotted_name_means() {
        for (query, expected) in [
            ("work_offsets_mm.G54.1+P3=1,2", "/work_offsets_mm/G54.1 P3"),
            ("work_offsets_mm.G54.1=0,0,0&work_offsets_mm.G54.1=0,0,0", "/work_offsets_mm/G54.1"),
            ("work_offsets_mm=0,0,0", "/work_offsets_mm"),
            ("work_offsets_mm=0,0,0&work_offsets_mm.G54=0,0,0", "/work_offsets_mm/G54"),
            ("singular_regions.a.b=1", "/singular_regions/a"),
            ("a.b.c.d.e.f.g.h.i.j=1", "/a/b/c/d/e/f/g/h/i/j"),
        ] {
            let fault = read_query::<CcParameters>(query).unwrap_err();
            assert!(
                matches!(&fault, QueryFault::Parameter(fault) if fault.pointer == expected),
                "{query}: {fault}"
            );
        }
    }
}
