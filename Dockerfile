# Builds and runs the service with its database on the volume /data:
#
#   docker build -t raceway .
#   docker run -p 127.0.0.1:8080:8080 -v raceway:/data -e RACEWAY_API_TOKENS="$(openssl rand -hex 32)" raceway
#
# Inside a container the service listens on all interfaces, so it does not start without RACEWAY_API_TOKENS
# (or, at your own risk, RACEWAY_INSECURE_NO_AUTH=true).
#
# RUST_DIGEST and DEBIAN_DIGEST (`sha256:…`) fix the base images; `.ci/release` refuses to build without them.

ARG RUST_DIGEST
ARG DEBIAN_DIGEST
FROM rust:1.95-bookworm${RUST_DIGEST:+@$RUST_DIGEST} AS builder
WORKDIR /source
COPY Cargo.toml Cargo.lock build.rs ./
COPY crates crates
COPY src src
COPY migrations migrations
COPY verification verification
# Needed only because Cargo.toml lists them.
COPY benches benches
RUN cargo build --release --locked --bin raceway

FROM debian:bookworm-slim${DEBIAN_DIGEST:+@$DEBIAN_DIGEST}
RUN useradd --system --uid 10001 --user-group --home-dir /data --shell /usr/sbin/nologin raceway \
    && install --directory --owner raceway --group raceway --mode 0750 /data
COPY --from=builder /source/target/release/raceway /usr/local/bin/raceway
USER 10001:10001
WORKDIR /data
VOLUME /data
EXPOSE 8080
STOPSIGNAL SIGTERM
HEALTHCHECK --interval=10s --timeout=6s --start-period=10s --retries=3 \
    CMD ["raceway", "health", "--listen", "127.0.0.1:8080"]
ENTRYPOINT ["raceway"]
CMD ["serve", "--listen", "0.0.0.0:8080", "--database", "sqlite:///data/raceway.db"]
