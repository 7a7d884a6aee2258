//! The header: elements, their row counts, and the properties of their rows.

use crate::error::Error;
use crate::text::{Text, integer, quote};

/// The encoding of the rows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum PlyEncoding {
    Ascii,
    Little,
    Big,
}

/// The type of a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Scalar {
    /// Returns the size of a binary number in bytes.
    pub(super) fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    /// Checks whether this is a floating-point type.
    pub(super) fn is_float(self) -> bool {
        matches!(self, Self::F32 | Self::F64)
    }

    fn from_name(name: &[u8]) -> Option<Self> {
        Some(match name {
            b"char" | b"int8" => Self::I8,
            b"uchar" | b"uint8" => Self::U8,
            b"short" | b"int16" => Self::I16,
            b"ushort" | b"uint16" => Self::U16,
            b"int" | b"int32" => Self::I32,
            b"uint" | b"uint32" => Self::U32,
            b"float" | b"float32" => Self::F32,
            b"double" | b"float64" => Self::F64,
            _ => return None,
        })
    }
}

/// A number, or a list of numbers, in each row of an element.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Property {
    pub(super) name: String,
    /// The type of a list's count; `None` for a single number.
    pub(super) count: Option<Scalar>,
    pub(super) value: Scalar,
}

/// A table of rows.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Element {
    pub(super) name: String,
    pub(super) row_count: u64,
    pub(super) properties: Vec<Property>,
    /// The line of the header that declares it.
    pub(super) line: u64,
}

impl Element {
    /// Returns the index of the property named `name`.
    pub(super) fn find(&self, name: &str) -> Option<usize> {
        self.properties.iter().position(|property| property.name == name)
    }

    /// Describes the position of the element's declaration.
    pub(super) fn position(&self) -> String {
        format!("line {}", self.line)
    }
}

/// The content of the header.
#[derive(Debug)]
pub(super) struct PlyHeader {
    pub(super) encoding: PlyEncoding,
    pub(super) elements: Vec<Element>,
    /// The offset of the first row in bytes.
    pub(super) body: usize,
    /// The line number of the first row.
    pub(super) body_line: u64,
}

/// Reads the header.
pub(super) fn read(bytes: &[u8]) -> Result<PlyHeader, Error> {
    let mut text = Text::new(bytes);
    match text.word() {
        Some(b"ply") if bytes.starts_with(b"ply") => {}
        Some(b"ply") => {
            return Err(Error::format(
                "byte 0",
                "other bytes before `ply`",
                "`ply` as the first three bytes",
            ));
        }
        Some(word) => return Err(Error::format("line 1", quote(word), "`ply`")),
        None => return Err(text.missing("`ply`")),
    }
    let mut encoding = None;
    let mut elements: Vec<Element> = Vec::new();
    loop {
        if !text.next_line() {
            return Err(text.missing("a line `end_header`"));
        }
        match text.word() {
            None | Some(b"comment" | b"obj_info") => {}
            Some(b"format") => encoding = Some(read_format(&mut text)?),
            Some(b"element") => {
                let element = read_element(&mut text)?;
                if elements.iter().any(|other| other.name == element.name) {
                    let found = format!("a second element `{}`", element.name);
                    return Err(Error::format(text.position(), found, "elements with different names"));
                }
                elements.push(element);
            }
            Some(b"property") => {
                let property = read_property(&mut text)?;
                let Some(element) = elements.last_mut() else {
                    let expected = "an `element` line before it";
                    return Err(Error::format(text.position(), "`property`", expected));
                };
                if element.find(&property.name).is_some() {
                    let found = format!("a second property `{}`", property.name);
                    return Err(Error::format(text.position(), found, "properties with different names"));
                }
                element.properties.push(property);
            }
            Some(b"end_header") => break,
            Some(word) => {
                let expected = "`format`, `comment`, `element`, `property` or `end_header`";
                return Err(Error::format(text.position(), quote(word), expected));
            }
        }
    }
    let Some(encoding) = encoding else {
        return Err(Error::format(text.position(), "`end_header`", "a line `format` before it"));
    };
    let end = text.offset();
    let line = text.line() + 1;
    text.next_line();
    // If lines end with CR alone, an LF after the last CR is already the first byte of the rows.
    let body = if bytes[..end].contains(&b'\n') { text.offset() } else { bytes.len().min(end + 1) };
    Ok(PlyHeader { encoding, elements, body, body_line: line })
}

fn read_format(text: &mut Text) -> Result<PlyEncoding, Error> {
    let expected = "`ascii`, `binary_little_endian` or `binary_big_endian`";
    let encoding = match text.word() {
        Some(b"ascii") => PlyEncoding::Ascii,
        Some(b"binary_little_endian") => PlyEncoding::Little,
        Some(b"binary_big_endian") => PlyEncoding::Big,
        Some(word) => return Err(Error::format(text.position(), quote(word), expected)),
        None => return Err(text.missing(expected)),
    };
    match text.word() {
        Some(b"1.0") => Ok(encoding),
        Some(word) => Err(Error::format(text.position(), quote(word), "version `1.0`")),
        None => Err(text.missing("version `1.0`")),
    }
}

fn read_element(text: &mut Text) -> Result<Element, Error> {
    let name = name(text, "an element's name")?;
    let expected = "a number of rows";
    let word = text.word().ok_or_else(|| text.missing(expected))?;
    let row_count = integer(word)
        .and_then(|count| u64::try_from(count).ok())
        .ok_or_else(|| Error::format(text.position(), quote(word), expected))?;
    Ok(Element { name, row_count, properties: Vec::new(), line: text.line() })
}

fn read_property(text: &mut Text) -> Result<Property, Error> {
    let word = text.word().ok_or_else(|| text.missing("a property's type"))?;
    let count = if word == b"list" { Some(scalar(text, None)?) } else { None };
    if count.is_some_and(Scalar::is_float) {
        return Err(Error::format(text.position(), "a list with a fractional count", "an integer type"));
    }
    let value = scalar(text, count.is_none().then_some(word))?;
    Ok(Property { name: name(text, "a property's name")?, count, value })
}

fn scalar(text: &mut Text, word: Option<&[u8]>) -> Result<Scalar, Error> {
    let expected = "a number type such as `float` or `uint8`";
    let word = match word {
        Some(word) => word,
        None => text.word().ok_or_else(|| text.missing(expected))?,
    };
    Scalar::from_name(word).ok_or_else(|| Error::format(text.position(), quote(word), expected))
}

fn name(text: &mut Text, what: &str) -> Result<String, Error> {
    let word = text.word().ok_or_else(|| text.missing(what))?;
    Ok(String::from_utf8_lossy(word).into_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reads_types_lists_and_line_ends() {
        for end in ["\n", "\r\n", "\r"] {
            let text = [
                "ply",
                "format binary_big_endian 1.0",
                "comment hello",
                "element vertex 7",
                "property float64 x",
                "element face 1",
                "property list uint8 int vertex_index",
                "end_header",
                "\nrows",
            ];
            let bytes = text.join(end);
            let header = read(bytes.as_bytes()).unwrap();
            assert_eq!(header.encoding, PlyEncoding::Big);
            assert_eq!(&bytes.as_bytes()[header.body..], b"\nrows", "{end:?}");
            assert_eq!(header.body_line, 9);
            let [vertex, face] = &header.elements[..] else { panic!() };
            assert_eq!((vertex.row_count, vertex.properties[0].value), (7, Scalar::F64));
            assert_eq!(face.properties[0].count, Some(Scalar::U8));
        }
    }
}
