//! From lines to tables: positions, texture coordinates, normals, and faces that name them.

use std::collections::BTreeMap;

use rustc_hash::FxHashMap;
use tristrip::mesh::MAX_COUNT;

use super::split::split;
use crate::polygons::Polygons;
use crate::text::{Text, integer, quote};
use crate::{Error, Model};

/// Stands for "no texture coordinate" and "no normal" in the tables of corners.
pub(super) const NONE: u32 = u32::MAX;

/// The tables of a file.
#[derive(Debug, Default)]
pub(super) struct Tables {
    pub(super) positions: Vec<[f32; 3]>,
    /// Empty, or one for each position.
    pub(super) colours: Vec<[f32; 3]>,
    pub(super) texcoords: Vec<[f32; 2]>,
    pub(super) normals: Vec<[f32; 3]>,
    /// Corners name positions.
    pub(super) polygons: Polygons,
    /// Empty, or for each corner its texture coordinate.
    pub(super) texcoord_of: Vec<u32>,
    /// Empty, or for each corner its normal.
    pub(super) normal_of: Vec<u32>,
    /// In order of first use.
    pub(super) groups: Vec<Group>,
}

/// The faces of one material.
#[derive(Debug, Default)]
pub(super) struct Group {
    pub(super) name: Option<String>,
    pub(super) material: Option<String>,
    /// Ranges of faces, in order.
    pub(super) runs: Vec<(usize, usize)>,
}

/// Reads an OBJ file.
pub(crate) fn read(bytes: &[u8]) -> Result<Model, Error> {
    let mut parser = Parser::new(bytes, [MAX_COUNT; 3]);
    parser.run()?;
    let highest =
        |corners: &[u32]| corners.iter().filter(|&&i| i != NONE).max().map_or(0, |&i| i as usize + 1);
    let tables = &parser.tables;
    let named = [tables.polygons.corners(), &tables.texcoord_of, &tables.normal_of].map(highest);
    let present = [tables.positions.len(), tables.texcoords.len(), tables.normals.len()];
    if named.iter().zip(&present).any(|(named, present)| named > present) {
        // An index may name a line below its face, so only now is it known to be wrong; a second pass finds where it stands.
        Parser::new(bytes, present).run()?;
    }
    let mut notes = parser.notes();
    let parts = split(parser.tables, &mut notes)?;
    Ok(Model { parts, notes, scene: None })
}

struct Parser<'a> {
    text: Text<'a>,
    tables: Tables,
    /// The highest index, counted from 1, of positions, texture coordinates and normals.
    limits: [usize; 3],
    groups_by_material: FxHashMap<Option<&'a [u8]>, usize>,
    material: Option<&'a [u8]>,
    object: Option<&'a [u8]>,
    /// Group of the last face; `None` after a change of material.
    current: Option<usize>,
    object_lines: u64,
    dropped: BTreeMap<String, u64>,
    other_dropped: u64,
    extra_values: u64,
    replaced: u64,
}

impl<'a> Parser<'a> {
    fn new(bytes: &'a [u8], limits: [usize; 3]) -> Self {
        Self {
            text: Text::new(bytes).with_comments().with_continued_lines(),
            tables: Tables::default(),
            limits,
            groups_by_material: FxHashMap::default(),
            material: None,
            object: None,
            current: None,
            object_lines: 0,
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
                self.text.place(),
                "no line `v`",
                "vertices before the end of the file",
            ));
        }
        Ok(())
    }

    fn position(&mut self) -> Result<(), Error> {
        let position = [self.text.number("x")?, self.text.number("y")?, self.text.number("z")?];
        let mut extra = [1.0; 4];
        let mut count = 0;
        while let Some(word) = self.text.word() {
            let value = self.text.parse_number(word, "a colour or weight")?;
            if let Some(place) = extra.get_mut(count) {
                *place = value;
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
        // The third one is the depth of a volume texture.
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

    /// Reads a value of a texture coordinate or normal; one that is not finite has no meaning, and becomes 0.
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
            let mut named = [NONE; 2];
            for (kind, index) in named.iter_mut().enumerate() {
                match indices.next() {
                    None | Some([]) => {}
                    Some(text) => *index = self.index(text, word, kind + 1)?,
                }
            }
            if indices.next().is_some() {
                let expected = "at most three indices in a corner";
                return Err(Error::format(self.text.place(), quote(word), expected));
            }
            let tables = &mut self.tables;
            let before = tables.polygons.corners().len();
            for (column, index) in [(&mut tables.texcoord_of, named[0]), (&mut tables.normal_of, named[1])] {
                if index != NONE || !column.is_empty() {
                    column.resize(before, NONE);
                    column.push(index);
                }
            }
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

    /// Resolves an index of a corner to one counted from 0.
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

    /// Counts the positions, texture coordinates or normals so far.
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
            (Some(0), _) => format!("a {name} index from 1, or from -1 backwards"),
            (Some(1..), _) => format!("a {name} index from 1 to {}", self.limits[kind]),
            (Some(i), 0) => format!("a {name} index from 1: none came before {i}"),
            (Some(_), count) => format!("a {name} index of -{count} or more, for those so far"),
        };
        Error::format(self.text.place(), quote(word), expected)
    }

    fn group(&mut self) -> &mut Group {
        let groups = &mut self.tables.groups;
        let lossy = |name: &[u8]| String::from_utf8_lossy(name).into_owned();
        let index = *self.current.get_or_insert_with(|| {
            *self.groups_by_material.entry(self.material).or_insert_with(|| {
                let (name, material) = (self.object.map(lossy), self.material.map(lossy));
                groups.push(Group { name, material, runs: Vec::new() });
                groups.len() - 1
            })
        });
        &mut groups[index]
    }

    /// Counts a line whose keyword a mesh has no place for.
    fn drop_line(&mut self, word: &[u8]) -> Result<(), Error> {
        const MOST_KEYWORDS: usize = 32;
        const LONGEST_KEYWORD: usize = 32;
        if word.len() > LONGEST_KEYWORD || !word.iter().all(u8::is_ascii_graphic) {
            return Err(Error::format(self.text.place(), quote(word), "a keyword"));
        }
        let word = String::from_utf8_lossy(word);
        if let Some(count) = self.dropped.get_mut(word.as_ref()) {
            *count += 1;
        } else if self.dropped.len() < MOST_KEYWORDS {
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
                "mtllib" => format!("material libraries not read, materials keep their names: {count}"),
                _ => format!("lines `{word}` ignored: {count}"),
            })
            .collect();
        let mut add = |count: u64, what: &str| {
            if count > 0 {
                notes.push(format!("{what}: {count}"));
            }
        };
        add(self.other_dropped, "lines of other keywords ignored");
        add(self.extra_values, "weights and further values of vertices dropped");
        add(self.replaced, "values of texture coordinates and normals not finite, 0 in their place");
        if self.object_lines > 1 {
            notes.push(format!(
                "objects and groups joined, faces are kept by material: {}",
                self.object_lines
            ));
        }
        notes
    }
}
