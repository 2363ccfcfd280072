mod accepted;
mod optimum;
mod refused;
mod results;
mod schema;
mod several_errors;
mod study;
mod surfaces;

mod requests;
