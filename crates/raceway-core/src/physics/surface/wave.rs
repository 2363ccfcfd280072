//! Waves of whole orders, given one by one or drawn.

use std::f64::consts::TAU;

use crate::numerics::exponential::power;
use crate::numerics::random::SplitMix64;
use crate::physics::limits::{Faults, limits_of};

/// A wave of the height, amplitude · cos(order · φ + phase), φ the azimuth on the ring.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wave {
    /// Periods round the ring.
    pub order: u32,
    /// [m]
    pub amplitude: f64,
    /// [rad]
    pub phase: f64,
}

/// Waves of many orders with drawn phases: amplitude · (order/at_order)^−exponent.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RandomWaviness {
    /// Amplitude at `at_order` [m].
    pub amplitude: f64,
    pub at_order: u32,
    /// [-]
    pub exponent: f64,
    pub from_order: u32,
    /// `None`: the order whose waves are as long as the contact, where averaging removes them.
    pub to_order: Option<u32>,
}

/// Largest number of waves that are given one by one.
pub const MOST_WAVES: usize = 64;

/// Names of the parameters of waves, in the order of the fields.
pub(super) struct WaveNames {
    pub(super) waviness: &'static str,
    pub(super) wave: [&'static str; 3],
}

impl WaveNames {
    /// Checks waves given one by one. `items`: where the surface stands in lists.
    pub(super) fn check_waves(&self, waves: &[Wave], most: usize, items: &[usize], faults: &mut Faults) {
        if waves.len() > most {
            faults.inconsistent_item(self.waviness, items, format!("{} waves: at most {most}", waves.len()));
        }
        for wave in waves {
            let values = [f64::from(wave.order), wave.amplitude, wave.phase];
            for (name, value) in self.wave.iter().zip(values) {
                faults.check(name, value);
            }
        }
    }
}

impl RandomWaviness {
    /// `names`: of the parameters, in the order of the fields; `items`: their places in lists.
    pub(super) fn check(&self, names: &[&'static str; 5], items: &[usize], faults: &mut Faults) {
        let [amplitude, at_order, exponent, from_order, to_order] = names;
        faults.check(amplitude, self.amplitude);
        faults.check(at_order, f64::from(self.at_order));
        faults.check(exponent, self.exponent);
        faults.check(from_order, f64::from(self.from_order));
        if let Some(to) = self.to_order
            && faults.check(to_order, f64::from(to))
            && to < self.from_order
        {
            faults.inconsistent_item(to_order, items, format!("{to} is below from_order, {}", self.from_order));
        }
        // Amplitudes fall with the order, so that the first one is the largest.
        let largest = self.amplitude_of(self.from_order);
        let most = limits_of(amplitude).map_or(f64::INFINITY, |limits| limits.highest);
        if largest > most {
            let reason = format!(
                "{} nm at order {} become {:.4e} nm at order {}: at most {} nm",
                1e9 * self.amplitude,
                self.at_order,
                1e9 * largest,
                self.from_order,
                1e9 * most
            );
            faults.inconsistent_item(amplitude, items, reason);
        }
    }

    /// Amplitude of an order [m].
    fn amplitude_of(&self, order: u32) -> f64 {
        self.amplitude * power(f64::from(order) / f64::from(self.at_order), -self.exponent)
    }

    /// The waves with their drawn phases. `first_zero`: the order that ends them by default; `index`: number of the surface.
    pub(super) fn waves(self, first_zero: f64, index: u64, seed: u64) -> impl Iterator<Item = Wave> {
        let last = self.to_order.unwrap_or(first_zero as u32);
        (self.from_order..=last).map(move |order| Wave {
            order,
            amplitude: self.amplitude_of(order),
            phase: TAU * drawn_number([seed, index, Kind::RadialWave as u64, u64::from(order)]),
        })
    }
}

/// Quantity that a drawn number belongs to.
#[derive(Debug, Clone, Copy)]
pub(super) enum Kind {
    RadialWave,
    Diameter,
}

/// A number of 0 … 1 that depends on the words alone: no other field of a scene changes it.
pub(super) fn drawn_number(words: [u64; 4]) -> f64 {
    let hash = words.into_iter().fold(0, |hash, word| SplitMix64::new(hash ^ word).next());
    SplitMix64::new(hash).uniform()
}
