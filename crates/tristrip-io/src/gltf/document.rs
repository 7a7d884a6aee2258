//! The JSON of a document: parsed under limits, and looked into with errors that name the place.

use serde_json::{Map, Value};

use super::JSON_VALUE_LIMIT;
use crate::error::Error;

/// Makes the error for bytes that are not what the format asks for.
pub(super) fn format_error(
    at: impl Into<String>,
    found: impl Into<String>,
    expected: impl Into<String>,
) -> Error {
    Error::Format { at: at.into(), found: found.into(), expected: expected.into() }
}

/// Parses a document and checks that it is glTF 2.
pub(super) fn parse(json: &[u8]) -> Result<Map<String, Value>, Error> {
    // Each value but the first follows one of these; inside of strings they only make the count too high.
    let values = json.iter().filter(|b| matches!(b, b',' | b'[' | b'{')).count() as u64;
    if values > JSON_VALUE_LIMIT {
        return Err(Error::LimitExceeded {
            at: "values of the JSON".into(),
            found: values,
            limit: JSON_VALUE_LIMIT,
        });
    }
    let root: Value = serde_json::from_slice(json).map_err(|e| {
        let text = e.to_string();
        let what = text.split(" at line ").next().unwrap_or(&text).to_owned();
        format_error(format!("JSON line {}, column {}", e.line(), e.column()), what, "JSON")
    })?;
    let Value::Object(root) = root else {
        return Err(format_error("JSON", describe(&root), "an object"));
    };
    let version = Place::root(&root, "asset")?.need("version")?;
    if !version.text()?.starts_with("2.") {
        return Err(version.wrong("\"2.0\""));
    }
    Ok(root)
}

/// A value and where it stands.
#[derive(Clone)]
pub(super) struct Place<'a> {
    pub(super) value: &'a Value,
    pub(super) at: String,
}

impl<'a> Place<'a> {
    /// Finds a member of the document.
    pub(super) fn root(root: &'a Map<String, Value>, name: &str) -> Result<Self, Error> {
        match root.get(name) {
            Some(value) => Ok(Self { value, at: name.to_owned() }),
            None => Err(format_error(name, "nothing", "an object")),
        }
    }

    /// Walks over the entries of one of the document's arrays.
    pub(super) fn entries(
        root: &'a Map<String, Value>,
        list: &'static str,
    ) -> Result<impl Iterator<Item = Self>, Error> {
        let entries = array(root, list)?.iter().enumerate();
        Ok(entries.map(move |(i, value)| Self { value, at: format!("{list}[{i}]") }))
    }

    /// Finds the entry of one of the document's arrays that the value is an index of.
    pub(super) fn target(&self, root: &'a Map<String, Value>, list: &str) -> Result<Self, Error> {
        let (index, entries) = (self.size()?, array(root, list)?);
        match entries.get(index) {
            Some(value) => Ok(Self { value, at: format!("{list}[{index}]") }),
            None => Err(self.wrong(format!("less than {}, the number of {list}", entries.len()))),
        }
    }

    /// Finds a member, if it is there.
    pub(super) fn field(&self, name: &str) -> Option<Place<'a>> {
        let value = self.value.get(name)?;
        Some(Self { value, at: format!("{}.{name}", self.at) })
    }

    /// Finds a member that must be there.
    pub(super) fn need(&self, name: &str) -> Result<Place<'a>, Error> {
        self.field(name).ok_or_else(|| format_error(format!("{}.{name}", self.at), "nothing", "a value"))
    }

    /// Gives the entries of an array.
    pub(super) fn items(&self) -> Result<impl Iterator<Item = Place<'a>> + use<'a>, Error> {
        let Value::Array(items) = self.value else { return Err(self.wrong("an array")) };
        let at = self.at.clone();
        Ok(items.iter().enumerate().map(move |(i, value)| Place { value, at: format!("{at}[{i}]") }))
    }

    /// Gives the members of an object.
    pub(super) fn members(&self) -> Result<impl Iterator<Item = (&'a str, Place<'a>)> + use<'a>, Error> {
        let Value::Object(members) = self.value else { return Err(self.wrong("an object")) };
        let at = self.at.clone();
        Ok(members
            .iter()
            .map(move |(name, value)| (name.as_str(), Place { value, at: format!("{at}.{name}") })))
    }

    /// Takes the value for a whole number.
    pub(super) fn whole(&self) -> Result<u64, Error> {
        whole(self.value).ok_or_else(|| self.wrong("a whole number"))
    }

    /// Takes the value for a size or an index.
    pub(super) fn size(&self) -> Result<usize, Error> {
        usize::try_from(self.whole()?).map_err(|_| self.wrong("a smaller number"))
    }

    /// Takes the value for text.
    pub(super) fn text(&self) -> Result<&'a str, Error> {
        self.value.as_str().ok_or_else(|| self.wrong("a string"))
    }

    /// Makes the error for a value that is not what was expected.
    pub(super) fn wrong(&self, expected: impl Into<String>) -> Error {
        format_error(self.at.clone(), describe(self.value), expected)
    }

    /// Gives a member that is a size, or a default where it is missing.
    pub(super) fn size_or(&self, name: &str, default: usize) -> Result<usize, Error> {
        self.field(name).map_or(Ok(default), |place| place.size())
    }
}

/// Gives the entries of one of the document's arrays; none where it is missing.
pub(super) fn array<'a>(root: &'a Map<String, Value>, list: &str) -> Result<&'a [Value], Error> {
    match root.get(list) {
        None => Ok(&[]),
        Some(Value::Array(entries)) => Ok(entries),
        Some(other) => Err(format_error(list, describe(other), "an array")),
    }
}

/// Takes a value for a whole number; some writers put `3.0` for `3`.
pub(super) fn whole(value: &Value) -> Option<u64> {
    const EXACT: f64 = 9_007_199_254_740_992.0;
    value.as_u64().or_else(|| {
        let x = value.as_f64()?;
        #[allow(clippy::cast_sign_loss, reason = "the range is checked")]
        (x.fract() == 0.0 && (0.0..EXACT).contains(&x)).then_some(x as u64)
    })
}

/// Gives the entries of one of the document's arrays, which is made if it is missing.
pub(super) fn list_mut<'a>(
    root: &'a mut Map<String, Value>,
    list: &str,
) -> Result<&'a mut Vec<Value>, Error> {
    match root.entry(list).or_insert_with(|| Value::Array(Vec::new())) {
        Value::Array(entries) => Ok(entries),
        _ => Err(format_error(list, "something else", "an array")),
    }
}

/// Gives the entries of an array that is a member of a value; none where it is missing.
pub(super) fn items<'a>(value: &'a Value, name: &str) -> &'a [Value] {
    value.get(name).and_then(Value::as_array).map_or(&[], Vec::as_slice)
}

/// Walks over the members of an object.
pub(super) fn values(object: &Value) -> impl Iterator<Item = &Value> {
    object.as_object().into_iter().flat_map(Map::values)
}

/// Takes a value for an index.
pub(super) fn index(value: &Value) -> Option<usize> {
    usize::try_from(whole(value)?).ok()
}

/// Tells whether a document declares that it uses an extension.
pub(super) fn uses(root: &Map<String, Value>, extension: &str) -> bool {
    ["extensionsUsed", "extensionsRequired"].iter().any(|list| {
        root.get(*list).and_then(Value::as_array).is_some_and(|names| names.iter().any(|n| n == extension))
    })
}

/// Says in a few words what a value is.
fn describe(value: &Value) -> String {
    match value {
        Value::Null => "null".into(),
        Value::Bool(b) => b.to_string(),
        Value::Number(n) => n.to_string().chars().take(40).collect(),
        Value::String(s) if s.chars().count() <= 40 => format!("{s:?}"),
        Value::String(s) => format!("{:?}...", s.chars().take(40).collect::<String>()),
        Value::Array(_) => "an array".into(),
        Value::Object(_) => "an object".into(),
    }
}
