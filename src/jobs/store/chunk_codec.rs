//! Chunks of time series as they are stored: the second differences of the values' bits, read as integers, byte after byte, and
//! compressed (zlib). Motions are smooth between two values, so that most of the high bytes are zero. Every bit of a value returns.

use std::io::Read;

use flate2::read::ZlibDecoder;

use super::compression::deflated;
use crate::jobs::error::JobError;

/// Values of a chunk; the last chunk of a series may have fewer.
pub const CHUNK_VALUES: usize = 1 << 14;

/// Bytes of a value.
const BYTES: usize = size_of::<f64>();

/// The stored form of a chunk.
pub fn encoded(values: &[f64]) -> Result<Vec<u8>, JobError> {
    let mut planes = vec![0; BYTES * values.len()];
    let mut before = [0_u64; 2];
    for (place, value) in values.iter().enumerate() {
        let bits = value.to_bits();
        let difference = bits.wrapping_sub(before[0].wrapping_mul(2)).wrapping_add(before[1]);
        before = [bits, before[0]];
        for (byte, of_value) in zigzag(difference).to_le_bytes().into_iter().enumerate() {
            planes[byte * values.len() + place] = of_value;
        }
    }
    Ok(deflated(&planes)?)
}

/// The values of a stored chunk.
pub fn decoded(content: &[u8]) -> Result<Vec<f64>, JobError> {
    let mut planes = Vec::with_capacity(BYTES * CHUNK_VALUES);
    ZlibDecoder::new(content).take((BYTES * CHUNK_VALUES) as u64 + 1).read_to_end(&mut planes)?;
    if planes.len() > BYTES * CHUNK_VALUES || !planes.len().is_multiple_of(BYTES) {
        return Err(JobError::Corrupt("a chunk has another length".to_owned()));
    }
    let length = planes.len() / BYTES;
    let mut before = [0_u64; 2];
    let value = |place: usize| {
        let bytes = std::array::from_fn(|byte| planes[byte * length + place]);
        let difference = unzigzag(u64::from_le_bytes(bytes));
        let bits = difference.wrapping_add(before[0].wrapping_mul(2)).wrapping_sub(before[1]);
        before = [bits, before[0]];
        f64::from_bits(bits)
    };
    Ok((0..length).map(value).collect())
}

/// A difference of either sign as a number with few bits if its magnitude is small.
fn zigzag(difference: u64) -> u64 {
    let signed = difference.cast_signed();
    ((signed << 1) ^ (signed >> 63)).cast_unsigned()
}

fn unzigzag(code: u64) -> u64 {
    (code >> 1) ^ (code & 1).wrapping_neg()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_bit_of_a_value_returns() {
        let motion = (0..CHUNK_VALUES).map(|k| 3.0 + (1e-2 * k as f64).sin());
        let special = [0.0, -0.0, f64::MIN_POSITIVE, f64::MAX, -f64::MAX, f64::INFINITY, f64::NAN, 1e-320, -1.0, 1.0];
        for values in [motion.collect(), special.repeat(7), vec![], vec![-5.0]] as [Vec<f64>; 4] {
            let content = encoded(&values).expect("it is encoded");
            let bits = |values: &[f64]| values.iter().map(|value| value.to_bits()).collect::<Vec<_>>();
            assert_eq!(bits(&decoded(&content).expect("it is decoded")), bits(&values));
        }
    }

    #[test]
    fn a_smooth_motion_takes_few_bytes() {
        let motion: Vec<f64> = (0..CHUNK_VALUES).map(|k| 20.0 + (1e-3 * k as f64).sin()).collect();
        let content = encoded(&motion).expect("it is encoded");
        assert!(2 * content.len() < BYTES * motion.len(), "{} bytes", content.len());
    }

    #[test]
    fn a_chunk_of_another_length_is_corrupt() {
        for bytes in [vec![0; 7], vec![0; BYTES * (CHUNK_VALUES + 1)]] {
            let content = deflated(&bytes).expect("it is compressed");
            assert!(decoded(&content).is_err_and(|error| error.is_corruption()));
        }
    }
}
