mod accepted;
mod refused;
mod results;
