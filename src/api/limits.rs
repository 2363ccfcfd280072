//! Limits of the size of a request.

/// Largest body [B].
pub const BODY_LIMIT: usize = 1 << 20;

/// Largest body with an uploaded series [B].
pub const SERIES_LIMIT: usize = 32 << 20;

/// Largest request header, request line included [B].
pub const HEADER_LIMIT: usize = 64 << 10;
