//! Combinations of frequencies that come near that of a line.

use std::ops::RangeInclusive;

use super::line_sources::{
    BALL, CAGE, CAGE_WHIRL, INNER, LOAD, LineSources, OUTER, OUTER_RING, OuterRing, SHAFT, SPINDLE_WHIRL, Term,
};

/// Smallest frequency of a term in tolerances: closer combs would fit any line.
const SEPARATION: f64 = 6.0;
/// Share of the tolerance within which a combination fits well.
pub(super) const GOOD_FIT: f64 = 0.1;
/// Harmonics of a given wave of the inner raceway.
const WAVE_HARMONICS: RangeInclusive<i32> = 1..=2;
/// Highest orders of the sidebands.
const SHAFT_SIDEBANDS: i32 = 4;
const OUTER_SIDEBANDS: i32 = 2;
const CAGE_SIDEBANDS: i32 = 3;
/// Cost of the first order of a load: lower than of the shaft, which an order of the load may coincide with.
const LOAD_WEIGHT: f64 = 0.9;
/// Highest order of a load.
const HIGHEST_LOAD_ORDER: i32 = 10;
/// Highest order of a harmonic.
const HIGHEST_ORDER: f64 = 1000.0;
/// Highest order of a harmonic of the cage alone. Higher ones coincide with the ball passage and its sidebands, and would fit any line.
const HIGHEST_CAGE_ORDER: f64 = 20.0;

/// Combinations with a physical cause that come near the frequency. Each source has sidebands of the motions that its line comes from.
pub(super) fn combinations(frequency: f64, sources: &LineSources<'_>, tolerance: f64) -> Vec<[Term; 3]> {
    let mut all = Combinations::new(frequency, sources, tolerance);
    all.add_inner_waves();
    all.add_shaft_and_passage();
    all.add_balls();
    all.add_inner_raceway();
    if sources.outer_turns() {
        all.add_outer_ring();
    }
    all.carry(all.cage, [all.shaft, all.outer]);
    all.add_loads();
    all.add_whirl();
    all.found
}

/// The terms of a scene, and the combinations found so far.
struct Combinations<'a> {
    frequency: f64,
    tolerance: f64,
    sources: &'a LineSources<'a>,
    /// Number of balls.
    balls: i32,
    shaft: Term,
    /// Ball passage of the outer raceway.
    outer: Term,
    /// Rotation of the outer ring.
    ring: Term,
    /// Passage of balls under the load, a multiple of the cage's rotation.
    passage: Term,
    cage: Term,
    found: Vec<[Term; 3]>,
}

impl<'a> Combinations<'a> {
    fn new(frequency: f64, sources: &'a LineSources<'a>, tolerance: f64) -> Self {
        let all = &sources.frequencies;
        let balls = (all.ball_pass / all.cage).round() as i32;
        let outer = Term::new(OUTER, all.ball_pass_outer, 1.0);
        let passage = match sources.outer_turns() {
            true => Term { unit: balls, ..Term::new(CAGE, all.ball_pass, 1.0) },
            false => outer,
        };
        Self {
            frequency,
            tolerance,
            sources,
            balls,
            shaft: Term::new(SHAFT, all.shaft, 1.0),
            outer,
            ring: Term::new(OUTER_RING, all.outer_ring, 1.0),
            passage,
            cage: Term::new(CAGE, all.cage, 1.6).driven(sources.unequal_balls),
            found: Vec::new(),
        }
    }

    /// True if combs of the term are apart.
    fn is_usable(&self, term: &Term) -> bool {
        term.frequency >= SEPARATION * self.tolerance
    }

    /// Orders of a sideband.
    fn orders(&self, term: &Term, reach: i32) -> RangeInclusive<i32> {
        if self.is_usable(term) { -reach..=reach } else { 0..=0 }
    }

    /// Adds a carrier with two sidebands. Its order follows from the frequency.
    fn carry(&mut self, carrier: Term, sides: [Term; 2]) {
        let rest = self.frequency - sides.iter().map(Term::at).sum::<f64>();
        let order = (rest / carrier.frequency).round();
        let highest = match carrier.name {
            // From the number of balls on, its harmonics are passages with sidebands.
            CAGE if carrier.unit == 1 => HIGHEST_CAGE_ORDER.min(f64::from(self.balls) - 1.0),
            LOAD => f64::from(HIGHEST_LOAD_ORDER),
            _ => HIGHEST_ORDER,
        };
        if self.is_usable(&carrier) && (1.0..=highest).contains(&order) {
            self.found.push([carrier.times(order as i32), sides[0], sides[1]]);
        }
    }

    /// Orders of given waves of the inner raceway, with those of the ball passage under the load.
    fn add_inner_waves(&mut self) {
        let (passage, shaft) = (self.passage.driven(true), self.shaft.driven(true));
        if !(self.is_usable(&passage) && self.is_usable(&shaft)) {
            return;
        }
        for order in
            self.sources.inner_orders.iter().flat_map(|order| WAVE_HARMONICS.map(move |harmonic| harmonic * order))
        {
            let passages = ((self.frequency - f64::from(order) * shaft.frequency) / passage.frequency).round();
            self.found.push([passage.times(passages as i32), shaft.times(order), self.cage]);
        }
    }

    /// Harmonics of the shaft and of the ball passage under the load, with those of shaft, passage and cage.
    fn add_shaft_and_passage(&mut self) {
        // Unequal balls drive every multiple of the cage speed.
        let half_passage = (0.5 * self.sources.frequencies.ball_pass / self.sources.frequencies.cage) as i32;
        let of_cage = if self.sources.unequal_balls { CAGE_SIDEBANDS.max(half_passage) } else { CAGE_SIDEBANDS };
        for k in self.orders(&self.cage, of_cage) {
            let cage = self.cage.times(k);
            for n in self.orders(&self.shaft, SHAFT_SIDEBANDS) {
                self.carry(self.passage, [self.shaft.times(n), cage]);
            }
            for m in self.orders(&self.passage, OUTER_SIDEBANDS) {
                self.carry(self.shaft, [self.passage.times(m), cage]);
            }
        }
    }

    /// Even orders of a ball's spin, and odd ones where it has them, with those of the cage, which carries uneven balls through the load.
    fn add_balls(&mut self) {
        let any = Term::new(BALL, self.sources.frequencies.ball_spin, 1.3).driven(true);
        // A ball meets both raceways in a turn.
        let even = Term { unit: 2, frequency: 2.0 * any.frequency, ..any };
        for k in self.orders(&self.cage, self.balls) {
            let cage = self.cage.driven(true).times(k);
            self.carry(even, [self.shaft, cage]);
            if self.sources.odd_ball_orders {
                self.carry(any, [self.shaft, cage]);
            }
        }
    }

    /// The ball passage of the inner raceway, with those of the shaft.
    fn add_inner_raceway(&mut self) {
        let is_uneven = self.sources.uneven_inner;
        let inner = Term::new(INNER, self.sources.frequencies.ball_pass_inner, 1.1);
        // The load zone has as many harmonics as there are balls; those beyond belong to the next passage.
        let of_shaft = if is_uneven { SHAFT_SIDEBANDS.max(self.balls) } else { SHAFT_SIDEBANDS };
        for n in self.orders(&self.shaft, of_shaft) {
            self.carry(inner, [self.shaft.driven(is_uneven).times(n), self.cage]);
        }
    }

    /// The ball passage of an outer raceway that turns, with those of its ring, and the ring's own harmonics.
    fn add_outer_ring(&mut self) {
        let is_uneven = self.sources.outer_ring == OuterRing::Turns { is_uneven: true };
        let of_ring = if is_uneven { SHAFT_SIDEBANDS.max(self.balls - 1) } else { SHAFT_SIDEBANDS };
        for n in self.orders(&self.ring, of_ring) {
            self.carry(self.outer, [self.ring.driven(is_uneven).times(n), self.cage]);
        }
        self.carry(self.ring, [self.shaft, self.cage]);
    }

    /// Harmonic loads alone, and as sidebands of the ball passage under the load.
    fn add_loads(&mut self) {
        for frequency in self.sources.loads {
            let load = Term::new(LOAD, *frequency, LOAD_WEIGHT);
            self.carry(load, [self.shaft, self.cage]);
            for k in self.orders(&load, HIGHEST_LOAD_ORDER).filter(|k| *k != 0) {
                self.carry(self.passage, [load.driven(true).times(k), self.cage]);
            }
        }
    }

    /// Whirl of cage or spindle. It has no sidebands, because it follows from their motion.
    fn add_whirl(&mut self) {
        // A whirling cage drives the spindle round at its own rate, so it has precedence.
        let whirls = [(CAGE_WHIRL, self.sources.cage_whirl), (SPINDLE_WHIRL, self.sources.spindle_whirl)];
        let whirls = whirls.map(|(name, frequency)| Term::new(name, frequency, 1.6));
        let found = whirls.into_iter().find(|whirl| self.is_near(whirl) && !self.is_caused(whirl));
        self.found.extend(found.map(|whirl| [whirl.times(1), self.shaft, self.cage]));
    }

    fn is_near(&self, whirl: &Term) -> bool {
        self.is_usable(whirl) && (self.frequency - whirl.frequency).abs() <= self.tolerance
    }

    /// True if balls or surfaces move spindle or cage round at this rate.
    fn is_caused(&self, whirl: &Term) -> bool {
        let is_passage = (whirl.frequency - self.passage.frequency).abs() <= self.tolerance;
        let is_of_surface = whirl.name == SPINDLE_WHIRL && self.found.iter().any(|of| self.is_of_surface(of));
        is_passage || is_of_surface || self.is_of_unequal_balls(whirl)
    }

    /// Unequal balls drive the spindle round at multiples of the cage speed.
    fn is_of_unequal_balls(&self, whirl: &Term) -> bool {
        let order = (self.frequency / self.cage.frequency).round();
        self.sources.unequal_balls
            && self.is_usable(&self.cage)
            && order <= HIGHEST_CAGE_ORDER
            && (whirl.frequency - order * self.cage.frequency).abs() <= self.tolerance
    }

    /// Uneven balls drive it round, too, and uneven raceways at any combination of shaft and ball passages.
    fn is_of_surface(&self, of: &[Term; 3]) -> bool {
        let is_of_raceway = |term: &Term| term.name != CAGE || term.order == 0 || self.sources.is_passage(term);
        let of_raceway = self.sources.uneven_raceways && of.iter().all(is_of_raceway);
        let deviation = self.frequency - of.iter().map(Term::at).sum::<f64>();
        (of[0].name == BALL || of_raceway) && deviation.abs() <= GOOD_FIT * self.tolerance
    }
}
