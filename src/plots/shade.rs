//! Colours of values.

/// From dark blue over green to yellow, even steps of lightness (after viridis, by a cubic in each channel).
pub fn shade(share: f64) -> [u8; 3] {
    const RED: [f64; 4] = [0.267, -0.15, -1.06, 1.94];
    const GREEN: [f64; 4] = [0.005, 1.40, -0.68, 0.18];
    const BLUE: [f64; 4] = [0.329, 1.35, -2.62, 1.08];
    let x = share.clamp(0.0, 1.0);
    [RED, GREEN, BLUE].map(|[a, b, c, d]| {
        let value: f64 = a + x * (b + x * (c + x * d));
        (255.0 * value.clamp(0.0, 1.0)).round() as u8
    })
}

/// The same as `#rrggbb`.
pub fn shade_name(share: f64) -> String {
    let [r, g, b] = shade(share);
    format!("#{r:02x}{g:02x}{b:02x}")
}
