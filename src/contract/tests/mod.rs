mod accepted;
mod refused;
mod results;
mod schema;
mod study;
