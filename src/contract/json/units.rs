//! Units of requests and results. Numbers change units only here.

/// A unit of requests and results: SI value = value · `times` / `over`. A power of ten divides rather
/// than multiplies by its inexact inverse, so that most decimal fractions are converted exactly.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unit {
    pub name: &'static str,
    times: f64,
    over: f64,
}

impl Unit {
    pub fn to_si(self, value: f64) -> f64 {
        value * self.times / self.over
    }

    pub fn to_user(self, value: f64) -> f64 {
        value * self.over / self.times
    }
}

const fn si(name: &'static str) -> Unit {
    Unit { name, times: 1.0, over: 1.0 }
}

const fn part(name: &'static str, over: f64) -> Unit {
    Unit { name, times: 1.0, over }
}

const PI: f64 = std::f64::consts::PI;
pub const NUMBER: Unit = si("");
pub const MM: Unit = part("mm", 1e3);
pub const UM: Unit = part("µm", 1e6);
pub const NM: Unit = part("nm", 1e9);
pub const G: Unit = part("g", 1e3);
pub const G_MM: Unit = part("g·mm", 1e6);
pub const MM_S: Unit = part("mm/s", 1e3);
pub const MRAD: Unit = part("mrad", 1e3);
pub const US: Unit = part("µs", 1e6);
pub const GPA: Unit = Unit { name: "GPa", times: 1e9, over: 1.0 };
pub const DEG: Unit = Unit { name: "°", times: PI, over: 180.0 };
pub const RPM: Unit = Unit { name: "r/min", times: PI, over: 30.0 };
pub const KG: Unit = si("kg");
pub const KG_M2: Unit = si("kg m²");
pub const KG_M3: Unit = si("kg/m³");
pub const N: Unit = si("N");
pub const N_M: Unit = si("N·m");
pub const N_PER_M: Unit = si("N/m");
pub const N_S_PER_M: Unit = si("N·s/m");
pub const M_S: Unit = si("m/s");
pub const M_S2: Unit = si("m/s²");
pub const PA: Unit = si("Pa");
pub const PA_S: Unit = si("Pa·s");
pub const PER_PA: Unit = si("1/Pa");
pub const S: Unit = si("s");
pub const HZ: Unit = si("Hz");
pub const N_PER_UM: Unit = Unit { name: "N/µm", times: 1e6, over: 1.0 };
pub const N_M_PER_MRAD: Unit = Unit { name: "N·m/mrad", times: 1e3, over: 1.0 };
