//! What is asked for: the scene, how to simulate it, which outputs. Knows no equation of motion.

pub mod channel;
pub mod control;
pub mod model_level;
pub mod scene;
pub mod settings;
