//! The tests of the module are in Python: see `bindings/python/test`. This program makes `cargo test` build the module with what the
//! other tests are built with, and checks that it is there.

#[test]
fn the_module_is_built_beside_the_tests() {
    let program = std::env::current_exe().unwrap();
    let folder = program.parent().unwrap();
    let name = format!("{}tristrip_python{}", std::env::consts::DLL_PREFIX, std::env::consts::DLL_SUFFIX);
    assert!(folder.join(&name).is_file(), "{name} in {}", folder.display());
}
