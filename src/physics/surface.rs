//! The place where a surface leaves the ideal circle: a height over azimuth, added to the penetration.
//! Waviness and local defects are new variants here and nothing else.

/// Height of a raceway's surface over its ideal circle, positive towards the ball.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub enum SurfaceProfile {
    /// An ideal circle.
    #[default]
    None,
    /// The same height everywhere [m].
    Constant(f64),
}

impl SurfaceProfile {
    /// Height at an azimuth on the raceway [rad], in m.
    #[inline(always)]
    pub fn height(&self, azimuth: f64) -> f64 {
        let _ = azimuth;
        match *self {
            Self::None => 0.0,
            Self::Constant(height) => height,
        }
    }

    /// Rate of the height over azimuth [m/rad].
    #[inline(always)]
    pub fn slope(&self, azimuth: f64) -> f64 {
        let _ = azimuth;
        0.0
    }
}
