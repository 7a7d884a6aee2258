//! JSON values with their source text. Unchanged values are written with the bytes that were read.
//!
//! Each value of a document stores the range of its text. Mutable access clears the range of the
//! value and of all its parents, because values are reached through their parents. Writing copies
//! the text of values that still have a range, and serializes the others.
//!
//! ```text
//! {"meshes": [ {…} , {…} ], "extras": { "x" : 1E5 }}
//! └── no text ──────┼───┼─────────────┴─── text ───┘
//!            no text┘   └text                  only the first mesh was changed
//! ```
//!
//! # Algorithm
//! `serde_json` checks the text, including the nesting depth, and reports errors. `jsonc_parser`
//! then finds the range of each value: `serde_json` does not provide ranges, and its values treat
//! numbers and some object keys specially.
//!
//! # Complexity
//! Linear in the text; 56 bytes per value, plus the characters of strings.

use std::ops::Range;

use indexmap::IndexMap;
use jsonc_parser::ast;
use jsonc_parser::common::Ranged;
use jsonc_parser::{CollectOptions, ParseOptions};
use serde::de::{Deserialize, Deserializer, MapAccess, SeqAccess, Visitor};

use crate::error::Error;

/// The range of a value's text in its document.
type Span = Range<u32>;

/// A JSON value, with its source text while it is unchanged.
#[derive(Debug, Clone)]
pub(in crate::gltf) struct Value {
    /// `None` for a value that was built or changed.
    text: Option<Span>,
    pub(in crate::gltf) content: JsonContent,
}

/// The kind and content of a value.
#[derive(Debug, Clone)]
pub(in crate::gltf) enum JsonContent {
    Null,
    Bool(bool),
    /// A number without sign, fraction or exponent.
    Whole(u64),
    /// Any other number, as text.
    Number(Box<str>),
    String(Box<str>),
    Array(Vec<Value>),
    Object(Members),
}

/// The members of an object, in order. If a name is repeated, the last member is used.
#[derive(Debug, Clone, Default)]
pub(in crate::gltf) struct Members(IndexMap<Box<str>, JsonMember>);

#[derive(Debug, Clone)]
struct JsonMember {
    /// The text of the name, including quotes; `None` for an added member.
    name: Option<Span>,
    value: Value,
}

/// Parses JSON text.
pub(in crate::gltf) fn parse(text: &[u8]) -> Result<Value, Error> {
    if let Err(error) = serde_json::from_slice::<Checked>(text) {
        let words = error.to_string();
        let what = words.split(" at line ").next().unwrap_or(&words).to_owned();
        let at = format!("JSON line {}, column {}", error.line(), error.column());
        return Err(Error::format(at, what, "JSON"));
    }
    if u32::try_from(text.len()).is_err() {
        let (at, found) = ("bytes of the JSON".to_owned(), text.len() as u64);
        return Err(Error::LimitExceeded { at, found, limit: u64::from(u32::MAX) });
    }
    let wrong = |what: String| Error::format("JSON", what, "JSON");
    let text = std::str::from_utf8(text).map_err(|error| wrong(error.to_string()))?;
    let strict = ParseOptions {
        allow_comments: false,
        allow_loose_object_property_names: false,
        allow_trailing_commas: false,
        allow_missing_commas: false,
        allow_single_quoted_strings: false,
        allow_hexadecimal_numbers: false,
        allow_unary_plus_numbers: false,
        allow_bare_decimal_point_numbers: false,
        allow_non_finite_numbers: false,
        allow_extended_string_escapes: false,
    };
    let parsed = jsonc_parser::parse_to_ast(text, &CollectOptions::default(), &strict)
        .map_err(|error| wrong(error.to_string()))?;
    parsed.value.map(Value::of_text).ok_or_else(|| wrong("nothing".into()))
}

/// Any JSON, nested at most 128 deep. Unlike `serde::de::IgnoredAny`, it checks strings.
struct Checked;

impl<'de> Deserialize<'de> for Checked {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(Checked)
    }
}

impl<'de> Visitor<'de> for Checked {
    type Value = Self;

    fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("JSON")
    }

    fn visit_unit<E>(self) -> Result<Self, E> {
        Ok(self)
    }

    fn visit_bool<E>(self, _: bool) -> Result<Self, E> {
        Ok(self)
    }

    fn visit_i64<E>(self, _: i64) -> Result<Self, E> {
        Ok(self)
    }

    fn visit_u64<E>(self, _: u64) -> Result<Self, E> {
        Ok(self)
    }

    fn visit_f64<E>(self, _: f64) -> Result<Self, E> {
        Ok(self)
    }

    fn visit_str<E>(self, _: &str) -> Result<Self, E> {
        Ok(self)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut items: A) -> Result<Self, A::Error> {
        while items.next_element::<Self>()?.is_some() {}
        Ok(self)
    }

    fn visit_map<A: MapAccess<'de>>(self, mut members: A) -> Result<Self, A::Error> {
        while members.next_entry::<Self, Self>()?.is_some() {}
        Ok(self)
    }
}

/// Returns the range of a node's text. The text is smaller than 4 GiB.
fn span(node: &impl Ranged) -> Span {
    let range = node.range();
    range.start as u32..range.end as u32
}

impl Value {
    fn of_text(value: ast::Value<'_>) -> Self {
        let text = Some(span(&value));
        let content = match value {
            ast::Value::NullKeyword(_) => JsonContent::Null,
            ast::Value::BooleanLit(bool) => JsonContent::Bool(bool.value),
            ast::Value::NumberLit(number) => JsonContent::number(number.value),
            ast::Value::StringLit(string) => JsonContent::String(string.value.into()),
            ast::Value::Array(array) => {
                JsonContent::Array(array.elements.into_iter().map(Self::of_text).collect())
            }
            ast::Value::Object(object) => {
                let members = object.properties.into_iter().map(|property| {
                    let (name, value) = (Some(span(&property.name)), Self::of_text(property.value));
                    (property.name.into_string().into(), JsonMember { name, value })
                });
                JsonContent::Object(Members(members.collect()))
            }
        };
        Self { text, content }
    }

    /// Returns a member of an object.
    pub(in crate::gltf) fn get(&self, name: &str) -> Option<&Self> {
        self.as_object()?.get(name)
    }

    pub(in crate::gltf) fn as_object(&self) -> Option<&Members> {
        if let JsonContent::Object(members) = &self.content { Some(members) } else { None }
    }

    pub(in crate::gltf) fn as_array(&self) -> Option<&[Self]> {
        if let JsonContent::Array(items) = &self.content { Some(items) } else { None }
    }

    pub(in crate::gltf) fn as_str(&self) -> Option<&str> {
        if let JsonContent::String(text) = &self.content { Some(text) } else { None }
    }

    pub(in crate::gltf) fn as_bool(&self) -> Option<bool> {
        if let JsonContent::Bool(value) = self.content { Some(value) } else { None }
    }

    /// Returns the members of an object for modification.
    pub(in crate::gltf) fn as_object_mut(&mut self) -> Option<&mut Members> {
        let JsonContent::Object(members) = &mut self.content else { return None };
        self.text = None;
        Some(members)
    }

    /// Returns the entries of an array for modification.
    pub(in crate::gltf) fn as_array_mut(&mut self) -> Option<&mut Vec<Self>> {
        let JsonContent::Array(items) = &mut self.content else { return None };
        self.text = None;
        Some(items)
    }

    /// Builds a number from its JSON text.
    pub(in crate::gltf) fn number(text: &str) -> Self {
        JsonContent::number(text).into()
    }

    /// Appends the JSON of the value; `source` is the text that it was parsed from.
    pub(in crate::gltf) fn write(&self, source: &[u8], out: &mut Vec<u8>) {
        if let Some(text) = &self.text {
            out.extend_from_slice(&source[text.start as usize..text.end as usize]);
            return;
        }
        match &self.content {
            JsonContent::Null => out.extend_from_slice(b"null"),
            JsonContent::Bool(value) => out.extend_from_slice(value.to_string().as_bytes()),
            JsonContent::Whole(number) => out.extend_from_slice(number.to_string().as_bytes()),
            JsonContent::Number(number) => out.extend_from_slice(number.as_bytes()),
            JsonContent::String(text) => out.extend_from_slice(quoted(text).as_bytes()),
            JsonContent::Array(items) => {
                out.push(b'[');
                for (i, item) in items.iter().enumerate() {
                    out.extend_from_slice(if i > 0 { b"," } else { b"" });
                    item.write(source, out);
                }
                out.push(b']');
            }
            JsonContent::Object(members) => members.write(source, out),
        }
    }
}

impl JsonContent {
    fn number(text: &str) -> Self {
        match text.parse() {
            Ok(whole) => Self::Whole(whole),
            Err(_) => Self::Number(text.into()),
        }
    }
}

impl Members {
    pub(in crate::gltf) fn get(&self, name: &str) -> Option<&Value> {
        self.0.get(name).map(|member| &member.value)
    }

    pub(in crate::gltf) fn get_mut(&mut self, name: &str) -> Option<&mut Value> {
        self.0.get_mut(name).map(|member| &mut member.value)
    }

    pub(in crate::gltf) fn contains_key(&self, name: &str) -> bool {
        self.0.contains_key(name)
    }

    pub(in crate::gltf) fn len(&self) -> usize {
        self.0.len()
    }

    pub(in crate::gltf) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    pub(in crate::gltf) fn iter(&self) -> impl Iterator<Item = (&str, &Value)> {
        self.0.iter().map(|(name, member)| (&**name, &member.value))
    }

    pub(in crate::gltf) fn values(&self) -> impl Iterator<Item = &Value> {
        self.0.values().map(|member| &member.value)
    }

    /// Iterates over the members for modification.
    pub(in crate::gltf) fn iter_mut(&mut self) -> impl Iterator<Item = (&str, &mut Value)> {
        self.0.iter_mut().map(|(name, member)| (&**name, &mut member.value))
    }

    /// Sets a member; a new one is added at the end.
    pub(in crate::gltf) fn insert(&mut self, name: &str, value: impl Into<Value>) {
        let value = value.into();
        match self.0.get_mut(name) {
            Some(member) => member.value = value,
            None => drop(self.0.insert(name.into(), JsonMember { name: None, value })),
        }
    }

    /// Moves the member with this name from another object, if it has one.
    pub(in crate::gltf) fn take_from(&mut self, other: &mut Self, name: &str) {
        if let Some((name, member)) = other.0.shift_remove_entry(name) {
            self.0.insert(name, member);
        }
    }

    /// Removes a member and keeps the order of the others.
    pub(in crate::gltf) fn remove(&mut self, name: &str) {
        self.0.shift_remove(name);
    }

    /// Appends the JSON of the object; `source` is the text that it was parsed from.
    pub(in crate::gltf) fn write(&self, source: &[u8], out: &mut Vec<u8>) {
        out.push(b'{');
        for (i, (name, member)) in self.0.iter().enumerate() {
            out.extend_from_slice(if i > 0 { b"," } else { b"" });
            match &member.name {
                Some(text) => out.extend_from_slice(&source[text.start as usize..text.end as usize]),
                None => out.extend_from_slice(quoted(name).as_bytes()),
            }
            out.push(b':');
            member.value.write(source, out);
        }
        out.push(b'}');
    }
}

/// Returns JSON without white space between values; strings and numbers keep their text.
pub(in crate::gltf) fn without_spaces(json: &[u8]) -> Vec<u8> {
    let (mut in_string, mut escaped) = (false, false);
    let is_kept = |&byte: &u8| {
        let starts_or_ends = byte == b'"' && !escaped;
        escaped = in_string && byte == b'\\' && !escaped;
        in_string ^= starts_or_ends;
        in_string || !matches!(byte, b' ' | b'\t' | b'\r' | b'\n')
    };
    json.iter().copied().filter(is_kept).collect()
}

/// Returns text as a JSON string with quotes.
fn quoted(text: &str) -> String {
    serde_json::Value::from(text).to_string()
}

impl From<JsonContent> for Value {
    fn from(content: JsonContent) -> Self {
        Self { text: None, content }
    }
}

impl From<u64> for Value {
    fn from(number: u64) -> Self {
        JsonContent::Whole(number).into()
    }
}

impl From<usize> for Value {
    fn from(number: usize) -> Self {
        (number as u64).into()
    }
}

impl From<&str> for Value {
    fn from(text: &str) -> Self {
        JsonContent::String(text.into()).into()
    }
}

impl From<serde_json::Value> for Value {
    fn from(value: serde_json::Value) -> Self {
        use serde_json::Value as Json;
        let content = match value {
            Json::Null => JsonContent::Null,
            Json::Bool(value) => JsonContent::Bool(value),
            Json::Number(number) => JsonContent::number(&number.to_string()),
            Json::String(text) => JsonContent::String(text.into()),
            Json::Array(items) => JsonContent::Array(items.into_iter().map(Self::from).collect()),
            Json::Object(members) => {
                let members = members
                    .into_iter()
                    .map(|(name, value)| (name.into(), JsonMember { name: None, value: value.into() }));
                JsonContent::Object(Members(members.collect()))
            }
        };
        content.into()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parsed(text: &str) -> Value {
        parse(text.as_bytes()).unwrap()
    }

    fn written(value: &Value, source: &str) -> String {
        let mut out = Vec::new();
        value.write(source.as_bytes(), &mut out);
        String::from_utf8(out).unwrap()
    }

    #[test]
    fn only_the_values_around_a_change_are_built() {
        let text = r#"{ "a\u0062" : [ 1E5 , {"x" : -0.0, "x": 2} ], "list": [ {"old":1, "keep" : [1,  2]} , 7.50 ] }"#;
        let mut value = parsed(text);
        assert_eq!(written(&value, text), text);
        let list = value.as_object_mut().unwrap().get_mut("list").unwrap();
        let first = list.as_array_mut().unwrap()[0].as_object_mut().unwrap();
        first.insert("old", 9_usize);
        first.insert("new", "\"");
        let expected =
            r#"{"a\u0062":[ 1E5 , {"x" : -0.0, "x": 2} ],"list":[{"old":9,"keep":[1,  2],"new":"\""},7.50]}"#;
        assert_eq!(written(&value, text), expected);
        assert!(value.get("ab").is_some());
    }

    #[test]
    fn spaces_are_left_out_except_inside_strings() {
        let text = "{ \"a \\\" b\" :\t[ 1E5 ,\r\n -0.0 ] , \"c\\\\\" : \" d \" }";
        let expected = "{\"a \\\" b\":[1E5,-0.0],\"c\\\\\":\" d \"}";
        assert_eq!(String::from_utf8(without_spaces(text.as_bytes())).unwrap(), expected);
        assert_eq!(without_spaces(expected.as_bytes()), expected.as_bytes());
    }

    #[test]
    fn no_name_of_a_member_has_a_meaning_of_its_own() {
        for name in ["$serde_json::private::Number", "$serde_json::private::RawValue"] {
            let text = format!("{{\"{name}\":\"[1\"}}");
            let value = parsed(&text);
            assert_eq!(value.get(name).and_then(Value::as_str), Some("[1"));
        }
    }

    #[test]
    fn text_that_is_not_json_is_refused() {
        for text in [
            "",
            "[1,]",
            "{a:1}",
            "{'a':1}",
            "[01]",
            "[+1]",
            "[.5]",
            "[1.]",
            "[NaN]",
            "[1] 2",
            "[\"\t\"]",
            "\"\\ud800\"",
            "// x\n[]",
        ] {
            assert!(parse(text.as_bytes()).is_err(), "{text}");
        }
        assert!(parse(&b"[".repeat(100_000)).is_err());
        assert!(parse(b"\"\xff\"").is_err());
    }
}
