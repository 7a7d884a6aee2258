//! Options have the same defaults in Rust, the command, Python and JavaScript.

#![expect(clippy::unwrap_used, reason = "a test that panics fails")]

use std::fs;
use std::path::PathBuf;

use tristrip::lod::{ModelKind, RepairOptions, View};
use tristrip::simplify::{MergeOrder, Price};
use tristrip::stream::{StreamLimits, StreamOptions};
use tristrip::vertex_cache::VertexCache;
use tristrip::{Cost, Method, StripifyOptions};
use tristrip_pipeline::{Deviation, chain::ChainRatios, levels::DisplayFilter, simplify, simplify::Normals};

use super::tristrip;

fn source(path: &str) -> String {
    fs::read_to_string(PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../..").join(path)).unwrap()
}

/// Returns the help of a flag, up to the next one, in one line.
fn help_of(subcommand: &str, flag: &str) -> String {
    let output = tristrip().env_remove("COLUMNS").args([subcommand, "--help"]).assert().success();
    let help = String::from_utf8(output.get_output().stdout.clone()).unwrap();
    // Flags are indented by 2 or 6 columns, their texts by 10.
    let is_flag = |line: &str| line.trim_start().starts_with('-') && !line.starts_with("          ");
    let names = |line: &str| line.split([' ', ',', '=']).any(|word| word == flag);
    let mut lines = help.lines().skip_while(|line| !(is_flag(line) && names(line)));
    let first = lines.next().unwrap_or_else(|| panic!("{subcommand} has no {flag}"));
    let rest = lines.take_while(|line| line.is_empty() || line.starts_with("          "));
    [first].into_iter().chain(rest).flat_map(str::split_whitespace).collect::<Vec<_>>().join(" ")
}

/// Returns the default of a flag; `None` if its help states none.
fn of_command(subcommand: &str, flag: &str) -> Option<String> {
    let help = help_of(subcommand, flag);
    let (_, default) = help.rsplit_once("[default: ")?;
    Some(default.split_once(']').unwrap().0.to_owned())
}

/// Returns the default of a parameter in the signature of a Python function, of a class or of the
/// module, as written.
fn of_python(function: &str, parameter: &str) -> String {
    let stub = source("bindings/python/python/tristrip/_native.pyi");
    let (class, name) = function.split_once('.').unwrap_or(("", function));
    let scope = match class {
        "" => stub.as_str(),
        class => stub.split_once(&format!("\nclass {class}:")).unwrap().1.split("\nclass ").next().unwrap(),
    };
    let def = if class.is_empty() { format!("\ndef {name}(") } else { format!(" def {name}(") };
    let signature = scope.split_once(&def).unwrap_or_else(|| panic!("no {function}")).1;
    let signature = signature.split_once("->").unwrap().0;
    let (_, rest) = signature
        .split_once(&format!("{parameter}: "))
        .unwrap_or_else(|| panic!("{function} has no {parameter}"));
    // The type may contain commas and brackets; the default follows the first ` = `.
    let rest = rest.split_once(" = ").unwrap_or_else(|| panic!("{function}: {parameter} has no default")).1;
    let end = match rest.chars().next() {
        Some('(') => rest.find(')').unwrap() + 1,
        Some('"') => rest[1..].find('"').unwrap() + 2,
        _ => rest.find([',', ')', '\n']).unwrap(),
    };
    rest[..end].trim_matches('"').to_owned()
}

#[test]
fn methods_and_efforts_have_one_default() {
    let effort = |method| StripifyOptions::default().with_method(method).effort_or_default().level();
    assert_eq!(effort(Method::Best), effort(Method::Cache));
    let efforts = format!("{}; for fewest {}", effort(Method::Best), effort(Method::Fewest));
    for subcommand in ["strip", "chain", "level", "camera-level", "build-lod"] {
        let method = StripifyOptions::default().method.to_string();
        assert_eq!(of_command(subcommand, "--method"), Some(method), "{subcommand}");
        assert_eq!(of_command(subcommand, "--effort"), Some(efforts.clone()), "{subcommand}");
    }
    assert_eq!(of_command("compare", "--effort"), Some(efforts));
    assert_eq!(of_command("compare", "--cost"), Some(Cost::default().to_string()));
    assert_eq!(of_command("compare", "--seed"), Some(StripifyOptions::default().seed.to_string()));
    for function in [
        "stripify",
        "Levels.__new__",
        "Scene.strip",
        "Scene.levels",
        "ViewModel.build",
        "ViewModel.from_scene",
    ] {
        assert_eq!(of_python(function, "method"), StripifyOptions::default().method.name(), "{function}");
        // None: the default of the method in Rust.
        assert_eq!(of_python(function, "effort"), "None", "{function}");
        assert_eq!(of_python(function, "cost"), "None", "{function}");
    }
    // None: "best", or "cache" for lists, as the command chooses.
    assert_eq!(of_python("Scene.chain", "method"), "None");
    assert_eq!(of_python("Scene.compare", "effort"), "None");
    assert_eq!(of_python("Scene.compare", "cost"), Cost::default().name());
    assert_eq!(of_python("Scene.compare", "seed"), StripifyOptions::default().seed.to_string());
    assert_eq!(of_python("Strips.vertex_cache", "cache"), VertexCache::default().to_string());
    assert!(!StripifyOptions::default().weld);
    for function in ["stripify", "Scene.strip", "Scene.chain", "Scene.compare", "Scene.bound"] {
        assert_eq!(of_python(function, "weld"), "False", "{function}");
    }
}

#[test]
fn simplification_has_one_default() {
    let rust = simplify::Options::default();
    let python = |flag: bool| if flag { "True" } else { "False" };
    for function in ["simplify", "Scene.simplify"] {
        assert_eq!(of_python(function, "fit"), python(rust.fit), "{function}");
        assert_eq!(of_python(function, "measure"), python(rust.measure), "{function}");
        assert_eq!(of_python(function, "verify"), python(rust.verify), "{function}");
        assert_eq!(of_python(function, "permissive"), python(rust.rules.permissive), "{function}");
        assert_eq!(of_python(function, "lock_borders"), python(rust.rules.lock_borders), "{function}");
        // None: the default in Rust, which the command states below.
        for parameter in ["error", "weight", "weld_distance", "ratio", "triangles"] {
            assert_eq!(of_python(function, parameter), "None", "{function}, {parameter}");
        }
    }
    assert!(!rust.fit && rust.measure && rust.verify, "the command has --fit and --no-verify");
    assert!(!help_of("simplify", "--fit").contains("[default"));
    assert_eq!(of_python("simplify", "normals_mode"), Normals::default().name());
    assert_eq!(of_python("Scene.simplify", "normals"), Normals::default().name());
    assert_eq!(of_command("simplify", "--normals"), Some(Normals::default().to_string()));
    for subcommand in ["simplify", "chain", "level", "camera-level"] {
        assert_eq!(of_command(subcommand, "--price"), Some(Price::default().to_string()), "{subcommand}");
    }
    for function in ["simplify", "Levels.__new__", "Scene.simplify", "Scene.chain", "Scene.levels"] {
        assert_eq!(of_python(function, "price"), Price::default().name(), "{function}");
    }
    for subcommand in ["simplify", "chain"] {
        let error: Deviation = of_command(subcommand, "--error").unwrap().parse().unwrap();
        assert_eq!(error, Deviation::default(), "{subcommand}");
        let weld: Deviation = of_command(subcommand, "--weld-distance").unwrap().parse().unwrap();
        assert_eq!(weld, rust.rules.weld_distance, "{subcommand}");
    }
    let ratios = ChainRatios::default().to_string();
    assert_eq!(
        (of_command("chain", "--ratios"), of_python("Scene.chain", "ratios")),
        (Some(ratios.clone()), ratios)
    );
}

#[test]
fn levels_have_one_default() {
    for function in ["Levels.__new__", "Scene.levels"] {
        assert_eq!(of_python(function, "model"), ModelKind::default().name(), "{function}");
    }
    // The command writes one level, which needs no model that moves between levels: it draws
    // filtered strips.
    assert_eq!(of_command("level", "--model"), None);
    assert_eq!(of_command("level", "--filter"), Some(DisplayFilter::default().to_string()));
    let effort = RepairOptions::default().effort.level().to_string();
    assert_eq!(of_command("level", "--filter-effort"), Some(effort));
    let (angle, rows) = (View::FIELD_OF_VIEW, View::ROWS);
    for subcommand in ["level", "camera-level"] {
        assert_eq!(of_command(subcommand, "--field-of-view"), Some(angle.to_string()), "{subcommand}");
    }
    assert_eq!(of_command("level", "--rows"), Some(rows.to_string()));
    for function in ["Levels.set_pixels", "View.set_view"] {
        assert_eq!(of_python(function, "field_of_view").parse(), Ok(angle), "{function}");
    }
    assert_eq!(of_python("Levels.set_pixels", "rows").parse(), Ok(rows));
    let numbers = |text: &str| -> Vec<f32> {
        text.split([',', '(', ')', 'x']).filter_map(|number| number.trim().parse().ok()).collect()
    };
    for (flag, parameter) in
        [("--up", "up"), ("--image", "image"), ("--pixels", "pixels"), ("--attention", "attention")]
    {
        let command = of_command("camera-level", flag).unwrap();
        assert_eq!(numbers(&command), numbers(&of_python("View.set_view", parameter)), "{flag}");
        assert!(!numbers(&command).is_empty(), "{flag}");
    }
    assert_eq!(of_command("build-lod", "--order"), Some(MergeOrder::default().to_string()));
    for function in ["ViewModel.build", "ViewModel.from_scene"] {
        assert_eq!(of_python(function, "order"), MergeOrder::default().name(), "{function}");
    }
}

#[test]
fn streams_have_one_default() {
    let bits = StreamOptions::default().position_bits.to_string();
    assert_eq!(of_command("pack", "--position-bits"), Some(bits));
    for function in ["pack", "Scene.pack"] {
        assert_eq!(of_python(function, "position_bits"), "None", "{function}");
        assert_eq!(of_python(function, "eye"), "None", "{function}");
    }
    let limits = StreamLimits::default();
    for parameter in ["max_bytes", "max_triangles"] {
        assert_eq!(of_python("Decoder.__new__", parameter), "None");
    }
    // `{ meshes: 256, triangles: 2 ** 26, … }`
    let decoder = source("web/src/decoder.js");
    let line = decoder.lines().find(|line| line.contains("LIMITS = {")).unwrap();
    let in_javascript = |name: &str| -> u64 {
        let value = line.split_once(&format!("{name}: ")).unwrap().1;
        let value = value.split([',', '}']).next().unwrap().trim();
        match value.split_once(" ** ") {
            Some((base, power)) => base.parse::<u64>().unwrap().pow(power.parse().unwrap()),
            None => value.parse().unwrap(),
        }
    };
    assert_eq!(in_javascript("meshes"), limits.meshes as u64);
    assert_eq!(in_javascript("triangles"), limits.triangles as u64);
    assert_eq!(in_javascript("chunkBytes"), limits.chunk_bytes as u64);
    assert_eq!(in_javascript("corners"), limits.corners);
}

#[cfg(feature = "serve")]
#[test]
fn the_server_has_one_default() {
    let options = tristrip_serve::ServerOptions::default();
    let (limits, packing) = (&options.limits, &options.packing);
    let time = |time| humantime::format_duration(time).to_string();
    for (flag, default) in [
        ("--address", options.address.to_string()),
        ("--port", options.port.to_string()),
        ("--largest-input", format!("{}M", packing.largest_input_bytes >> 20)),
        ("--cache-bytes", format!("{}G", packing.cache_bytes >> 30)),
        ("--connections", limits.connections.to_string()),
        ("--connections-per-client", limits.connections_per_client.to_string()),
        ("--header-bytes", format!("{}K", limits.header_bytes >> 10)),
        ("--header-time", time(limits.header_time)),
        ("--stall-time", time(limits.stall_time)),
        ("--idle-time", time(limits.idle_time)),
        ("--wait-time", time(packing.wait_time)),
        ("--grace-time", time(limits.grace_time)),
    ] {
        assert_eq!(of_command("serve", flag), Some(default), "{flag}");
    }
}
