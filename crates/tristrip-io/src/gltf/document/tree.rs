//! The JSON of a document. The number of parsed values is limited, errors contain the JSON path,
//! and unchanged values are written with their source text.

use crate::gltf::document::byte_ranges::SharedBytes;
use crate::gltf::document::json::{self, JsonContent, Members, Value};
use tristrip::text::counted;

use crate::error::Error;

/// Maximum number of values in the JSON of a document.
pub(in crate::gltf) const JSON_VALUE_LIMIT: u64 = 4 << 20;

/// The JSON of a document and the text that it was parsed from.
#[derive(Debug, Clone, Default)]
pub(in crate::gltf) struct Document {
    pub(in crate::gltf) root: Members,
    text: SharedBytes,
}

impl Document {
    /// Parses a document and checks that it is glTF 2.
    pub(in crate::gltf) fn parse(text: SharedBytes) -> Result<Self, Error> {
        let root = root_of(text.as_slice())?;
        let version = Located::root(&root, "asset")?.need("version")?;
        if !version.text()?.starts_with("2.") {
            return Err(version.wrong("\"2.0\""));
        }
        Ok(Self { root, text })
    }

    /// Builds a document from new JSON.
    pub(in crate::gltf) fn of_members(root: Members) -> Self {
        Self { root, text: SharedBytes::default() }
    }

    /// Returns the JSON, with the source text of every unchanged value.
    pub(in crate::gltf) fn to_bytes(&self) -> Vec<u8> {
        let mut out = Vec::with_capacity(self.text.len());
        self.root.write(self.text.as_slice(), &mut out);
        out
    }

    /// Returns the JSON of a value, which was parsed from this document or built.
    pub(in crate::gltf) fn text_of(&self, value: &Value) -> Vec<u8> {
        let mut out = Vec::new();
        value.write(self.text.as_slice(), &mut out);
        out
    }

    /// Returns the document with the white space between its values removed.
    pub(in crate::gltf) fn without_spaces(self) -> Result<Self, Error> {
        let text = SharedBytes::from(json::without_spaces(&self.to_bytes()));
        Ok(Self { root: root_of(text.as_slice())?, text })
    }

    /// Reparses the current JSON, which drops the text of removed values.
    pub(in crate::gltf) fn compacted(self) -> Result<Self, Error> {
        let text = SharedBytes::from(self.to_bytes());
        Ok(Self { root: root_of(text.as_slice())?, text })
    }
}

fn root_of(json: &[u8]) -> Result<Members, Error> {
    // Each value except the first follows one of these characters. Those inside strings only make
    // the count too high.
    let values = json.iter().filter(|b| matches!(b, b',' | b'[' | b'{')).count() as u64;
    if values > JSON_VALUE_LIMIT {
        return Err(Error::LimitExceeded {
            at: "values of the JSON".into(),
            found: values,
            limit: JSON_VALUE_LIMIT,
        });
    }
    let root = json::parse(json)?;
    match root.content {
        JsonContent::Object(members) => Ok(members),
        _ => Err(Error::format("JSON", describe(&root), "an object")),
    }
}

/// A JSON value and its path in the document.
#[derive(Clone)]
pub(in crate::gltf) struct Located<'a> {
    pub(in crate::gltf) value: &'a Value,
    pub(in crate::gltf) at: String,
}

impl<'a> Located<'a> {
    /// Returns a member of the document.
    pub(in crate::gltf) fn root(root: &'a Members, name: &str) -> Result<Self, Error> {
        match root.get(name) {
            Some(value) => Ok(Self { value, at: name.to_owned() }),
            None => Err(Error::format(name, "nothing", "an object")),
        }
    }

    /// Iterates over the entries of a top-level array.
    pub(in crate::gltf) fn entries(
        root: &'a Members,
        list: &'static str,
    ) -> Result<impl Iterator<Item = Self>, Error> {
        let entries = array(root, list)?.iter().enumerate();
        Ok(entries.map(move |(i, value)| Self { value, at: format!("{list}[{i}]") }))
    }

    /// Returns an entry of a top-level array by index.
    pub(in crate::gltf) fn entry(root: &'a Members, list: &str, number: usize) -> Result<Self, Error> {
        let entries = array(root, list)?;
        let missing = || {
            let expected = format!("less than {}, the number of {list}", entries.len());
            Error::format(list, number.to_string(), expected)
        };
        let value = entries.get(number).ok_or_else(missing)?;
        Ok(Self { value, at: format!("{list}[{number}]") })
    }

    /// Returns the entry of a top-level array whose index is this value.
    pub(in crate::gltf) fn target(&self, root: &'a Members, list: &str) -> Result<Self, Error> {
        let (index, entries) = (self.size()?, array(root, list)?);
        match entries.get(index) {
            Some(value) => Ok(Self { value, at: format!("{list}[{index}]") }),
            None => Err(self.wrong(format!("less than {}, the number of {list}", entries.len()))),
        }
    }

    /// Returns a member, if it exists.
    pub(in crate::gltf) fn field(&self, name: &str) -> Option<Located<'a>> {
        let value = self.value.get(name)?;
        Some(Self { value, at: format!("{}.{name}", self.at) })
    }

    /// Returns a member that must exist.
    pub(in crate::gltf) fn need(&self, name: &str) -> Result<Located<'a>, Error> {
        self.field(name).ok_or_else(|| Error::format(format!("{}.{name}", self.at), "nothing", "a value"))
    }

    /// Returns the entries of an array.
    pub(in crate::gltf) fn items(&self) -> Result<impl Iterator<Item = Located<'a>> + use<'a>, Error> {
        let Some(items) = self.value.as_array() else { return Err(self.wrong("an array")) };
        let at = self.at.clone();
        Ok(items.iter().enumerate().map(move |(i, value)| Located { value, at: format!("{at}[{i}]") }))
    }

    /// Returns the members of an object.
    pub(in crate::gltf) fn members(
        &self,
    ) -> Result<impl Iterator<Item = (&'a str, Located<'a>)> + use<'a>, Error> {
        let Some(members) = self.value.as_object() else { return Err(self.wrong("an object")) };
        let at = self.at.clone();
        Ok(members.iter().map(move |(name, value)| (name, Located { value, at: format!("{at}.{name}") })))
    }

    /// Returns the value as a non-negative integer.
    pub(in crate::gltf) fn whole(&self) -> Result<u64, Error> {
        whole(self.value).ok_or_else(|| self.wrong("a non-negative integer"))
    }

    /// Returns the value as a size or an index.
    pub(in crate::gltf) fn size(&self) -> Result<usize, Error> {
        usize::try_from(self.whole()?).map_err(|_| self.wrong("a smaller number"))
    }

    /// Returns the value as a finite number.
    pub(in crate::gltf) fn number(&self) -> Result<f64, Error> {
        let found = match &self.value.content {
            JsonContent::Whole(number) => Some(*number as f64),
            JsonContent::Number(text) => text.parse().ok(),
            _ => None,
        };
        found.filter(|x| x.is_finite()).ok_or_else(|| self.wrong("a finite number"))
    }

    /// Returns the entries of an array of `N` finite numbers.
    pub(in crate::gltf) fn numbers<const N: usize>(&self) -> Result<[f64; N], Error> {
        let items = self.items()?.map(|item| item.number()).collect::<Result<Vec<_>, _>>()?;
        let found = items.len();
        let wrong = |_| Error::format(self.at.clone(), counted(found, "number"), format!("{N}"));
        items.try_into().map_err(wrong)
    }

    /// Returns the value as text.
    pub(in crate::gltf) fn text(&self) -> Result<&'a str, Error> {
        self.value.as_str().ok_or_else(|| self.wrong("a string"))
    }

    /// Returns the error for a value other than the expected one.
    pub(in crate::gltf) fn wrong(&self, expected: impl Into<String>) -> Error {
        Error::format(self.at.clone(), describe(self.value), expected)
    }

    /// Returns a size member, or the default if it is missing.
    pub(in crate::gltf) fn size_or(&self, name: &str, default: usize) -> Result<usize, Error> {
        self.field(name).map_or(Ok(default), |value| value.size())
    }
}

/// Returns the entries of a top-level array, or an empty slice if it is missing.
pub(in crate::gltf) fn array<'a>(root: &'a Members, list: &str) -> Result<&'a [Value], Error> {
    let Some(value) = root.get(list) else { return Ok(&[]) };
    value.as_array().ok_or_else(|| Error::format(list, describe(value), "an array"))
}

/// Returns a value as a non-negative integer. Some exporters write `3.0` for `3`.
pub(in crate::gltf) fn whole(value: &Value) -> Option<u64> {
    const EXACT: f64 = 9_007_199_254_740_992.0;
    match &value.content {
        JsonContent::Whole(number) => Some(*number),
        JsonContent::Number(text) => {
            let x: f64 = text.parse().ok()?;
            #[allow(clippy::cast_sign_loss, reason = "the range is checked")]
            (x.fract() == 0.0 && (0.0..EXACT).contains(&x)).then_some(x as u64)
        }
        _ => None,
    }
}

/// Returns the entries of a top-level array, creating it if it is missing.
pub(in crate::gltf) fn list_mut<'a>(root: &'a mut Members, list: &str) -> Result<&'a mut Vec<Value>, Error> {
    if !root.contains_key(list) {
        root.insert(list, Value::from(JsonContent::Array(Vec::new())));
    }
    array(root, list)?;
    let entries = root.get_mut(list).and_then(Value::as_array_mut);
    entries.ok_or_else(|| Error::format(list, "nothing", "an array"))
}

/// Returns the entries of a top-level array, or an empty slice if it is missing.
pub(in crate::gltf) fn entries_mut<'a>(root: &'a mut Members, list: &str) -> Result<&'a mut [Value], Error> {
    array(root, list)?;
    let entries = root.get_mut(list).and_then(Value::as_array_mut);
    Ok(entries.map(Vec::as_mut_slice).unwrap_or_default())
}

/// Returns the entries of a member array, or an empty slice if it is missing.
pub(in crate::gltf) fn items<'a>(value: &'a Value, name: &str) -> &'a [Value] {
    value.get(name).and_then(Value::as_array).unwrap_or_default()
}

/// Iterates over the values of an object's members.
pub(in crate::gltf) fn values(object: &Value) -> impl Iterator<Item = &Value> {
    object.as_object().into_iter().flat_map(Members::values)
}

/// Returns a value as an index.
pub(in crate::gltf) fn index(value: &Value) -> Option<usize> {
    usize::try_from(whole(value)?).ok()
}

/// Checks whether a document declares an extension.
pub(in crate::gltf) fn uses(root: &Members, extension: &str) -> bool {
    ["extensionsUsed", "extensionsRequired"].into_iter().any(|list| {
        let names = root.get(list).and_then(Value::as_array).unwrap_or_default();
        names.iter().any(|name| name.as_str() == Some(extension))
    })
}

/// Describes a value briefly for error messages.
fn describe(value: &Value) -> String {
    match &value.content {
        JsonContent::Null => "null".into(),
        JsonContent::Bool(b) => b.to_string(),
        JsonContent::Whole(n) => n.to_string(),
        JsonContent::Number(n) => n.chars().take(40).collect(),
        JsonContent::String(s) if s.chars().count() <= 40 => format!("{s:?}"),
        JsonContent::String(s) => format!("{:?}...", s.chars().take(40).collect::<String>()),
        JsonContent::Array(_) => "an array".into(),
        JsonContent::Object(_) => "an object".into(),
    }
}
