//! Fields of a spring and a dashpot between two places: of supports and mounts.

use crate::contract::json::defaults::Defaults;
use crate::contract::json::units::{N_M_PER_MRAD, N_PER_UM};
use raceway_core::physics::frame::support::{PortMatrix, diagonal};

/// Fields of a spring and a dashpot.
pub struct SpringFields<'a> {
    pub stiffness: &'a Option<[f64; 3]>,
    pub damping: &'a mut Option<[f64; 3]>,
    pub tilt: &'a mut Option<[f64; 2]>,
    pub tilt_damping: &'a mut Option<[f64; 2]>,
}

/// Stiffness and damping in SI; `at`: pointer to the object that has the fields.
pub fn springs(defaults: &mut Defaults, at: &str, fields: SpringFields<'_>) -> (PortMatrix, PortMatrix) {
    let k = defaults.require(format!("{at}/stiffness_n_per_um"), fields.stiffness, [0.0; 3]);
    let c = defaults.fill(format!("{at}/damping_n_s_per_m"), fields.damping, [0.0; 3]);
    let tilt = defaults.fill(format!("{at}/tilt_n_m_per_mrad"), fields.tilt, [0.0; 2]);
    let pointer = format!("{at}/tilt_damping_n_m_s_per_rad");
    let tilt_damping = defaults.fill(pointer, fields.tilt_damping, [0.0; 2]);
    let lists: [(&str, &[f64]); 4] = [
        ("stiffness_n_per_um", &k),
        ("damping_n_s_per_m", &c),
        ("tilt_n_m_per_mrad", &tilt),
        ("tilt_damping_n_m_s_per_rad", &tilt_damping),
    ];
    for (name, values) in lists {
        for (index, value) in values.iter().enumerate() {
            defaults.check_of_rotor(&format!("{at}/{name}/{index}"), *value);
        }
    }
    let [x, y, z] = k.map(|value| N_PER_UM.to_si(value));
    let [about_y, about_z] = tilt.map(|value| N_M_PER_MRAD.to_si(value));
    (diagonal([x, y, z, about_y, about_z]), diagonal([c[0], c[1], c[2], tilt_damping[0], tilt_damping[1]]))
}
