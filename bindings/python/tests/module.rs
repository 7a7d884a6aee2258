//! The tests of the module are in Python; see `bindings/python/test`. This test makes `cargo test`
//! build the module with the same settings as the other tests, and checks that it exists.

#[test]
fn the_module_is_built_beside_the_tests() {
    let program = std::env::current_exe().unwrap();
    let folder = program.parent().unwrap();
    let name = format!("{}tristrip_python{}", std::env::consts::DLL_PREFIX, std::env::consts::DLL_SUFFIX);
    assert!(folder.join(&name).is_file(), "{name} in {}", folder.display());
}
