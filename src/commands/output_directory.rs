//! The directory for results.

use std::fs;
use std::path::{Path, PathBuf};

/// The directory for results.
pub struct OutputDirectory {
    path: PathBuf,
}

impl OutputDirectory {
    /// Creates the directory if it is missing and writes a test file, so that an error is reported before a long run.
    pub fn open(path: &Path) -> Result<Self, String> {
        fs::create_dir_all(path).map_err(|error| cannot_write(path, &error))?;
        let trial = path.join(format!(".raceway-{}", uuid::Uuid::now_v7()));
        let tried = fs::File::create_new(&trial).and_then(|_| fs::remove_file(&trial));
        tried.map_err(|error| cannot_write(path, &error))?;
        Ok(Self { path: path.to_owned() })
    }

    pub fn write(&self, name: &str, text: &str) -> Result<(), String> {
        let path = self.path.join(name);
        fs::write(&path, text).map_err(|error| cannot_write(&path, &error))
    }
}

fn cannot_write(path: &Path, error: &std::io::Error) -> String {
    format!("cannot write {}: {error}", path.display())
}
