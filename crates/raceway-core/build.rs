//! Notes how this crate is optimised, for those who measure the speed of the solver.

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    let level = std::env::var("OPT_LEVEL").unwrap_or_default();
    println!("cargo::rustc-env=RACEWAY_OPT_LEVEL={level}");
}
