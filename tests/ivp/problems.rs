//! Initial value problems with known end values, most of them from the Test Set for IVP Solvers
//! (F. Mazzia et al., University of Bari) and from Hairer & Wanner, *Solving Ordinary Differential Equations II*.
//!
//! Every published end value was recomputed once in 128-bit arithmetic by another method (linearly implicit
//! extrapolation, at two tolerances). The comment at a problem states where both values differ.

// End values are given with the digits in which they were published.
#![allow(clippy::excessive_precision)]

use raceway::numerics::ode::structure::Jacobian;
use raceway::numerics::ode::{OdeSystem, Tolerances, dense_differences};

pub const E5: &str = "E5";

type Rate = Box<dyn Fn(f64, &[f64], &mut [f64])>;
type Slope = fn(&[f64], &mut [f64]);

/// A problem with its solution.
pub struct Problem {
    pub name: &'static str,
    rate: Rate,
    /// Writes ∂f/∂y row by row. Given only where difference quotients would violate a conservation law of the problem.
    slope: Option<Slope>,
    pub start: Vec<f64>,
    pub end: f64,
    /// State at `end`.
    pub answer: Vec<f64>,
    /// Smallest relative error that a tolerance reaches: the reliable digits of the solution, or rounding.
    pub floor: f64,
    /// Absolute over relative tolerance of each component.
    pub scale: Vec<f64>,
    /// Whether the problem is too stiff for an explicit method.
    pub stiff: bool,
}

impl OdeSystem for Problem {
    fn dimension(&self) -> usize {
        self.start.len()
    }

    fn derivative(&self, time: f64, state: &[f64], derivative: &mut [f64]) {
        (self.rate)(time, state, derivative);
    }

    fn jacobian(&self, time: f64, state: &[f64], rate: &[f64], displacement: &[f64], jacobian: &mut Jacobian) -> u64 {
        match self.slope {
            Some(slope) => {
                slope(state, jacobian.corner_mut());
                0
            }
            None => dense_differences(self, time, state, rate, displacement, jacobian),
        }
    }
}

impl Problem {
    /// The tolerances of a run: relative, and absolute for each component.
    pub fn tolerances(&self, relative: f64) -> Tolerances {
        Tolerances {
            relative: vec![relative; self.start.len()],
            absolute: self.scale.iter().map(|scale| relative * scale).collect(),
        }
    }

    /// The compared components of a state. E5 compares the mean of y₂ and y₃ in place of both.
    fn reading(&self, state: &[f64]) -> Vec<f64> {
        let mut reading = state.to_vec();
        if self.name == E5 {
            reading[1..3].fill(0.5 * (state[1] + state[2]));
        }
        reading
    }

    /// Largest error of an end state, each component relative to its size and scale. It is at most the relative tolerance
    /// where the tolerance is met.
    pub fn error(&self, state: &[f64]) -> f64 {
        let reading = self.reading(state);
        let errors = reading.iter().zip(&self.answer).zip(&self.scale);
        errors.map(|((y, answer), scale)| (y - answer).abs() / (answer.abs() + scale)).fold(0.0, f64::max)
    }
}

pub fn all() -> Vec<Problem> {
    vec![
        robertson(),
        hires(),
        oregonator(),
        van_der_pol_slow(),
        van_der_pol_fast(),
        e5(),
        pollution(),
        pleiades(),
        prothero_robinson(-1e6),
        curtiss_hirschfelder(),
    ]
}

/// Three reactions over 18 decades of time. The published y₃ violates y₁ + y₂ + y₃ = 1 by 1e-14; here y₃ = 1 − y₁ − y₂.
///
/// The solution is known to 12 digits. At the end y₁ changes by 2e-19 a second, the difference of two rates of 8e-10. The
/// rounding of these rates shows in the ninth digit at any tolerance.
fn robertson() -> Problem {
    let (y1, y2) = (2.083_340_149_701e-8, 8.333_360_770_335e-14);
    Problem {
        name: "Robertson",
        rate: Box::new(|_, y, dy| {
            let (first, second, third) = (0.04 * y[0], 3e7 * y[1] * y[1], 1e4 * y[1] * y[2]);
            dy.copy_from_slice(&[third - first, first - second - third, second]);
        }),
        slope: Some(|y, slope| {
            let (second, third, of_third) = (6e7 * y[1], 1e4 * y[2], 1e4 * y[1]);
            slope[..3].copy_from_slice(&[-0.04, third, of_third]);
            slope[3..6].copy_from_slice(&[0.04, -third - second, -of_third]);
            slope[6..].copy_from_slice(&[0.0, second, 0.0]);
        }),
        start: vec![1.0, 0.0, 0.0],
        end: 1e11,
        answer: vec![y1, y2, 1.0 - y1 - y2],
        floor: 1e-8,
        scale: vec![1e-8, 1e-14, 1e-8],
        stiff: true,
    }
}

/// Growth of plants under light: eight reactants, a fast change after a long slow phase.
fn hires() -> Problem {
    Problem {
        name: "HIRES",
        rate: Box::new(|_, y, dy| {
            let bound = 280.0 * y[5] * y[7];
            dy[0] = -1.71 * y[0] + 0.43 * y[1] + 8.32 * y[2] + 0.0007;
            dy[1] = 1.71 * y[0] - 8.75 * y[1];
            dy[2] = -10.03 * y[2] + 0.43 * y[3] + 0.035 * y[4];
            dy[3] = 8.32 * y[1] + 1.71 * y[2] - 1.12 * y[3];
            dy[4] = -1.745 * y[4] + 0.43 * (y[5] + y[6]);
            dy[5] = -bound + 0.69 * y[3] + 1.71 * y[4] - 0.43 * y[5] + 0.69 * y[6];
            dy[6] = bound - 1.81 * y[6];
            dy[7] = -dy[6];
        }),
        slope: None,
        start: vec![1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0057],
        end: 321.8122,
        answer: vec![
            0.7371312573325668e-3,
            0.1442485726316185e-3,
            0.5888729740967575e-4,
            0.1175651343283149e-2,
            0.2386356198831331e-2,
            0.6238968252742796e-2,
            0.2849998395185769e-2,
            0.2850001604814231e-2,
        ],
        floor: 1e-14,
        scale: vec![1e-4; 8],
        stiff: true,
    }
}

/// The Oregonator. The published y₂ and y₃ have relative errors of 2e-14 and 1.5e-13; here as recomputed.
fn oregonator() -> Problem {
    Problem {
        name: "OREGO",
        rate: Box::new(|_, y, dy| {
            dy[0] = 77.27 * (y[1] + y[0] * (1.0 - 8.375e-6 * y[0] - y[1]));
            dy[1] = (y[2] - (1.0 + y[0]) * y[1]) / 77.27;
            dy[2] = 0.161 * (y[0] - y[2]);
        }),
        slope: None,
        start: vec![1.0, 2.0, 3.0],
        end: 360.0,
        answer: vec![1.000_814_870_318_522_7, 1_228.178_521_549_888, 132.055_494_284_650_83],
        floor: 1e-12,
        scale: vec![1.0; 3],
        stiff: true,
    }
}

/// State of van der Pol's oscillator, mu = 1000, at t = 2000; with eps = 1e-6 at t = 2 the same, y₂ times 1000.
/// Three variants of y₁ are in print that differ from the 14th digit on, one of them (…524) from the 13th.
const RELAXED: [f64; 2] = [1.706_167_732_170_465, -0.892_809_701_024_815_5e-3];

fn van_der_pol_slow() -> Problem {
    Problem {
        name: "van der Pol, mu = 1e3",
        rate: Box::new(|_, y, dy| dy.copy_from_slice(&[y[1], 1e3 * (1.0 - y[0] * y[0]) * y[1] - y[0]])),
        slope: None,
        start: vec![2.0, 0.0],
        end: 2000.0,
        answer: RELAXED.to_vec(),
        floor: 1e-13,
        scale: vec![1.0, 1e-3],
        stiff: true,
    }
}

/// The end is t = 2, because the solution at t = 11 is known to fewer digits.
fn van_der_pol_fast() -> Problem {
    Problem {
        name: "van der Pol, eps = 1e-6",
        rate: Box::new(|_, y, dy| dy.copy_from_slice(&[y[1], ((1.0 - y[0] * y[0]) * y[1] - y[0]) / 1e-6])),
        slope: None,
        start: vec![2.0, 0.0],
        end: 2.0,
        answer: vec![RELAXED[0], 1e3 * RELAXED[1]],
        floor: 1e-12,
        scale: vec![1.0; 2],
        stiff: true,
    }
}

/// Pyrolysis. The reactants fall to 1e-22, and the result depends on their difference.
///
/// The published y₂ = 8.8677e-23 and y₃ = 8.8548e-23 are wrong from the third digit on. All rates conserve y₂ = y₃ + y₄,
/// and y₄ ≤ B y₁ y₃ / C has vanished by then. Without y₄, y₂' = −MC y₂² gives y₂ → 1/(MC (t − t*)) with
/// 1/(MC t) = 8.850e-23. The recomputed value agrees for t* = 1.3e10. y₁ decays as e^{−At} to zero.
///
/// The equations conserve y₂ − y₃. Both come down from 1.5e-10, where one rounding is 2.6e-26. In double precision each ends
/// with an error of 0.1 to 1 percent; their mean has only the square of that error.
fn e5() -> Problem {
    Problem {
        name: E5,
        rate: Box::new(|_, y, dy| {
            let (first, second, third) = (7.89e-10 * y[0], 1.1e7 * y[0] * y[2], 1.13e9 * y[1] * y[2]);
            let fourth = 1.13e3 * y[3];
            let products = second - fourth;
            dy.copy_from_slice(&[-first - second, first - third, first - third - products, products]);
        }),
        slope: Some(|y, slope| {
            let (first, by_first, by_third) = (-7.89e-10, 1.1e7 * y[2], 1.1e7 * y[0]);
            let (of_second, of_third) = (1.13e9 * y[2], 1.13e9 * y[1]);
            slope[..4].copy_from_slice(&[first - by_first, 0.0, -by_third, 0.0]);
            slope[4..8].copy_from_slice(&[-first, -of_second, -of_third, 0.0]);
            slope[8..12].copy_from_slice(&[-first - by_first, -of_second, -of_third - by_third, 1.13e3]);
            slope[12..].copy_from_slice(&[by_first, 0.0, by_third, -1.13e3]);
        }),
        start: vec![1.76e-3, 0.0, 0.0, 0.0],
        end: 1e13,
        answer: vec![0.0, 8.861_233_52e-23, 8.861_233_52e-23, 0.0],
        floor: 2e-6,
        scale: vec![1e-24; 4],
        stiff: true,
    }
}

/// Air pollution: 25 reactions of 20 species.
fn pollution() -> Problem {
    let mut start = vec![0.0; 20];
    for (species, amount) in [(2, 0.2), (4, 0.04), (7, 0.1), (8, 0.3), (9, 0.01), (17, 0.007)] {
        start[species - 1] = amount;
    }
    let answer = vec![
        0.5646255480022769e-01,
        0.1342484130422339,
        0.4139734331099427e-08,
        0.5523140207484359e-02,
        0.2018977262302196e-06,
        0.1464541863493966e-06,
        0.7784249118997964e-01,
        0.3245075353396018,
        0.7494013383880406e-02,
        0.1622293157301561e-07,
        0.1135863833257075e-07,
        0.2230505975721359e-02,
        0.2087162882798630e-03,
        0.1396921016840158e-04,
        0.8964884856898295e-02,
        0.4352846369330103e-17,
        0.6899219696263405e-02,
        0.1007803037365946e-03,
        0.1772146513969984e-05,
        0.5682943292316392e-04,
    ];
    Problem {
        name: "POLLU",
        rate: Box::new(pollution_rate),
        // Trace species: the scale of each is a thousandth of its end value.
        scale: answer.iter().map(|amount| 1e-3 * amount).collect(),
        slope: None,
        start,
        end: 60.0,
        answer,
        floor: 1e-14,
        stiff: true,
    }
}

fn pollution_rate(_time: f64, y: &[f64], dy: &mut [f64]) {
    const K: [f64; 25] = [
        0.35, 26.6, 1.23e4, 8.6e-4, 8.2e-4, 1.5e4, 1.3e-4, 2.4e4, 1.65e4, 9e3, 0.022, 1.2e4, 1.88, 1.63e4, 4.8e6,
        3.5e-4, 0.0175, 1e8, 4.44e11, 1.24e3, 2.1, 5.78, 0.0474, 1.78e3, 3.12,
    ];
    /// Reactants, counted from 1; 0: none.
    const REACTANTS: [[usize; 2]; 25] = [
        [1, 0],
        [2, 4],
        [5, 2],
        [7, 0],
        [7, 0],
        [7, 6],
        [9, 0],
        [9, 6],
        [11, 2],
        [11, 1],
        [13, 0],
        [10, 2],
        [14, 0],
        [1, 6],
        [3, 0],
        [4, 0],
        [4, 0],
        [16, 0],
        [16, 0],
        [17, 6],
        [19, 0],
        [19, 0],
        [1, 4],
        [19, 1],
        [20, 0],
    ];
    let amount = |species: usize| if species == 0 { 1.0 } else { y[species - 1] };
    let mut r = [0.0; 26];
    for (reaction, [first, second]) in REACTANTS.iter().enumerate() {
        r[reaction + 1] = K[reaction] * amount(*first) * amount(*second);
    }
    dy[0] = -r[1] - r[10] - r[14] - r[23] - r[24] + r[2] + r[3] + r[9] + r[11] + r[12] + r[22] + r[25];
    dy[1] = -r[2] - r[3] - r[9] - r[12] + r[1] + r[21];
    dy[2] = -r[15] + r[1] + r[17] + r[19] + r[22];
    dy[3] = -r[2] - r[16] - r[17] - r[23] + r[15];
    dy[4] = -r[3] + 2.0 * r[4] + r[6] + r[7] + r[13] + r[20];
    dy[5] = -r[6] - r[8] - r[14] - r[20] + r[3] + 2.0 * r[18];
    dy[6] = -r[4] - r[5] - r[6] + r[13];
    dy[7] = r[4] + r[5] + r[6] + r[7];
    dy[8] = -r[7] - r[8];
    dy[9] = -r[12] + r[7] + r[9];
    dy[10] = -r[9] - r[10] + r[8] + r[11];
    dy[11] = r[9];
    dy[12] = -r[11] + r[10];
    dy[13] = -r[13] + r[12];
    dy[14] = r[14];
    dy[15] = -r[18] - r[19] + r[16];
    dy[16] = -r[20];
    dy[17] = r[20];
    dy[18] = -r[21] - r[22] - r[24] + r[23] + r[25];
    dy[19] = -r[25] + r[24];
}

/// Seven stars with close encounters; not stiff. State: x, y, and their rates.
fn pleiades() -> Problem {
    Problem {
        name: "Pleiades",
        rate: Box::new(|_, y, dy| {
            dy[..14].copy_from_slice(&y[14..]);
            for i in 0..7 {
                let (mut along, mut across) = (0.0, 0.0);
                for j in (0..7).filter(|&j| j != i) {
                    let (x, y) = (y[j] - y[i], y[7 + j] - y[7 + i]);
                    let pull = (j + 1) as f64 / (x * x + y * y).powf(1.5);
                    along += pull * x;
                    across += pull * y;
                }
                (dy[14 + i], dy[21 + i]) = (along, across);
            }
        }),
        slope: None,
        start: vec![
            3.0, 3.0, -1.0, -3.0, 2.0, -2.0, 2.0, 3.0, -3.0, 2.0, 0.0, 0.0, -4.0, 4.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.75,
            -1.5, 0.0, 0.0, 0.0, -1.25, 1.0, 0.0, 0.0,
        ],
        end: 3.0,
        answer: vec![
            0.3706139143970502,
            3.237284092057233,
            -3.222559032418324,
            0.6597091455775310,
            0.3425581707156584,
            1.562172101400631,
            -0.7003092922212495,
            -3.943437585517392,
            -3.271380973972550,
            5.225081843456543,
            -2.590612434977470,
            1.198213693392275,
            -0.2429682344935824,
            1.091449240428980,
            3.417003806314313,
            1.354584501625501,
            -2.590065597810775,
            2.025053734714242,
            -1.155815100160448,
            -0.8072988170223021,
            0.5952396354208710,
            -3.741244961234010,
            0.3773459685750630,
            0.9386858869551073,
            0.3667922227200571,
            -0.3474046353808490,
            2.344915448180937,
            -1.947020434263292,
        ],
        floor: 1e-13,
        scale: vec![1.0; 28],
        stiff: false,
    }
}

/// `y' = lambda (y − sin t) + cos t` with the solution sin t, which is smooth in spite of the stiffness.
pub fn prothero_robinson(lambda: f64) -> Problem {
    Problem {
        name: "Prothero-Robinson",
        rate: Box::new(move |t, y, dy| dy[0] = lambda * (y[0] - t.sin()) + t.cos()),
        slope: None,
        start: vec![0.0],
        end: 10.0,
        answer: vec![10f64.sin()],
        floor: 1e-15,
        scale: vec![1.0],
        stiff: true,
    }
}

/// `y' = −50 (y − cos t)`, started away from its slow solution. The end value is exact.
fn curtiss_hirschfelder() -> Problem {
    let exact = |t: f64| (2500.0 * t.cos() + 50.0 * t.sin()) / 2501.0 - 2500.0 / 2501.0 * (-50.0 * t).exp();
    Problem {
        name: "Curtiss-Hirschfelder",
        rate: Box::new(|t, y, dy| dy[0] = -50.0 * (y[0] - t.cos())),
        slope: None,
        start: vec![0.0],
        end: 10.0,
        answer: vec![exact(10.0)],
        floor: 1e-15,
        scale: vec![1.0],
        stiff: false,
    }
}
