mod accepted;
mod life;
mod loads;
mod mode_accuracy;
mod optimum;
mod ordering;
mod refused;
mod results;
mod schema;
mod several_errors;
mod spindles;
mod study;
mod surface_messages;
mod surfaces;
mod uncertainty;

mod requests;
