//! Compression of stored answers (zlib).

use std::cell::RefCell;
use std::io::{Read, Write};

use flate2::Compression;
use flate2::read::ZlibDecoder;
use flate2::write::ZlibEncoder;
use serde::Serialize;

use crate::jobs::error::JobError;

/// Twice as fast as the default level 6, with output 5 % larger: a client waits for the compression.
const LEVEL: Compression = Compression::new(3);

/// The answer as compressed JSON.
pub fn compressed(answer: &impl Serialize) -> Result<Vec<u8>, JobError> {
    // In one piece: the compressor takes ten times as long for the few bytes at a time that serde_json writes.
    let text = serde_json::to_vec(answer).map_err(|error| JobError::Corrupt(error.to_string()))?;
    Ok(deflated(&text)?)
}

/// The bytes in compressed form.
pub fn deflated(bytes: &[u8]) -> std::io::Result<Vec<u8>> {
    ENCODER.with_borrow_mut(|encoder| {
        encoder.write_all(bytes)?;
        encoder.reset(Vec::new())
    })
}

thread_local! {
    /// Reused, because creating an encoder takes as long as compressing a spectrum.
    static ENCODER: RefCell<ZlibEncoder<Vec<u8>>> = RefCell::new(ZlibEncoder::new(Vec::new(), LEVEL));
}

/// The JSON text of a compressed answer.
pub fn decompressed(answer: &[u8]) -> Result<Vec<u8>, JobError> {
    let mut text = Vec::with_capacity(4 * answer.len());
    ZlibDecoder::new(answer).read_to_end(&mut text)?;
    Ok(text)
}
