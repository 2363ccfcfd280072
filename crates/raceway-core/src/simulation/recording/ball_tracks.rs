//! How uneven balls roll: the spin of each, and where its contacts run on it.

/// Motion of one ball over the recorded time.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BallTrack {
    /// Mean spin about its own axis in the orbit frame [rad/s].
    pub spin: f64,
    /// Angle of its contacts from its equator, root of the mean square weighted by load [rad]; 0 in the plane.
    pub latitude: f64,
}

/// Sums over the samples of one ball.
#[derive(Debug, Clone, Copy, Default)]
struct Sums {
    samples: f64,
    /// [rad/s]
    spin: f64,
    /// [N]
    load: f64,
    /// Of load times the squared sine of the latitude [N].
    square: f64,
}

/// Sums over the samples of each ball.
#[derive(Debug, Clone)]
pub(crate) struct BallTracks(Vec<Sums>);

impl BallTracks {
    pub(crate) fn new(balls: usize) -> Self {
        Self(vec![Sums::default(); balls])
    }

    /// Adds the spin of a ball [rad/s].
    pub(crate) fn add_spin(&mut self, ball: usize, spin: f64) {
        self.0[ball].samples += 1.0;
        self.0[ball].spin += spin;
    }

    /// Adds a contact of a ball under a load [N], by the sine of its latitude.
    pub(crate) fn add_contact(&mut self, ball: usize, load: f64, sine: f64) {
        self.0[ball].load += load;
        self.0[ball].square += load * sine * sine;
    }

    pub(crate) fn finish(self) -> Vec<BallTrack> {
        let mean = |sum: f64, weight: f64| if weight > 0.0 { sum / weight } else { 0.0 };
        let of = |sums: Sums| BallTrack {
            spin: mean(sums.spin, sums.samples),
            latitude: mean(sums.square, sums.load).sqrt().min(1.0).asin(),
        };
        self.0.into_iter().map(of).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn latitudes_are_weighted_by_load() {
        let mut tracks = BallTracks::new(2);
        for (spin, load, sine) in [(10.0, 3.0, 0.1), (20.0, 1.0, 0.3)] {
            tracks.add_spin(1, spin);
            tracks.add_contact(1, load, sine);
        }
        let found = tracks.finish();
        assert_eq!(found[0], BallTrack { spin: 0.0, latitude: 0.0 });
        // (3 · 0.01 + 0.09)/4 = 0.03.
        assert!(found[1].spin == 15.0 && (found[1].latitude.sin().powi(2) - 0.03).abs() < 1e-15);
    }
}
