//! Lock that admits one server per database file: two servers would each treat the other's running jobs as lost.

use std::fs::{File, Metadata, OpenOptions, TryLockError};
use std::path::{Path, PathBuf};

use super::error::JobError;
use super::store::connections::create_private;

/// A lock that is held as long as the server runs. The system releases it when the process ends for any reason.
///
/// It is on the database file itself, so another name of the file, such as a link, does not circumvent it. SQLite's own locks are
/// of another kind and do not conflict with it on a local disk.
#[derive(Debug)]
pub struct DatabaseLock {
    file: File,
    path: PathBuf,
}

impl DatabaseLock {
    /// Locks the database file, and creates it if it is missing.
    pub fn take(database: &Path) -> Result<Self, JobError> {
        let opened = create_private(database).and_then(|()| OpenOptions::new().write(true).open(database));
        let file = opened.map_err(|error| JobError::opening(database.display(), error))?;
        match file.try_lock() {
            Ok(()) => Ok(Self { file, path: database.to_owned() }),
            Err(TryLockError::WouldBlock) => Err(JobError::Locked(database.display().to_string())),
            Err(TryLockError::Error(error)) => Err(JobError::opening(database.display(), error)),
        }
    }

    /// Returns whether the path still names the locked file. Writes to a removed or replaced file are lost with this process.
    pub fn is_in_place(&self) -> bool {
        let (held, current) = (self.file.metadata(), std::fs::metadata(&self.path));
        matches!((held, current), (Ok(held), Ok(current)) if is_same(&held, &current))
    }
}

#[cfg(unix)]
fn is_same(one: &Metadata, other: &Metadata) -> bool {
    use std::os::unix::fs::MetadataExt;
    (one.dev(), one.ino()) == (other.dev(), other.ino())
}

/// On other systems an open file can be neither removed nor replaced.
#[cfg(not(unix))]
fn is_same(_: &Metadata, _: &Metadata) -> bool {
    true
}
