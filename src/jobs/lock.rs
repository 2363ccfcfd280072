//! One server a database: two would each take the other's running jobs for lost.

use std::fs::{File, Metadata, OpenOptions, TryLockError};
use std::path::{Path, PathBuf};

use super::JobError;

/// Held as long as the server runs; the system lets go of it when the process ends, however it ends.
///
/// It is on the database file itself, so that no other name of it, a link for instance, is a way around. SQLite's own locks are of
/// another kind, and on a local disk neither sees the other.
#[derive(Debug)]
pub struct DatabaseLock {
    file: File,
    path: PathBuf,
}

impl DatabaseLock {
    /// Takes the lock on the database file, which is made where there is none.
    pub fn take(database: &Path) -> Result<Self, JobError> {
        let opened = OpenOptions::new().create(true).truncate(false).write(true).open(database);
        let file = opened.map_err(|error| JobError::opening(database.display(), error))?;
        match file.try_lock() {
            Ok(()) => Ok(Self { file, path: database.to_owned() }),
            Err(TryLockError::WouldBlock) => Err(JobError::Locked(database.display().to_string())),
            Err(TryLockError::Error(error)) => Err(JobError::opening(database.display(), error)),
        }
    }

    /// Whether the file is still there by its name: what is written to one that was removed or replaced goes with this process.
    pub fn is_in_place(&self) -> bool {
        let (held, there) = (self.file.metadata(), std::fs::metadata(&self.path));
        matches!((held, there), (Ok(held), Ok(there)) if is_same(&held, &there))
    }
}

#[cfg(unix)]
fn is_same(one: &Metadata, other: &Metadata) -> bool {
    use std::os::unix::fs::MetadataExt;
    (one.dev(), one.ino()) == (other.dev(), other.ino())
}

/// Elsewhere an open file can be neither removed nor replaced.
#[cfg(not(unix))]
fn is_same(_: &Metadata, _: &Metadata) -> bool {
    true
}
