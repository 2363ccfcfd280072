//! Notes how this build was made, for those who measure its speed.

use std::env;
use std::process::Command;

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    let variable = |name: &str| env::var(name).unwrap_or_default();
    let rustc = Command::new(variable("RUSTC")).arg("--version").output();
    let rustc = rustc.ok().and_then(|output| String::from_utf8(output.stdout).ok()).unwrap_or_default();
    println!("cargo::rustc-env=RACEWAY_RUSTC={}", rustc.trim());
    println!("cargo::rustc-env=RACEWAY_TARGET={}", variable("TARGET"));
    println!("cargo::rustc-env=RACEWAY_PROFILE={}", variable("PROFILE"));
    println!("cargo::rustc-env=RACEWAY_RUSTFLAGS={}", variable("CARGO_ENCODED_RUSTFLAGS").replace('\u{1f}', " "));
}
