//! The request: the scene, the settings of the run and its outputs. Knows no equation of motion.

pub mod channel;

pub mod model_level;

pub mod scene;

pub mod settings;

pub mod series_sink;

pub mod control;
