//! Points of a grid by number: the last axis changes fastest.

/// The lengths of the axes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Grid {
    lengths: Vec<usize>,
}

impl Grid {
    pub fn new(lengths: Vec<usize>) -> Self {
        Self { lengths }
    }

    /// Number of points; `None` where no number holds it.
    pub fn points(&self) -> Option<usize> {
        self.lengths.iter().try_fold(1_usize, |points, length| points.checked_mul(*length))
    }

    /// Places of a point on the axes.
    pub fn places(&self, point: usize) -> Vec<usize> {
        let mut places = vec![0; self.lengths.len()];
        let mut rest = point;
        for (place, length) in places.iter_mut().zip(&self.lengths).rev() {
            (*place, rest) = (rest % length, rest / length);
        }
        places
    }

    /// Number of the point at places on the axes.
    pub fn point(&self, places: &[usize]) -> usize {
        places.iter().zip(&self.lengths).fold(0, |point, (place, length)| point * length + place)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_point_has_its_places_and_every_place_its_point() {
        let grid = Grid::new(vec![2, 3, 4]);
        assert_eq!(grid.points(), Some(24));
        assert_eq!((grid.places(0), grid.places(1), grid.places(4)), (vec![0, 0, 0], vec![0, 0, 1], vec![0, 1, 0]));
        for point in 0..24 {
            assert_eq!(grid.point(&grid.places(point)), point);
        }
        assert_eq!(Grid::new(vec![usize::MAX, 2]).points(), None);
    }
}
