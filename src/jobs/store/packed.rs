//! Spectra as they are stored: three bytes for each amplitude, which has four digits. Text of the same would have to be compressed,
//! takes half as much space again and ten times as long, and somebody waits for it.

use super::results::decompressed;
use crate::contract::SpectrumAnswer;
use crate::contract::json::numbers::{decimal, of_decimal};
use crate::jobs::JobError;

/// First byte of what is packed here. What earlier builds have left is the answer compressed with zlib, which begins with 0x78.
const PACKED: u8 = 1;
/// Bits of an amplitude's digits, and what its exponent is counted from in the ten bits above.
const DIGIT_BITS: u32 = 14;
const LEAST_PLACES: i32 = -511;

/// The spectrum: a byte that says so, the length of a head, the head (everything but frequencies, which follow from the resolution, and
/// amplitudes) as JSON, and the amplitudes.
pub fn packed(spectrum: &SpectrumAnswer) -> Result<Vec<u8>, JobError> {
    let head = serde_json::to_vec(&spectrum.head()).map_err(|error| JobError::Corrupt(error.to_string()))?;
    let length = u32::try_from(head.len()).map_err(|_| JobError::Corrupt("the head of a spectrum".into()))?;
    let mut packed = Vec::with_capacity(5 + head.len() + 3 * spectrum.amplitude.len());
    packed.push(PACKED);
    packed.extend(length.to_le_bytes());
    packed.extend(head);
    for amplitude in &spectrum.amplitude {
        packed.extend_from_slice(&triple(*amplitude)?.to_le_bytes()[..3]);
    }
    Ok(packed)
}

/// The spectrum again, frequencies included.
pub fn unpacked(stored: &[u8]) -> Result<SpectrumAnswer, JobError> {
    let corrupt = || JobError::Corrupt("a spectrum".into());
    let parse = |text: &[u8]| serde_json::from_slice::<SpectrumAnswer>(text).map_err(|_| corrupt());
    if stored.first() != Some(&PACKED) {
        return Ok(parse(&decompressed(stored)?)?.with_frequencies());
    }
    let (length, rest) = stored[1..].split_first_chunk().ok_or_else(corrupt)?;
    let (head, triples) = rest.split_at_checked(u32::from_le_bytes(*length) as usize).ok_or_else(corrupt)?;
    let amplitude = triples.chunks_exact(3).map(|bytes| amplitude([bytes[0], bytes[1], bytes[2]])).collect();
    Ok(SpectrumAnswer { amplitude, ..parse(head)? }.with_frequencies())
}

fn triple(amplitude: f64) -> Result<u32, JobError> {
    let (digits, places) = decimal(amplitude, SpectrumAnswer::DIGITS);
    let digits = (0.0..f64::from(1 << DIGIT_BITS)).contains(&digits).then_some(digits as u32);
    let places = u32::try_from(places - LEAST_PLACES).ok().filter(|places| *places < 1 << 10);
    match (digits, places) {
        (Some(digits), Some(places)) => Ok(places << DIGIT_BITS | digits),
        _ => Err(JobError::Corrupt(format!("amplitude {amplitude}"))),
    }
}

fn amplitude([low, middle, high]: [u8; 3]) -> f64 {
    let triple = u32::from_le_bytes([low, middle, high, 0]);
    of_decimal(f64::from(triple % (1 << DIGIT_BITS)), (triple >> DIGIT_BITS) as i32 + LEAST_PLACES)
}

#[cfg(test)]
mod tests {
    use super::super::results::compressed;
    use super::*;
    use crate::contract::SpectrumKind;
    use crate::contract::json::numbers::rounded;

    fn spectrum(amplitude: Vec<f64>) -> SpectrumAnswer {
        SpectrumAnswer {
            channel: "spindle.y.acceleration".into(),
            kind: SpectrumKind::Envelope,
            unit: "m/s²".into(),
            window: "hann".into(),
            averages: 3,
            resolution_hz: 10.0,
            mean_step_s: 1.23e-6,
            damped_above_hz: 4.5e4,
            frequency_hz: Vec::new(),
            amplitude,
        }
        .with_frequencies()
    }

    #[test]
    fn what_is_packed_is_the_same_again_to_the_bit() {
        let between = (0..20_000).map(|k| 10_f64.powf(-18.0 + f64::from(k) * 0.0015));
        let ends = [0.0, 1.0, 9.9994, 9.9995, 0.1, 1e-3, 1e22, 1e-18];
        let whole = spectrum(between.chain(ends).map(|a| rounded(a, SpectrumAnswer::DIGITS)).collect());
        let stored = packed(&whole).unwrap();
        assert!(stored.len() < 3 * whole.amplitude.len() + 300, "{}", stored.len());
        assert_eq!(unpacked(&stored).unwrap(), whole);
    }

    #[test]
    fn what_an_earlier_build_has_stored_can_be_read() {
        let whole = spectrum(vec![0.0, 1.5, 2.25e-7]);
        let earlier = SpectrumAnswer { frequency_hz: Vec::new(), ..whole.clone() };
        assert_eq!(unpacked(&compressed(&earlier).unwrap()).unwrap(), whole);
    }

    #[test]
    fn what_cannot_be_packed_or_is_cut_off_is_an_error() {
        for amplitude in [f64::NAN, f64::INFINITY, -1.0] {
            assert!(packed(&spectrum(vec![amplitude])).is_err(), "{amplitude}");
        }
        // As small as doubles get, fewer digits are kept.
        assert!(packed(&spectrum(vec![f64::MIN_POSITIVE, 5e-324])).is_ok());
        let stored = packed(&spectrum(vec![1.0; 8])).unwrap();
        for length in [0, 1, 4, 5, 20] {
            assert!(unpacked(&stored[..length]).is_err(), "{length}");
        }
    }
}
