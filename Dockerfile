# syntax=docker/dockerfile:1
# Build: the dependencies are compiled in a layer of their own, which only a change of the lock file renews.
FROM rust:1.95-slim-bookworm AS build
RUN apt-get update && apt-get install --yes --no-install-recommends gcc libc6-dev && rm -rf /var/lib/apt/lists/*
WORKDIR /build
# The image's own compiler is the pinned one; without its name the toolchain file would ask for more components.
ENV SQLX_OFFLINE=true RUSTUP_TOOLCHAIN=1.95.0
COPY Cargo.toml Cargo.lock ./
COPY core/Cargo.toml core/
COPY benches benches
COPY tests/otlp.rs tests/
RUN mkdir src core/src && echo '//! Dependencies only.' | tee src/lib.rs > core/src/lib.rs && echo 'fn main() {}' > src/main.rs \
    && cargo build --locked --profile dist --features otlp --bin trunnion && rm -rf src core/src
COPY . .
# The sources are newer than the stand-ins, whatever their time stamps say.
RUN touch core/src/lib.rs src/lib.rs src/main.rs && cargo build --locked --profile dist --features otlp --bin trunnion

FROM debian:bookworm-slim
# Receivers of webhooks are trusted by the system's certificates.
RUN apt-get update && apt-get install --yes --no-install-recommends ca-certificates && rm -rf /var/lib/apt/lists/*
RUN groupadd --system --gid 10001 trunnion \
    && useradd --system --uid 10001 --gid trunnion --no-create-home --shell /usr/sbin/nologin trunnion \
    && install --directory --owner trunnion --group trunnion /data
COPY --from=build /build/target/dist/trunnion /usr/local/bin/trunnion
USER trunnion
VOLUME /data
EXPOSE 8080
# Off loopback it starts only with an API key: run `trunnion keys create` on the volume first.
ENV TRUNNION_LISTEN=0.0.0.0:8080 TRUNNION_DATA_DIR=/data
HEALTHCHECK --interval=15s --timeout=3s --start-period=5s --retries=3 CMD ["trunnion", "healthcheck"]
STOPSIGNAL SIGTERM
ENTRYPOINT ["trunnion"]
CMD ["serve"]
