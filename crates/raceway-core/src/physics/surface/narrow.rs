//! Defects that do not take the whole groove: how far a ball falls depends on the place of its contact across the groove.

use super::defects::{Across, Recess, wrapped};
use super::height::Height;
use super::table::PathTable;

/// A defect whose path changes across the groove.
#[derive(Debug)]
pub(super) struct NarrowDefect {
    azimuth: f64,
    radius: f64,
    path: PathTable,
    across: Across,
}

impl NarrowDefect {
    /// `None`: the defect takes the whole groove.
    pub(super) fn new(recess: &Recess) -> Option<Self> {
        let across = recess.across()?;
        Some(Self {
            azimuth: recess.defect.azimuth,
            radius: recess.contact.radius,
            path: PathTable::new(recess),
            across,
        })
    }

    /// Height at an azimuth on the ring [rad] and a place across the groove [m].
    pub(super) fn height(&self, azimuth: f64, place: f64) -> Height {
        let (fall, slope) = self.path.fall_and_slope(self.radius * wrapped(azimuth - self.azimuth));
        if fall == 0.0 && slope == 0.0 {
            return Height::default();
        }
        let (limited, by_fall, by_place) = self.across.limited(fall, place);
        Height { height: -limited, along: -by_fall * slope * self.radius, across: -by_place }
    }
}
