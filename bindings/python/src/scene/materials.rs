//! Materials as dictionaries with the keys "base_color", "base_color_image", "metallic",
//! "roughness", "blend" and "name".

use std::sync::Arc;

use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict, PyString};
use tristrip_io::PlainMaterial;

use crate::errors::Failure;

/// A material passed for a part: its name, and its properties unless only the name is known.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct NamedMaterial {
    pub(crate) name: Option<String>,
    pub(crate) plain: Option<PlainMaterial>,
}

impl NamedMaterial {
    /// Reads a name or a dictionary.
    pub(crate) fn of(given: Option<&Bound<'_, PyAny>>) -> Result<Self, Failure> {
        let Some(given) = given else { return Ok(Self::default()) };
        if let Ok(name) = given.cast::<PyString>() {
            return Ok(Self { name: Some(name.to_string()), plain: None });
        }
        let Ok(given) = given.cast::<PyDict>() else {
            let found = crate::arrays::type_name(given);
            return Err(Failure::Type(format!("material: found {found}, expected a name or a dictionary")));
        };
        let mut plain = PlainMaterial::default();
        let mut name = None;
        let mut says_blend = false;
        for (key, value) in given.iter() {
            let key: String = key.extract()?;
            if value.is_none() {
                continue;
            }
            match key.as_str() {
                "name" => name = Some(value.str()?.to_string()),
                "base_color" => plain.base_colour = colour(&value)?,
                "metallic" => plain.metalness = fraction("metallic", &value)?,
                "roughness" => plain.roughness = fraction("roughness", &value)?,
                "blend" => (plain.is_blended, says_blend) = (value.extract()?, true),
                "base_color_image" => plain.image = Some(image(&value)?),
                _ => {
                    let expected = "name, base_color, base_color_image, metallic, roughness or blend";
                    return Err(Failure::option("material", format!("key {key:?}"), expected));
                }
            }
        }
        if !says_blend {
            plain.is_blended = plain.base_colour[3] < 1.0;
        }
        Ok(Self { name, plain: Some(plain) })
    }
}

/// Reads three or four numbers from 0 to 1, or 8-bit integers.
fn colour(given: &Bound<'_, PyAny>) -> Result<[f32; 4], Failure> {
    let wrong = || Failure::option("material: base_color", given, "three or four numbers from 0 to 1");
    let mut colour = [1.0_f32; 4];
    let mut count = 0;
    for number in given.try_iter().map_err(|_| wrong())? {
        *colour.get_mut(count).ok_or_else(wrong)? = number?.extract().map_err(|_| wrong())?;
        count += 1;
    }
    if count < 3 || !colour.iter().all(|x| (0.0..=1.0).contains(x)) {
        return Err(wrong());
    }
    Ok(colour)
}

fn fraction(name: &str, given: &Bound<'_, PyAny>) -> Result<f32, Failure> {
    let number: Option<f32> = given.extract().ok();
    let expected = "a number from 0 to 1";
    let number = number.filter(|x| (0.0..=1.0).contains(x));
    number.ok_or_else(|| Failure::option(&format!("material: {name}"), given, expected))
}

/// Reads an encoded image.
fn image(given: &Bound<'_, PyAny>) -> Result<Arc<Vec<u8>>, Failure> {
    let name = "material: base_color_image";
    let bytes: Vec<u8> = match given.cast::<PyBytes>() {
        Ok(bytes) => bytes.as_bytes().to_vec(),
        Err(_) => given.extract().map_err(|_| {
            Failure::Type(format!("{name}: found {}, expected bytes", crate::arrays::type_name(given)))
        })?,
    };
    if !bytes.starts_with(b"\x89PNG\r\n\x1a\n") && !bytes.starts_with(b"\xff\xd8\xff") {
        return Err(Failure::option(name, "other bytes", "the bytes of a PNG or JPEG"));
    }
    Ok(Arc::new(bytes))
}

/// Returns the properties of a material as a dictionary.
pub(crate) fn dictionary<'py>(py: Python<'py>, material: &PlainMaterial) -> PyResult<Bound<'py, PyDict>> {
    let found = PyDict::new(py);
    let [red, green, blue, alpha] = material.base_colour;
    found.set_item("base_color", (red, green, blue, alpha))?;
    let image = material.image.as_ref().map(|image| PyBytes::new(py, image));
    found.set_item("base_color_image", image)?;
    found.set_item("metallic", material.metalness)?;
    found.set_item("roughness", material.roughness)?;
    found.set_item("blend", material.is_blended)?;
    Ok(found)
}
