//! Load and slip of one raceway contact in the plane, shared by ball and traction.

use crate::numerics::lanes::side_by_side;

/// Load of a contact [N], square of its semi-major axis [m²], and slip: base + height over the ball's centre · per_height.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Contact<T = f32> {
    pub load: T,
    pub axis_square: T,
    pub base: T,
    pub per_height: T,
}
side_by_side!(Contact { load, axis_square, base, per_height });
