//! Document text: foreign data stays byte-identical when indices are written.

use tristrip::{Layout, Strips};
use tristrip_io::{Drawing, Format, gltf, write};

use crate::gltf_documents::*;

/// Values in spellings that a JSON library may change or misread. Each must be in the output
/// unchanged.
const ODD: [&str; 10] = [
    r#"{ "$serde_json::private::Number" : "12" }"#,
    r#"{"$serde_json::private::Number":"not a number"}"#,
    r#"{"$serde_json::private::RawValue":"[1, 2"}"#,
    r#"{"$serde_json::private::RawValue":"[1,2]"}"#,
    "[ 1E5, -0.0, 1.50, 2e+03, 1e-400, 1e400, 0.1000000000000000055511151231257827 ]",
    "123456789012345678901234567890.123456789012345678901234567890",
    r#""\u0041\/\u00e9\ud83d\ude00 é 😀 \n""#,
    r#"{"twice":1,"twice":2}"#,
    r#"{"\u006bey" :[ ], "" : { } }"#,
    "\t[true ,\r\n false, null]",
];

/// Returns a document of two triangles, with the odd values wherever foreign data may occur.
fn odd_document() -> Vec<u8> {
    let list = |name: &str| {
        let members: Vec<String> = (0..).zip(ODD).map(|(i, odd)| format!("\"{name}{i}\":{odd}")).collect();
        members.join(" ,")
    };
    let json = format!(
        r#"{{
  "asset": {{"version":"2.0" , "extras":{{{root}}} }},
  "extensionsUsed":["EXT_odd"],
  "materials": [ {{"emissiveFactor":[1E0, 0.50, 0e0], "name":"\u0041"}} ],
  "nodes":[{{"mesh":0,"translation":[1.0, -0.0, 1E+2]}}],
  "meshes":[{{ "na\u006de":"\u0041", "extras":{{{mesh}}}, "primitives":[
    {{"attributes":{{"POSITION":0e0}},"indices":1.0 , "material":0, "extras":{{{primitive}}}, "extensions":{{"EXT_odd":{{{extension}}}}} }}] }}],
  "accessors":[{{"bufferView":0,"componentType":5126,"count":4.0,"type":"VEC3" , "min":[0.0,0E0,0],"max":[3.00,6,2]}},
    {{"bufferView":1,"componentType":5125,"count":6,"type":"SCALAR","extras":{{{accessor}}} }}],
  "bufferViews":[{{"buffer":0,"byteLength":4.8e1 }},{{"buffer":0,"byteOffset":48,"byteLength":24}}],
  "buffers":[{{"byteLength":72,"extras":{{{buffer}}} }}]
}}"#,
        root = list("root"),
        mesh = list("mesh"),
        primitive = list("primitive"),
        extension = list("extension"),
        accessor = list("accessor"),
        buffer = list("buffer"),
    );
    let mut bin = floats(bent(4).as_flattened());
    bin.extend(packed(U32, &[0, 1, 2, 2, 1, 3]));
    glb_of(json.as_bytes(), Some(&bin))
}

#[test]
fn what_is_not_ours_stays_byte_for_byte() {
    let model = gltf::read(odd_document(), None).unwrap();
    let mut strips = Strips::default();
    strips.push(&[0, 1, 2]);
    strips.push(&[2, 1, 3]);
    for layout in [Layout::Degenerate, Layout::Restart, Layout::Separate, Layout::List] {
        let glb = write(&model, &[Drawing::Strips(&strips)], Format::Glb, layout).unwrap();
        let length = u32::from_le_bytes(glb[12..16].try_into().unwrap()) as usize;
        let json = String::from_utf8(glb[20..20 + length].to_vec()).unwrap();
        let mut expected = vec![
            "\"materials\":[ {\"emissiveFactor\":[1E0, 0.50, 0e0], \"name\":\"\\u0041\"} ]".to_owned(),
            "\"nodes\":[{\"mesh\":0,\"translation\":[1.0, -0.0, 1E+2]}]".to_owned(),
            "\"na\\u006de\":\"\\u0041\"".to_owned(),
            "\"attributes\":{\"POSITION\":0e0}".to_owned(),
            "{\"buffer\":0,\"byteLength\":4.8e1 }".to_owned(),
            "\"min\":[0.0,0E0,0],\"max\":[3.00,6,2]".to_owned(),
        ];
        for place in ["root", "mesh", "primitive", "extension", "accessor", "buffer"] {
            expected.extend((0..).zip(ODD).map(|(i, odd)| format!("\"{place}{i}\":{odd}")));
        }
        for text in expected {
            assert!(json.contains(&text), "{layout:?}: {text}\nis not in\n{json}");
        }
        let again = gltf::read(glb, None).unwrap();
        let drawn: Vec<_> = (0..again.parts.len()).flat_map(|part| triangles(&again, part)).collect();
        assert_eq!(drawn, triangles(&model, 0));
    }
}

#[test]
fn a_document_in_one_file_keeps_its_text_without_the_data() {
    let gltf = r#"{"asset":{"version":"2.0"},"buffers":[{"byteLength":3,"uri":"data:;base64,AAAA", "extras": 1E5 }],
        "extras":{ "uri" : -0.0}}"#;
    let glb =
        write(&gltf::read(gltf.as_bytes(), None).unwrap(), &[], Format::Glb, Layout::Degenerate).unwrap();
    let json = String::from_utf8_lossy(&glb);
    assert!(json.contains(r#""buffers":[{"byteLength":3,"extras":1E5}]"#), "{json}");
    assert!(json.contains(r#""extras":{ "uri" : -0.0}"#), "{json}");
}
