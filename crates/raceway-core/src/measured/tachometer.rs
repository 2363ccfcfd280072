//! Turns of a measured shaft over time, from the pulses of a tachometer.

/// Fewest pulses: the slope at each pulse is that between its neighbours.
pub const FEWEST_PULSES: usize = 3;
/// Distance below the threshold from which on a signal can cross it again, as a share of its range: noise at the edge of a pulse makes no further
/// pulse.
const HYSTERESIS: f64 = 0.1;

/// A shaft that gives pulses at equal angles.
#[derive(Debug, Clone, PartialEq)]
pub struct Tachometer {
    /// Times of the pulses [s].
    pulses: Vec<f64>,
    per_turn: f64,
}

impl Tachometer {
    /// `None` with fewer than three pulses, or where their times [s] do not rise.
    pub fn new(pulses: Vec<f64>, per_turn: u32) -> Option<Self> {
        let is_valid = pulses.len() >= FEWEST_PULSES
            && per_turn > 0
            && pulses.iter().all(|time| time.is_finite())
            && pulses.is_sorted_by(|one, next| one < next);
        is_valid.then_some(Self { pulses, per_turn: f64::from(per_turn) })
    }

    /// Turns between the first and the last pulse.
    pub fn turns(&self) -> f64 {
        (self.pulses.len() - 1) as f64 / self.per_turn
    }

    /// Mean speed between the first and the last pulse [Hz].
    pub fn mean_speed(&self) -> f64 {
        self.turns() / (self.pulses[self.pulses.len() - 1] - self.pulses[0])
    }

    /// Lowest speed between two pulses [Hz].
    pub fn lowest_speed(&self) -> f64 {
        let longest = self.pulses.windows(2).map(|pair| pair[1] - pair[0]).fold(0.0, f64::max);
        1.0 / (longest * self.per_turn)
    }

    /// Time at which the shaft has made these turns since the first pulse [s]. The slope at a pulse is that between its neighbours (Catmull and
    /// Rom 1974), so that a time that is a parabola over the turns is exact between inner pulses.
    pub fn time(&self, turns: f64) -> f64 {
        let last = self.pulses.len() - 1;
        let place = (turns * self.per_turn).clamp(0.0, last as f64);
        let before = (place as usize).min(last - 1);
        let t = place - before as f64;
        let pulse = |k: usize| self.pulses[k];
        let (b, c) = (pulse(before), pulse(before + 1));
        // At the ends the slope goes on as a parabola.
        let a = if before == 0 { 3.0 * b - 3.0 * c + pulse(2) } else { pulse(before - 1) };
        let d = if before + 1 == last { 3.0 * c - 3.0 * b + a } else { pulse(before + 2) };
        b + 0.5 * t * ((c - a) + t * ((2.0 * a - 5.0 * b + 4.0 * c - d) + t * (3.0 * (b - c) + d - a)))
    }
}

/// Times at which a signal of a rate [Hz] rises through a threshold [s], between two values on the straight line through them.
pub fn pulses_of(signal: &[f64], rate: f64, threshold: f64) -> Vec<f64> {
    let (least, most) = extremes(signal);
    let armed_below = threshold - HYSTERESIS * (most - least);
    let (mut is_armed, mut pulses) = (false, Vec::new());
    for (k, pair) in signal.windows(2).enumerate() {
        is_armed |= pair[0] <= armed_below;
        if is_armed && pair[0] < threshold && pair[1] >= threshold {
            pulses.push((k as f64 + (threshold - pair[0]) / (pair[1] - pair[0])) / rate);
            is_armed = false;
        }
    }
    pulses
}

/// Middle between the least and the greatest value of a signal: the usual threshold.
pub fn middle(signal: &[f64]) -> f64 {
    let (least, most) = extremes(signal);
    0.5 * (least + most)
}

fn extremes(signal: &[f64]) -> (f64, f64) {
    signal.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), value| (least.min(*value), most.max(*value)))
}
