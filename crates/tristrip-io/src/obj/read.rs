//! Parses the lines of a file into tables.

use std::collections::BTreeMap;

use rustc_hash::FxHashMap;
use tristrip::MAX_COUNT;

use super::split::split;
use super::tables::{MaterialGroup, ObjTables, OptionalIndex};
use crate::error::Error;
use crate::materials::Materials;
use crate::model::Model;
use crate::text::{Text, integer, quote};

/// Maximum number of material libraries of a file; further ones are ignored.
const MAX_LIBRARIES: usize = 64;

/// Maximum length of a material library's name in bytes. Longer names are ignored, because no file
/// system supports such paths.
const LONGEST_NAME: usize = 4096;

/// Reads an OBJ file.
pub(crate) fn read(bytes: &[u8]) -> Result<Model, Error> {
    let mut parser = ObjParser::new(bytes, [MAX_COUNT; 3]);
    parser.run()?;
    let tables = &parser.tables;
    let highest = [
        tables.polygons.corners().iter().copied().max(),
        tables.texcoord_of.highest(),
        tables.normal_of.highest(),
    ];
    let counts = [tables.positions.len(), tables.texcoords.len(), tables.normals.len()];
    if highest.iter().zip(&counts).any(|(highest, &count)| highest.is_some_and(|i| i as usize >= count)) {
        // An index may refer to a later line, so an error is only known now. A second pass finds
        // its line.
        ObjParser::new(bytes, counts).run()?;
    }
    let mut notes = parser.notes();
    let libraries = std::mem::take(&mut parser.libraries);
    let parts = split(parser.tables, &mut notes)?;
    Ok(Model { parts, notes, scene: None, materials: Some(Materials::new(libraries)) })
}

struct ObjParser<'a> {
    text: Text<'a>,
    tables: ObjTables,
    /// The maximum index of positions, texture coordinates and normals, counted from 1.
    limits: [usize; 3],
    groups_by_material: FxHashMap<Option<&'a [u8]>, usize>,
    material: Option<&'a [u8]>,
    object: Option<&'a [u8]>,
    /// The group of the last face; `None` after a change of material.
    current: Option<usize>,
    object_lines: u64,
    /// The names of material libraries, without duplicates.
    libraries: Vec<String>,
    dropped: BTreeMap<String, u64>,
    other_dropped: u64,
    extra_values: u64,
    replaced: u64,
}

impl<'a> ObjParser<'a> {
    fn new(bytes: &'a [u8], limits: [usize; 3]) -> Self {
        Self {
            text: Text::new(bytes).with_comments().with_continued_lines(),
            tables: ObjTables::default(),
            limits,
            groups_by_material: FxHashMap::default(),
            material: None,
            object: None,
            current: None,
            object_lines: 0,
            libraries: Vec::new(),
            dropped: BTreeMap::new(),
            other_dropped: 0,
            extra_values: 0,
            replaced: 0,
        }
    }

    fn run(&mut self) -> Result<(), Error> {
        loop {
            match self.text.word() {
                None => {}
                Some(b"v") => self.position()?,
                Some(b"vt") => self.texcoord()?,
                Some(b"vn") => self.normal()?,
                Some(b"f" | b"fo") => self.face()?,
                Some(b"usemtl") => {
                    let name = self.text.rest();
                    self.material = (!name.is_empty()).then_some(name);
                    self.current = None;
                }
                Some(b"mtllib") => self.library(),
                Some(b"o" | b"g") => {
                    let name = self.text.rest();
                    self.object = if name.is_empty() { self.object } else { Some(name) };
                    self.object_lines += 1;
                }
                Some(word) => self.drop_line(word)?,
            }
            if !self.text.next_line() {
                break;
            }
        }
        if self.tables.positions.is_empty() {
            return Err(Error::format(
                self.text.position(),
                "no line `v`",
                "vertices before the end of the file",
            ));
        }
        Ok(())
    }

    /// Adds a material library. The name may contain spaces; `./` in its path is removed to detect
    /// duplicates.
    fn library(&mut self) {
        let name = String::from_utf8_lossy(self.text.rest()).trim().replace('\\', "/");
        let is_kept =
            |&(number, folder): &(usize, &str)| folder != "." && (number == 0 || !folder.is_empty());
        let folders: Vec<&str> =
            name.split('/').enumerate().filter(is_kept).map(|(_, folder)| folder).collect();
        let name = folders.join("/");
        let is_name = !name.is_empty() && name.len() <= LONGEST_NAME;
        if is_name && !self.libraries.contains(&name) && self.libraries.len() < MAX_LIBRARIES {
            self.libraries.push(name);
        }
    }

    fn position(&mut self) -> Result<(), Error> {
        let position = [self.text.number("x")?, self.text.number("y")?, self.text.number("z")?];
        let mut extra = [1.0; 4];
        let mut count = 0;
        while let Some(word) = self.text.word() {
            let value = self.text.parse_number(word, "a colour or weight")?;
            if let Some(slot) = extra.get_mut(count) {
                *slot = value;
            }
            count += 1;
        }
        let tables = &mut self.tables;
        let has_colour = count == 3 || count == 4;
        if has_colour || !tables.colours.is_empty() {
            // Vertices without a colour are white.
            tables.colours.resize(tables.positions.len(), [1.0; 3]);
            let [r, g, b, _] = extra;
            tables.colours.push(if has_colour { [r, g, b] } else { [1.0; 3] });
        }
        self.extra_values += if has_colour { count as u64 - 3 } else { count as u64 };
        tables.positions.push(position);
        Ok(())
    }

    fn texcoord(&mut self) -> Result<(), Error> {
        let u = self.value("u")?;
        let v = match self.text.word() {
            Some(word) => self.parse_value(word, "v")?,
            None => 0.0,
        };
        // The third value is the depth of a volume texture.
        if let Some(word) = self.text.word() {
            self.extra_values += u64::from(self.parse_value(word, "w")? != 0.0);
        }
        self.tables.texcoords.push([u, v]);
        Ok(())
    }

    fn normal(&mut self) -> Result<(), Error> {
        let normal = [self.value("x")?, self.value("y")?, self.value("z")?];
        self.tables.normals.push(normal);
        Ok(())
    }

    /// Reads a value of a texture coordinate or normal. A value that is not finite becomes 0.
    fn value(&mut self, what: &str) -> Result<f32, Error> {
        match self.text.word() {
            Some(word) => self.parse_value(word, what),
            None => Err(self.text.missing(&format!("a number for {what}"))),
        }
    }

    fn parse_value(&mut self, word: &[u8], what: &str) -> Result<f32, Error> {
        match fast_float2::parse::<f32, _>(word) {
            Ok(value) if value.is_finite() => Ok(value),
            Ok(_) => {
                self.replaced += 1;
                Ok(0.0)
            }
            Err(_) => self.text.parse_number(word, what),
        }
    }

    fn face(&mut self) -> Result<(), Error> {
        while let Some(word) = self.text.word() {
            let mut indices = word.split(|&byte| byte == b'/');
            let v = self.index(indices.next().unwrap_or_default(), word, 0)?;
            let mut optional = [OptionalIndex::NONE; 2];
            for (kind, index) in optional.iter_mut().enumerate() {
                match indices.next() {
                    None | Some([]) => {}
                    Some(text) => *index = self.index(text, word, kind + 1)?.into(),
                }
            }
            if indices.next().is_some() {
                let expected = "at most three indices in a corner";
                return Err(Error::format(self.text.position(), quote(word), expected));
            }
            let tables = &mut self.tables;
            let corner = tables.polygons.corners().len();
            tables.texcoord_of.push(corner, optional[0]);
            tables.normal_of.push(corner, optional[1]);
            tables.polygons.push(v);
        }
        let face = self.tables.polygons.face_count();
        self.tables.polygons.end_face();
        let group = self.group();
        match group.runs.last_mut() {
            Some((_, end)) if *end == face => *end += 1,
            _ => group.runs.push((face, face + 1)),
        }
        Ok(())
    }

    /// Converts an index of a corner to one counted from 0.
    fn index(&self, index: &[u8], word: &[u8], kind: usize) -> Result<u32, Error> {
        let parsed = integer(index);
        let resolved = match parsed {
            Some(i @ 1..) => usize::try_from(i).ok().filter(|&i| i <= self.limits[kind]).map(|i| i - 1),
            Some(i @ ..=-1) => {
                usize::try_from(i.unsigned_abs()).ok().and_then(|back| self.count(kind).checked_sub(back))
            }
            Some(0) | None => None,
        };
        resolved.map(|i| i as u32).ok_or_else(|| self.wrong_index(parsed, word, kind))
    }

    /// Returns the number of positions, texture coordinates or normals so far.
    fn count(&self, kind: usize) -> usize {
        match kind {
            0 => self.tables.positions.len(),
            1 => self.tables.texcoords.len(),
            _ => self.tables.normals.len(),
        }
    }

    #[cold]
    fn wrong_index(&self, index: Option<i64>, word: &[u8], kind: usize) -> Error {
        let name = ["vertex", "texture coordinate", "normal"][kind];
        let expected = match (index, self.count(kind)) {
            (None, _) => format!("an integer as {name} index"),
            (Some(0), _) => format!("a {name} index of at least 1, or at most -1"),
            (Some(1..), _) => format!("a {name} index from 1 to {}", self.limits[kind]),
            (Some(_), 0) => format!("a {name} index of at least 1: there is no {name} before this line"),
            (Some(_), count) => format!("a {name} index of at least -{count}, the number so far"),
        };
        Error::format(self.text.position(), quote(word), expected)
    }

    fn group(&mut self) -> &mut MaterialGroup {
        let groups = &mut self.tables.groups;
        let lossy = |name: &[u8]| String::from_utf8_lossy(name).into_owned();
        let index = *self.current.get_or_insert_with(|| {
            *self.groups_by_material.entry(self.material).or_insert_with(|| {
                let (name, material) = (self.object.map(lossy), self.material.map(lossy));
                groups.push(MaterialGroup { name, material, runs: Vec::new() });
                groups.len() - 1
            })
        });
        &mut groups[index]
    }

    /// Counts a line whose content a mesh cannot represent.
    fn drop_line(&mut self, word: &[u8]) -> Result<(), Error> {
        const MAX_KEYWORDS: usize = 32;
        const LONGEST_KEYWORD: usize = 32;
        if word.len() > LONGEST_KEYWORD || !word.iter().all(u8::is_ascii_graphic) {
            return Err(Error::format(self.text.position(), quote(word), "a keyword"));
        }
        let word = String::from_utf8_lossy(word);
        if let Some(count) = self.dropped.get_mut(word.as_ref()) {
            *count += 1;
        } else if self.dropped.len() < MAX_KEYWORDS {
            self.dropped.insert(word.into_owned(), 1);
        } else {
            self.other_dropped += 1;
        }
        Ok(())
    }

    fn notes(&self) -> Vec<String> {
        let mut notes: Vec<String> = self
            .dropped
            .iter()
            .map(|(word, count)| match word.as_str() {
                "l" => format!("line elements dropped: {count}"),
                "p" => format!("point elements dropped: {count}"),
                "s" => format!("smoothing groups dropped: {count}"),
                _ => format!("lines `{word}` ignored: {count}"),
            })
            .collect();
        let mut add = |count: u64, what: &str| {
            if count > 0 {
                notes.push(format!("{what}: {count}"));
            }
        };
        add(self.other_dropped, "lines with other keywords ignored");
        add(self.extra_values, "weights and additional values of vertices dropped");
        add(self.replaced, "texture coordinates and normals that are not finite, replaced by 0");
        if self.object_lines > 1 {
            notes
                .push(format!("objects and groups merged, faces grouped by material: {}", self.object_lines));
        }
        notes
    }
}
