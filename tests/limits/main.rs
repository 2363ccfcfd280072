//! Limits that physics sets to the model, a file a law. Tolerances are stated where they are used, with their reason:
//! "to rounding" is measured against the sizes of what is added up, "to integration error" falls with the tolerance.

mod scenes;

mod energy;
mod mirror_symmetry;
mod momentum;
mod plane_motion;
mod rotation_symmetry;
mod static_distribution;
