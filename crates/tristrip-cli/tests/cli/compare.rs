//! `tristrip compare`: the table, its marks, and its JSON and Markdown forms.

use super::{json, keys, model, tristrip};
use predicates::prelude::*;
use predicates::str::contains;

#[test]
fn every_method_has_a_proven_row() {
    let report = json(tristrip().args(["compare", "--json"]).arg(model("fish_control.ply")));
    assert_eq!(keys(&report), ["file", "seconds", "mesh", "parts", "notes", "methods", "error"]);
    let methods = report["methods"].as_array().unwrap();
    assert!(methods.iter().all(|row| row["proven"] == true && row["triangles"] == 220));
    assert_eq!(keys(&methods[0])[..5], ["method", "cost", "effort", "seed", "proven"]);
    let all = json(tristrip().args(["compare", "--json", "--all"]).arg(model("fish_control.ply")));
    assert_eq!(all["methods"].as_array().unwrap().len(), 11 + 24 + 10, "each method once");
    let efforts =
        json(tristrip().args(["compare", "--json", "--effort", "3"]).arg(model("fish_control.ply")));
    assert_eq!(efforts["methods"].as_array().unwrap().len(), methods.len() + 1, "best at two efforts");
}

#[test]
fn best_is_never_worse_than_its_initial_methods() {
    for name in ["fish_control.ply", "hand.ply", "wingnut.ply", "catmark_bishop.ply"] {
        let report = json(tristrip().args(["compare", "--json"]).arg(model(name)));
        let cost = |method: &str| {
            let rows = report["methods"].as_array().unwrap();
            let row = rows.iter().find(|row| row["method"] == method).unwrap();
            row["indices_restart"].as_u64().unwrap()
        };
        assert!(cost("best") <= cost("input") && cost("best") <= cost("sequential"), "{name}");
    }
}

#[test]
fn each_model_has_a_table() {
    tristrip()
        .arg("compare")
        .arg(model("fish_control.ply"))
        .arg(model("catmark_bishop.ply"))
        .assert()
        .success()
        .stdout(contains("fish_control.ply: 220 triangles\nmethod "))
        .stdout(contains("catmark_bishop.ply: 1,804 triangles\nmethod "))
        .stdout(contains("stripe-global:patches=full").and(contains("* best in its column")));
    tristrip()
        .args(["compare", "--markdown"])
        .arg(model("fish_control.ply"))
        .assert()
        .success()
        .stdout(contains("\n| method | strips |").and(contains("\n|---|---:|")).and(contains("**")));
}

#[test]
fn a_bad_model_does_not_stop_the_others() {
    tristrip()
        .args(["compare", "none.ply"])
        .arg(model("fish_control.ply"))
        .assert()
        .code(1)
        .stderr(contains("tristrip: none.ply: no such file or directory"))
        .stdout(contains("fish_control.ply: 220 triangles"));
}
