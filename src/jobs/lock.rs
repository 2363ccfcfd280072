//! One server a database: two would each take the other's running jobs for lost.

use std::fs::{File, OpenOptions, TryLockError};
use std::path::Path;

use super::JobError;

/// Held as long as the server runs; the system lets go of it when the process ends, however it ends.
#[derive(Debug)]
pub struct DatabaseLock {
    _file: File,
}

impl DatabaseLock {
    /// Takes the lock beside the database file.
    pub fn take(database: &Path) -> Result<Self, JobError> {
        let mut name = database.as_os_str().to_owned();
        name.push(".lock");
        let opened = OpenOptions::new().create(true).truncate(false).write(true).open(&name);
        let file = opened.map_err(|error| JobError::opening(database.display(), error))?;
        match file.try_lock() {
            Ok(()) => Ok(Self { _file: file }),
            Err(TryLockError::WouldBlock) => Err(JobError::Locked(database.display().to_string())),
            Err(TryLockError::Error(error)) => Err(JobError::opening(database.display(), error)),
        }
    }
}
