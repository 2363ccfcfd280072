//! Viscosity of oils by grade and temperature.

use std::sync::LazyLock;

const FILE: &str = include_str!("../../data/lubricants.csv");

/// 0 °C [K].
const ZERO_CELSIUS: f64 = 273.15;
/// Change of an oil's density with temperature [kg/m³ K], a usual value of mineral oils.
const DENSITY_SLOPE: f64 = -0.65;

/// An oil by two kinematic viscosities and a density.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Oil {
    /// Kinematic viscosity at 40 °C and at 100 °C [mm²/s].
    pub viscosity_40: f64,
    pub viscosity_100: f64,
    /// Density at 15 °C [kg/m³].
    pub density_15: f64,
}

/// A grade of ISO 3448 as a mineral oil of viscosity index 95.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Grade {
    pub name: &'static str,
    pub oil: Oil,
}

/// All grades, the thinnest first.
pub fn grades() -> &'static [Grade] {
    static GRADES: LazyLock<Vec<Grade>> = LazyLock::new(|| FILE.lines().filter_map(grade).collect());
    &GRADES
}

/// The grade of a line; `None` for the heading.
fn grade(line: &'static str) -> Option<Grade> {
    let mut cells = line.split(',');
    let name = cells.next()?;
    let mut numbers = cells.map_while(|cell| cell.parse().ok());
    let (viscosity_40, viscosity_100) = (numbers.next()?, numbers.next()?);
    // After the constants of Walther's law.
    Some(Grade { name, oil: Oil { viscosity_40, viscosity_100, density_15: numbers.nth(2)? } })
}

/// Constants of Walther's law, lg lg(ν + 0.7) = A − B lg T, with ν in mm²/s and T in K (ASTM D341).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Walther {
    pub a: f64,
    pub b: f64,
}

/// Kinematic viscosity below which Walther's law with 0.7 needs further terms [mm²/s] (ASTM D341).
pub const WALTHER_LOWEST: f64 = 2.0;

impl Walther {
    /// The law through viscosities [mm²/s] above 0.3 at two temperatures [°C].
    fn through([cold, hot]: [(f64, f64); 2]) -> Self {
        let point = |(temperature, viscosity): (f64, f64)| {
            ((temperature + ZERO_CELSIUS).log10(), (viscosity + 0.7).log10().log10())
        };
        let (cold, hot) = (point(cold), point(hot));
        let b = (cold.1 - hot.1) / (hot.0 - cold.0);
        Self { a: cold.1 + b * cold.0, b }
    }

    /// Kinematic viscosity [mm²/s] at a temperature [°C].
    fn viscosity(self, temperature: f64) -> f64 {
        let exponent = self.a - self.b * (temperature + ZERO_CELSIUS).log10();
        10f64.powf(10f64.powf(exponent)) - 0.7
    }
}

impl Oil {
    pub fn walther(&self) -> Walther {
        Walther::through([(40.0, self.viscosity_40), (100.0, self.viscosity_100)])
    }

    /// Kinematic viscosity [mm²/s] at a temperature [°C].
    pub fn kinematic_viscosity(&self, temperature: f64) -> f64 {
        self.walther().viscosity(temperature)
    }

    /// Density [kg/m³] at a temperature [°C].
    pub fn density(&self, temperature: f64) -> f64 {
        self.density_15 + DENSITY_SLOPE * (temperature - 15.0)
    }

    /// Dynamic viscosity [Pa s] at a temperature [°C].
    pub fn viscosity(&self, temperature: f64) -> f64 {
        self.kinematic_viscosity(temperature) * 1e-6 * self.density(temperature)
    }
}

/// Pressure–viscosity coefficient [1/Pa] of a mineral oil with a dynamic viscosity [Pa s]: (0.6 + 0.965 lg η) 10⁻⁸, η in mPa s (Wooster).
/// Typical to ±20 %; 0 below 0.24 mPa s, where the formula is negative.
pub fn mineral_pressure_viscosity(viscosity: f64) -> f64 {
    ((0.6 + 0.965 * (viscosity * 1e3).log10()) * 1e-8).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grade(name: &str) -> Oil {
        grades().iter().find(|grade| grade.name == name).unwrap().oil
    }

    fn assert_rounds(value: f64, expected: f64, half_digit: f64) {
        assert!((value - expected).abs() <= half_digit, "{value} instead of {expected}");
    }

    #[test]
    fn grades_are_those_of_iso_3448() {
        let names: Vec<_> = grades().iter().map(|grade| grade.oil.viscosity_40).collect();
        assert_eq!(names, [10.0, 15.0, 22.0, 32.0, 46.0, 68.0, 100.0, 150.0, 220.0, 320.0, 460.0]);
        assert!(grades().iter().all(|grade| grade.name == format!("iso-vg-{}", grade.oil.viscosity_40)));
    }

    #[test]
    fn vg_46_thins_by_walther() {
        let oil = grade("iso-vg-46");
        for (temperature, viscosity) in [(40.0, 46.0), (60.0, 20.38), (80.0, 10.89), (100.0, 6.64)] {
            assert_rounds(oil.kinematic_viscosity(temperature), viscosity, 0.005);
        }
        assert_rounds(mineral_pressure_viscosity(oil.viscosity(40.0)) * 1e8, 2.14, 0.005);
        assert_rounds(mineral_pressure_viscosity(oil.viscosity(80.0)) * 1e8, 1.52, 0.005);
    }

    #[test]
    fn two_viscosities_make_an_oil() {
        let oil = Oil { viscosity_40: 120.0, viscosity_100: 12.0, density_15: 870.0 };
        assert_rounds(oil.kinematic_viscosity(80.0), 21.55, 0.005);
        // 870 − 0.65 (T − 15)
        assert_rounds(oil.density(15.0), 870.0, 1e-9);
        assert_rounds(oil.density(80.0), 827.75, 1e-9);
    }

    /// The columns that follow from the others, to their rounding; A and B follow from viscosities that were rounded afterwards.
    #[test]
    fn every_line_follows_from_its_viscosities() {
        for line in FILE.lines().skip(1) {
            let cells: Vec<&str> = line.split(',').collect();
            let number = |place: usize| cells[place].parse::<f64>().unwrap();
            let oil = grade(cells[0]);
            let law = oil.walther();
            assert!((law.a - number(3)).abs() < 2e-2 && (law.b - number(4)).abs() < 1e-2, "{line}: {law:?}");
            for (temperature, viscosity, pressure) in [(60.0, number(6), None), (80.0, number(7), Some(number(9)))] {
                assert!((oil.kinematic_viscosity(temperature) / viscosity - 1.0).abs() < 2e-3, "{line}");
                let ours = mineral_pressure_viscosity(oil.viscosity(temperature));
                assert!(pressure.is_none_or(|theirs| (ours - theirs).abs() < 0.6e-10), "{line}: {ours}");
            }
            let ours = mineral_pressure_viscosity(oil.viscosity(40.0));
            assert!((ours - number(8)).abs() < 0.6e-10, "{line}: {ours}");
        }
    }
}
