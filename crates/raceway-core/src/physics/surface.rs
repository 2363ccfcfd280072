//! Deviation of raceways and balls from their ideal forms. A raceway has a height over azimuth, out of the material.
//!
//! The height h adds to the penetration δ and its rate to the damping. δ depends on the azimuth φ of the ball on the ring. A
//! load Q therefore also pushes the ball along the raceway with −Q h_φ/r, by the tilt of the contact normal. The ring takes the opposite
//! force at the same point. Without this lean force the height would do work that no body pays for.
//!
//! Along the raceway a profile has a continuous second derivative: a step in slope would be an impact that no step size resolves.

pub mod ball;
pub mod defects;
mod height;
mod narrow;
pub mod sphere;
mod table;
mod wave;
pub mod waviness;

use std::sync::Arc;

use self::defects::Recess;
pub use self::height::Height;
pub(crate) use self::height::Rise;
use self::narrow::NarrowDefect;
use self::table::HeightTable;
pub(crate) use self::table::path_over;
use self::waviness::Wave;
use crate::numerics::lanes::{Lanes, SideBySide};

/// Height that is added to the penetration of a contact.
#[derive(Debug, Clone, Default)]
pub enum SurfaceProfile {
    /// The ideal circle.
    #[default]
    None,
    /// The same height everywhere [m]: a radius that differs from nominal.
    Constant(f64),
    /// Waves round the ring, and defects in the middle of the groove.
    Table(Arc<HeightTable>),
    /// Also defects whose path changes across the groove.
    Narrow(Arc<NarrowSurface>),
}

/// A surface with defects narrower than the groove.
#[derive(Debug)]
pub struct NarrowSurface {
    everywhere: HeightTable,
    defects: Vec<NarrowDefect>,
}

impl SurfaceProfile {
    /// The sum of some waves; ideal without any.
    pub fn of_waves(waves: &[Wave]) -> Self {
        Self::new(waves, &[], true)
    }

    /// Waves and defects; ideal without any. `planar`: all contacts lie in the middle of the groove.
    pub fn new(waves: &[Wave], recesses: &[Recess], planar: bool) -> Self {
        if waves.is_empty() && recesses.is_empty() {
            return Self::None;
        }
        let of_table = |recess: &&Recess| planar || recess.defect.width.is_none();
        let in_table: Vec<Recess> = recesses.iter().filter(of_table).copied().collect();
        let everywhere = HeightTable::new(waves, &in_table);
        if in_table.len() == recesses.len() {
            return Self::Table(Arc::new(everywhere));
        }
        let defects = recesses.iter().filter(|recess| !of_table(recess)).filter_map(NarrowDefect::new).collect();
        Self::Narrow(Arc::new(NarrowSurface { everywhere, defects }))
    }

    /// Returns true where the profile has no effect.
    pub fn is_ideal(&self) -> bool {
        matches!(self, Self::None)
    }

    /// Returns true where the height changes across the groove.
    pub fn is_narrow(&self) -> bool {
        matches!(self, Self::Narrow(_))
    }

    /// Height and slopes at an azimuth on the ring [rad] and a place across the groove [m].
    #[inline(always)]
    pub fn at(&self, azimuth: f64, place: f64) -> Height {
        let of_table = |table: &HeightTable| {
            let (height, along) = table.height_and_slope(azimuth);
            Height { height, along, across: 0.0 }
        };
        match self {
            Self::None => Height::default(),
            Self::Constant(height) => Height { height: *height, ..Height::default() },
            Self::Table(table) => of_table(table),
            Self::Narrow(surface) => surface.defects.iter().map(|defect| defect.height(azimuth, place)).fold(
                of_table(&surface.everywhere),
                |sum, one| Height {
                    height: sum.height + one.height,
                    along: sum.along + one.along,
                    across: sum.across + one.across,
                },
            ),
        }
    }

    /// Heights with both derivatives at the azimuths of several balls.
    #[inline(always)]
    pub(crate) fn rises<const N: usize>(&self, azimuth: &Lanes<N>) -> Rise<Lanes<N>> {
        match self {
            Self::None => Rise::default(),
            Self::Constant(height) => Rise { height: Lanes::all(*height), ..Rise::default() },
            Self::Table(table) => table.rises(azimuth),
            // Models that ask for curvatures are planar, where the table has all defects.
            Self::Narrow(surface) => surface.everywhere.rises(azimuth),
        }
    }

    /// Heights and slopes under several balls.
    #[inline(always)]
    pub(crate) fn under<const N: usize>(&self, azimuth: &Lanes<N>, place: &Lanes<N>) -> Height<Lanes<N>> {
        match self {
            Self::Table(table) => table.under(azimuth),
            _ => self.under_each(azimuth, place),
        }
    }

    /// Heights and slopes under several balls, one after the other. A call of its own: other scenes keep their loops short.
    #[inline(never)]
    fn under_each<const N: usize>(&self, azimuth: &Lanes<N>, place: &Lanes<N>) -> Height<Lanes<N>> {
        let mut of = Height::<Lanes<N>>::default();
        for lane in 0..N {
            of.put(lane, self.at(azimuth[lane], place[lane]));
        }
        of
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_constant_height_has_no_slope() {
        assert_eq!(SurfaceProfile::Constant(2e-6).at(1.0, 0.0), Height { height: 2e-6, ..Height::default() });
        assert_eq!(SurfaceProfile::None.at(1.0, 0.0), Height::default());
        assert!(SurfaceProfile::of_waves(&[]).is_ideal() && !SurfaceProfile::Constant(0.0).is_ideal());
    }
}
