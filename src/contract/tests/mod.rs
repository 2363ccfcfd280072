mod accepted;
mod optimum;
mod refused;
mod results;
mod schema;
mod study;
