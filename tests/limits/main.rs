//! Physical laws that the model must obey, a file a law. Each tolerance is stated with its reason where it is used. "To
//! rounding" is relative to the sizes of the summands. "To integration error" falls with the tolerance of the run.

mod article;
mod article_run;
mod scenes;

mod ball_surfaces;
mod condensed_defects;
mod contact_points;
mod defects;
mod dissipation;
mod energy;
mod extremes;
mod initial_perturbation;
mod instructions;
mod jacobian;
mod ladder;
mod loads;
mod mirror_symmetry;
mod momentum;
mod neighbours;
mod other_integrator;
mod outer_ring;
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
mod tilting_spindle;
mod unequal_balls;
mod waviness;
mod wrong_answers;
