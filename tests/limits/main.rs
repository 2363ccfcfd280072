//! Limits that physics sets to the model, a file a law. Tolerances are stated where they are used, with their reason:
//! "to rounding" is measured against the sizes of what is added up, "to integration error" falls with the tolerance.

mod article;
mod article_run;
mod scenes;

mod dissipation;
mod energy;
mod extremes;
mod instructions;
mod jacobian;
mod judgement;
mod ladder;
mod mirror_symmetry;
mod momentum;
mod other_integrator;
mod passage_frequencies;
mod plane_motion;
mod quasi_static;
mod radially_condensed;
mod repeatability;
mod rolling;
mod rotation_symmetry;
mod settling;
mod spindle_only;
mod stability;
mod static_distribution;
mod steps_of_fixed_length;
mod surface_profile;
