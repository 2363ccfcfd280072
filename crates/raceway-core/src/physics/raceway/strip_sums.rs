//! Slip and traction in the strips of a contact, and their sums.

use std::array::from_fn;

use crate::numerics::lanes::side_by_side;
use crate::physics::contact::strips::{MAX_STRIPS, Strip, Strips};
use crate::physics::contact::traction::TINY;

/// Strips of a contact on the side of positive η, each with its mirror image, and the middle strip.
#[derive(Debug, Clone, Copy)]
pub(super) struct MirroredStrips {
    pub(super) middle: Option<Strip>,
    pub(super) pairs: [Strip; MAX_STRIPS],
    /// Number of pairs in use: fewer than `AT_ONCE`, or a multiple of it, filled up with pairs without weight.
    pub(super) used: usize,
}

/// Pairs of strips that are computed at once: four leave no rest of the usual 9 and 17 strips.
pub(super) const AT_ONCE: usize = 4;

impl MirroredStrips {
    /// `weight`: 1, or 2 where a strip carries its image's load as well.
    pub(super) fn new(strips: &Strips, weight: f64) -> Self {
        let all = strips.as_slice();
        let (half, odd) = (all.len() / 2, all.len() % 2 == 1);
        // Filler without load.
        let blank = Strip { weight: 0.0, ..all[all.len() - 1] };
        let pair = |k: usize| {
            let strip = all[all.len() - half + k];
            Strip { weight: weight * strip.weight, ..strip }
        };
        Self {
            middle: odd.then(|| all[half]),
            pairs: from_fn(|k| if k < half { pair(k) } else { blank }),
            used: if odd || half >= AT_ONCE { half.next_multiple_of(AT_ONCE) } else { half },
        }
    }
}

/// Traction and its moments over the normal load, along the groove and across it.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct StripSums<T = f64> {
    pub(super) along: T,
    pub(super) across: T,
    pub(super) along_moment: T,
    pub(super) across_moment: T,
    pub(super) spin_moment: T,
    /// Traction over slip [s/m].
    pub(super) grip: T,
}
side_by_side!(StripSums { along, across, along_moment, across_moment, spin_moment, grip });

/// Slip in `P` strips, along the groove also in their mirror images; across the groove both have the same slip.
pub(super) struct StripSlip<const P: usize, const S: usize> {
    pub(super) place: [f64; P],
    pub(super) height: [f64; P],
    pub(super) along: [f64; S],
    pub(super) across: [f64; P],
}

impl<const P: usize, const S: usize> StripSlip<P, S> {
    /// Squared slip, offset by `TINY` so that a law may divide by it.
    #[inline(always)]
    pub(super) fn squares(&self) -> [f64; S] {
        let across: [f64; P] = from_fn(|k| self.across[k] * self.across[k] + TINY);
        from_fn(|k| self.along[k] * self.along[k] + across[k % P])
    }
}

impl StripSums {
    /// Adds strips of which μ/|u| is known.
    #[inline(always)]
    pub(super) fn add<const P: usize, const S: usize>(
        &mut self,
        slip: &StripSlip<P, S>,
        strips: &[Strip; P],
        factor: [f64; S],
    ) {
        for k in 0..P {
            let weighted = strips[k].weight * factor[k];
            let traction = weighted * slip.along[k];
            let (mut both, mut difference, mut along) = (weighted, traction, traction);
            if k + P < S {
                let weighted = strips[k].weight * factor[k + P];
                let traction = weighted * slip.along[k + P];
                both += weighted;
                difference -= traction;
                along += traction;
            }
            let across = both * slip.across[k];
            self.grip += both;
            self.along += along;
            self.along_moment += along * slip.height[k];
            self.across += across;
            self.across_moment += across * slip.height[k];
            self.spin_moment += difference * slip.place[k];
        }
    }
}
