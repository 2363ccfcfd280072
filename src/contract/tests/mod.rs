mod accepted;
mod refused;
