//! Links SUNDIALS from the path of the system linker (Debian: libsundials-dev), and stores the data for the header of a
//! report.

use std::env::var;
use std::process::Command;

fn main() {
    for library in ["cvode", "nvecserial", "sunmatrixdense", "sunlinsoldense", "sunnonlinsolfixedpoint"] {
        println!("cargo:rustc-link-lib=sundials_{library}");
    }
    let compiler = var("RUSTC").unwrap_or_else(|_| "rustc".into());
    let version =
        Command::new(compiler).arg("--version").output().map(|out| String::from_utf8_lossy(&out.stdout).into_owned());
    println!("cargo:rustc-env=PEERS_COMPILER={}", version.unwrap_or_default().trim());
    println!("cargo:rustc-env=PEERS_OPT_LEVEL={}", var("OPT_LEVEL").unwrap_or_default());
    println!("cargo:rerun-if-changed=build.rs");
}
