//! Binary format of stored spectra: three bytes for each amplitude of four digits. Compressed text takes half as much space again
//! and ten times as long, and a client waits for it.
//!
//! A stored spectrum is a format byte, the length of the header, the header as JSON, and the amplitudes. The header holds every
//! field except amplitudes and frequencies; the frequencies follow from the resolution.

use super::compression::decompressed;
use crate::contract::SpectrumAnswer;
use crate::contract::json::numbers::{decimal, of_decimal};
use crate::jobs::error::JobError;

/// First byte of this format. Earlier builds stored the answer compressed with zlib, which begins with 0x78.
const FORMAT: u8 = 1;
/// Bits of the decimal digits of an amplitude; the ten bits above hold its exponent.
const DIGIT_BITS: u32 = 14;
/// Smallest exponent, stored as 0.
const MIN_EXPONENT: i32 = -511;

/// The stored form of a spectrum.
pub fn encoded(spectrum: &SpectrumAnswer) -> Result<Vec<u8>, JobError> {
    let header = serde_json::to_vec(&spectrum.head()).map_err(|error| JobError::Corrupt(error.to_string()))?;
    let length = u32::try_from(header.len()).map_err(|_| JobError::Corrupt("the header of a spectrum".into()))?;
    let mut bytes = Vec::with_capacity(5 + header.len() + 3 * spectrum.amplitude.len());
    bytes.push(FORMAT);
    bytes.extend(length.to_le_bytes());
    bytes.extend(header);
    for amplitude in &spectrum.amplitude {
        bytes.extend_from_slice(&triple(*amplitude)?.to_le_bytes()[..3]);
    }
    Ok(bytes)
}

/// The spectrum, frequencies included.
pub fn decoded(stored: &[u8]) -> Result<SpectrumAnswer, JobError> {
    let corrupt = || JobError::Corrupt("a spectrum".into());
    let parse = |text: &[u8]| serde_json::from_slice::<SpectrumAnswer>(text).map_err(|_| corrupt());
    if stored.first() != Some(&FORMAT) {
        return Ok(parse(&decompressed(stored)?)?.with_frequencies());
    }
    let (length, rest) = stored[1..].split_first_chunk().ok_or_else(corrupt)?;
    let (header, triples) = rest.split_at_checked(u32::from_le_bytes(*length) as usize).ok_or_else(corrupt)?;
    let amplitude = triples.chunks_exact(3).map(|bytes| amplitude([bytes[0], bytes[1], bytes[2]])).collect();
    Ok(SpectrumAnswer { amplitude, ..parse(header)? }.with_frequencies())
}

/// Digits and exponent of an amplitude, in 24 bits.
fn triple(amplitude: f64) -> Result<u32, JobError> {
    let (digits, exponent) = decimal(amplitude, SpectrumAnswer::DIGITS);
    let digits = (0.0..f64::from(1 << DIGIT_BITS)).contains(&digits).then_some(digits as u32);
    let exponent = u32::try_from(exponent - MIN_EXPONENT).ok().filter(|exponent| *exponent < 1 << 10);
    match (digits, exponent) {
        (Some(digits), Some(exponent)) => Ok(exponent << DIGIT_BITS | digits),
        _ => Err(JobError::Corrupt(format!("amplitude {amplitude}"))),
    }
}

fn amplitude([low, middle, high]: [u8; 3]) -> f64 {
    let triple = u32::from_le_bytes([low, middle, high, 0]);
    of_decimal(f64::from(triple % (1 << DIGIT_BITS)), (triple >> DIGIT_BITS) as i32 + MIN_EXPONENT)
}

#[cfg(test)]
mod tests {
    use super::super::compression::compressed;
    use super::*;
    use crate::contract::SpectrumKind;
    use crate::contract::answer::signals::SpectrumScaling;
    use crate::contract::json::numbers::rounded;

    fn spectrum(amplitude: Vec<f64>) -> SpectrumAnswer {
        SpectrumAnswer {
            channel: "spindle.y.acceleration".into(),
            kind: SpectrumKind::Envelope,
            scaling: SpectrumScaling::Amplitude,
            unit: "m/s²".into(),
            window: "hann".into(),
            window_noise_bandwidth_bins: 1.5,
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
    fn decoding_restores_every_bit() {
        let between = (0..20_000).map(|k| 10_f64.powf(-18.0 + f64::from(k) * 0.0015));
        let ends = [0.0, 1.0, 9.9994, 9.9995, 0.1, 1e-3, 1e22, 1e-18];
        let whole = spectrum(between.chain(ends).map(|a| rounded(a, SpectrumAnswer::DIGITS)).collect());
        let stored = encoded(&whole).unwrap();
        assert!(stored.len() < 3 * whole.amplitude.len() + 300, "{}", stored.len());
        assert_eq!(decoded(&stored).unwrap(), whole);
    }

    #[test]
    fn spectra_of_earlier_builds_can_be_read() {
        let whole = spectrum(vec![0.0, 1.5, 2.25e-7]);
        let earlier = SpectrumAnswer { frequency_hz: Vec::new(), ..whole.clone() };
        assert_eq!(decoded(&compressed(&earlier).unwrap()).unwrap(), whole);
    }

    #[test]
    fn unencodable_and_truncated_spectra_are_errors() {
        for amplitude in [f64::NAN, f64::INFINITY, -1.0] {
            assert!(encoded(&spectrum(vec![amplitude])).is_err(), "{amplitude}");
        }
        // Subnormal doubles have fewer digits.
        assert!(encoded(&spectrum(vec![f64::MIN_POSITIVE, 5e-324])).is_ok());
        let stored = encoded(&spectrum(vec![1.0; 8])).unwrap();
        for length in [0, 1, 4, 5, 20] {
            assert!(decoded(&stored[..length]).is_err(), "{length}");
        }
    }
}
