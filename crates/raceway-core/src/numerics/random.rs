//! Pseudorandom numbers of a seed, the same on every machine.

/// SplitMix64 (G. L. Steele, D. Lea & C. H. Flood, OOPSLA 2014).
#[derive(Debug, Clone)]
pub(crate) struct SplitMix64(u64);

impl SplitMix64 {
    pub(crate) fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// The next 64 bits.
    pub(crate) fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// The numbers of a seed from any place: that after `place` others.
    pub(crate) fn at(seed: u64, place: u64) -> u64 {
        Self(seed.wrapping_add(place.wrapping_mul(0x9e37_79b9_7f4a_7c15))).next()
    }

    /// Uniform in 0 … 1, both excluded.
    pub(crate) fn inside(&mut self) -> f64 {
        ((self.next() >> 32) as f64 + 0.5) / (1_u64 << 32) as f64
    }

    /// Uniform in 0 … 1, 1 excluded.
    pub(crate) fn uniform(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1_u64 << 53) as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// First numbers of the reference implementation in C for the seed 1234567.
    #[test]
    fn numbers_are_those_of_the_reference() {
        let mut random = SplitMix64::new(1_234_567);
        let expected = [6_457_827_717_110_365_317, 3_203_168_211_198_807_973, 9_817_491_932_198_370_423];
        assert_eq!([random.next(), random.next(), random.next()], expected);
        assert_eq!([0, 2].map(|place| SplitMix64::at(1_234_567, place)), [expected[0], expected[2]]);
        assert!((0..1000).all(|_| (0.0..1.0).contains(&random.uniform())));
    }
}
