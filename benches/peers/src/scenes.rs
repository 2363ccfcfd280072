//! The scenes, the grid on which solutions are compared, and the deviation of two solutions.

use raceway::contract::scene_from_json;
use raceway::numerics::ode::OdeSystem;
use raceway::simulation::input::channel::{Axis, Channel, Motion};
use raceway::simulation::model::equilibrium::start_state;
use raceway::simulation::result::metrics::channel_metrics;
use raceway::simulation::model::Model;
use raceway::simulation::model::terms::ActiveTerms;
use raceway::simulation::recording::sampling::RATE;
use raceway::simulation::input::settings::Outputs;
use raceway::simulation::model::state::Layout;

/// A scene by name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum Scene {
    /// The article's case.
    A,
    /// The article's case with traction that saturates at 1 mm/s of slip, which is stiff.
    B,
}

impl Scene {
    pub fn json(self) -> &'static str {
        match self {
            Self::A => r#"{"bearing":"article-integrated","operation":{"speed_rpm":50000,"radial_load_y_n":200}}"#,
            Self::B => {
                r#"{"bearing":"article-integrated","operation":{"speed_rpm":50000,"radial_load_y_n":200},"lubricant":{"kind":"grease","traction":{"law":"four_parameter","at_slip_m_s":0.001}}}"#
            }
        }
    }
}

/// A scene ready to run.
pub struct Case {
    pub model: Model,
    pub start: Vec<f64>,
    /// Times at which solutions are compared [s]: the recorded time at the sampling rate of the library.
    pub grid: Vec<f64>,
}

impl Case {
    pub fn new(scene: Scene, settle: f64, duration: f64) -> Result<Self, String> {
        let scene = scene_from_json(scene.json()).map_err(|error| format!("{error:?}"))?;
        let outputs = Outputs { contacts: true, cage: true, ..Outputs::vibration() };
        let needs = ActiveTerms::of(&scene, &outputs, None).map_err(|error| error.to_string())?;
        let model = Model::new(&scene, &needs);
        let start = start_state(&model).map_err(|error| error.to_string())?;
        let values = (duration * RATE).round() as usize;
        let grid = (0..=values).map(|i| settle + i as f64 / RATE).collect();
        Ok(Self { model, start, grid })
    }

    pub fn layout(&self) -> Layout {
        self.model.mechanism().layout
    }

    pub fn end(&self) -> f64 {
        self.grid.last().copied().unwrap_or(0.0)
    }

    /// Levels of the spindle's acceleration in y and z [dB], of the states on the grid.
    fn levels(&self, states: &[f64]) -> [f64; 2] {
        let layout = self.layout();
        let mut rate = vec![0.0; layout.dimension()];
        let mut signals = [Vec::with_capacity(self.grid.len()), Vec::with_capacity(self.grid.len())];
        for (state, time) in states.chunks_exact(layout.dimension()).zip(&self.grid) {
            self.model.derivative(*time, state, &mut rate);
            let acceleration = layout.spindle(&rate).velocity;
            signals[0].push(acceleration[1]);
            signals[1].push(acceleration[2]);
        }
        let level = |axis, signal: &[f64]| {
            let channel = Channel::Spindle(axis, Motion::Acceleration);
            channel_metrics(channel, signal, 0.0).level_db.unwrap_or(f64::NAN)
        };
        [level(Axis::Y, &signals[0]), level(Axis::Z, &signals[1])]
    }
}

/// The reference of other solutions.
pub struct Reference {
    states: Vec<f64>,
    levels: [f64; 2],
    /// Standard deviation of each component over the grid, but at least 1 % of its size.
    scales: Vec<f64>,
}

/// Errors of a solution.
#[derive(Debug, Clone, Copy)]
pub struct Deviation {
    /// Larger level error of y and z [dB].
    pub level: f64,
    /// Root of the mean square over components and grid of the deviation over its scale.
    pub trajectory: f64,
}

/// Least scale over size.
const LEAST_SCALE: f64 = 0.01;

impl Reference {
    pub fn new(case: &Case, states: Vec<f64>) -> Self {
        let sizes = case.layout().sizes();
        let scales = (0..sizes.len())
            .map(|i| {
                let of = || states.iter().skip(i).step_by(sizes.len());
                let count = of().count() as f64;
                let mean = of().sum::<f64>() / count;
                let variance = of().map(|y| (y - mean).powi(2)).sum::<f64>() / count;
                variance.sqrt().max(LEAST_SCALE * sizes[i])
            })
            .collect();
        let levels = case.levels(&states);
        Self { states, levels, scales }
    }

    pub fn levels(&self) -> [f64; 2] {
        self.levels
    }

    pub fn deviation(&self, case: &Case, states: &[f64]) -> Deviation {
        let levels = case.levels(states);
        let level = levels.iter().zip(self.levels).map(|(found, true_)| (found - true_).abs()).fold(0.0, f64::max);
        let square =
            |(i, (y, reference)): (usize, (&f64, &f64))| ((y - reference) / self.scales[i % self.scales.len()]).powi(2);
        let sum: f64 = states.iter().zip(&self.states).enumerate().map(square).sum();
        Deviation { level, trajectory: (sum / states.len() as f64).sqrt() }
    }
}
