//! Places that a ball passes on its way round: the load zone and the defects, and what balls do there.

use std::f64::consts::TAU;

use crate::physics::bearing::PerRaceway;
use crate::physics::surface::defects::DefectEdges;
use crate::simulation::recording::defect_passages::{DefectPassages, Passage};
use crate::simulation::recording::off_raceway::{OffShare, OffTime};

/// Azimuths at which the inner raceway presses a ball in the static equilibrium on ideal raceways.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct LoadZone {
    /// Whether a ball is pressed, at evenly spaced azimuths from +Y towards +Z.
    pressed: Vec<bool>,
}

impl LoadZone {
    pub(crate) fn new(pressed: Vec<bool>) -> Self {
        Self { pressed }
    }

    /// Returns whether the azimuth [rad] lies in the zone.
    fn contains(&self, azimuth: f64) -> bool {
        let places = self.pressed.len();
        let turns = azimuth / TAU;
        let place = (turns - turns.floor()) * places as f64;
        self.pressed[(place.round() as usize) % places]
    }
}

/// Load zone and defects of a mechanism.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct SurfaceSites {
    /// `None` without a static equilibrium.
    pub load_zone: Option<LoadZone>,
    pub defects: PerRaceway<Vec<DefectEdges>>,
}

/// Observer of the balls at these places.
#[derive(Clone)]
pub(crate) struct SiteObserver<'m> {
    sites: &'m SurfaceSites,
    balls: usize,
    off_time: Option<OffTime>,
    passages: Option<DefectPassages>,
    /// Time of the last sample [s].
    last: Option<f64>,
}

impl<'m> SiteObserver<'m> {
    /// `contacts`: whether the time off the raceways is requested; `window`: time for which passages are kept [s], `None`: they are not.
    pub(crate) fn new(sites: &'m SurfaceSites, balls: usize, contacts: bool, window: Option<f64>) -> Self {
        let count = sites.defects.inner.len() + sites.defects.outer.len();
        Self {
            sites,
            balls,
            off_time: (contacts && sites.load_zone.is_some()).then(|| OffTime::new(balls)),
            passages: window.filter(|_| count > 0).map(|window| DefectPassages::new(balls * count, window)),
            last: None,
        }
    }

    /// Observes all balls at a time [s]; `rings`: angles of the rings [rad]; `ball`: azimuth [rad] and loads [N] of one.
    pub(crate) fn observe(
        &mut self,
        time: f64,
        rings: PerRaceway<f64>,
        ball: impl Fn(usize) -> (f64, PerRaceway<f64>),
    ) {
        let interval = time - self.last.replace(time).unwrap_or(time);
        let SurfaceSites { load_zone, defects } = self.sites;
        for index in 0..self.balls {
            let (azimuth, load) = ball(index);
            if let (Some(off_time), Some(zone)) = (&mut self.off_time, load_zone)
                && zone.contains(azimuth)
            {
                off_time.add(index, interval, load);
            }
            if let Some(passages) = &mut self.passages {
                let on_inner = defects.inner.iter().map(|edges| (edges, azimuth - rings.inner));
                let on_outer = defects.outer.iter().map(|edges| (edges, azimuth - rings.outer));
                for (number, (edges, azimuth)) in on_inner.chain(on_outer).enumerate() {
                    passages.observe(
                        number * self.balls + index,
                        time,
                        edges.angle_from_middle(azimuth),
                        edges.half_angle,
                    );
                }
            }
        }
    }

    /// Shares of the time off both raceways; `None` where they were not observed.
    pub(crate) fn off_shares(&self) -> Option<PerRaceway<OffShare>> {
        self.off_time.as_ref().and_then(OffTime::shares)
    }

    /// The passages over defects.
    pub(crate) fn into_passages(self) -> Vec<Passage> {
        self.passages.map(DefectPassages::finish).unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn azimuths_of_any_turn_lie_in_the_zone_or_not() {
        let zone = LoadZone::new((0..8).map(|place| place <= 1 || place == 7).collect());
        for turn in [-2.0, 0.0, 5.0] {
            let at = |degrees: f64| zone.contains((degrees + 360.0 * turn).to_radians());
            assert!(at(0.0) && at(60.0) && at(-60.0) && at(359.0), "{turn}");
            assert!(!at(70.0) && !at(180.0) && !at(-70.0), "{turn}");
        }
    }
}
