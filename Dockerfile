# syntax=docker/dockerfile:1
# `manifests` has what says which dependencies there are, `build` compiles them and then the service, `sbom` lists what is compiled in.
# Only a change of a manifest or of the lock file compiles the dependencies again; a change of docs, tests or benchmarks compiles nothing.
FROM rust:1.95-slim-bookworm AS manifests
SHELL ["/bin/bash", "-o", "pipefail", "-c"]
# hadolint ignore=DL3008
RUN apt-get update && apt-get install --yes --no-install-recommends gcc libc6-dev && rm -rf /var/lib/apt/lists/*
WORKDIR /build
# The image's own compiler is the pinned one; without its name the toolchain file would ask for more components.
ENV RUSTUP_TOOLCHAIN=1.95.0
COPY Cargo.toml Cargo.lock ./
COPY core/Cargo.toml core/
# Macros that every build needs; they seldom change.
COPY description description
# Stand-ins for the sources, and for every test and benchmark that the manifest names: cargo wants them to exist.
RUN mkdir -p src core/src benches tests \
    && sed -n '/^\[\[bench\]\]/{n;s/^name = "\(.*\)"/benches\/\1.rs/p};/^\[\[test\]\]/{n;s/^name = "\(.*\)"/tests\/\1.rs/p}' \
      Cargo.toml | xargs touch \
    && echo '//! Dependencies only.' | tee src/lib.rs >core/src/lib.rs \
    && echo 'fn main() {}' | tee src/main.rs >build.rs

FROM manifests AS build
RUN cargo build --locked --profile dist --features otlp,scale-out --bin trunnion && rm -r src core/src build.rs
# Only what is compiled in (`tests/api/deploy.rs`).
COPY build.rs ./
COPY migrations migrations
COPY migrations-postgres migrations-postgres
COPY openapi openapi
COPY docs/examples docs/examples
COPY page/dist page/dist
COPY core core
COPY src src
# The sources are newer than the stand-ins, whatever their time stamps say.
RUN touch build.rs core/src/lib.rs src/lib.rs src/main.rs \
    && cargo build --locked --profile dist --features otlp,scale-out --bin trunnion

FROM manifests AS sbom
RUN cargo install --locked cargo-cyclonedx@0.5.9
COPY deploy/sbom deploy/
ARG SOURCE_DATE_EPOCH=0
RUN deploy/sbom /trunnion.cdx.json '' otlp,scale-out

FROM debian:bookworm-slim
# Receivers of webhooks are trusted by the system's certificates.
# hadolint ignore=DL3008
RUN apt-get update && apt-get install --yes --no-install-recommends ca-certificates && rm -rf /var/lib/apt/lists/*
RUN groupadd --system --gid 10001 trunnion \
    && useradd --system --uid 10001 --gid trunnion --no-create-home --shell /usr/sbin/nologin trunnion \
    && install --directory --owner trunnion --group trunnion /data
COPY --from=sbom /trunnion.cdx.json /usr/share/doc/trunnion/sbom.cdx.json
COPY --from=build /build/target/dist/trunnion /usr/local/bin/trunnion
# By number: Kubernetes then sees that it is not root.
USER 10001:10001
VOLUME /data
EXPOSE 8080
# Off loopback the service starts only with an API key. Without one it prints the command that makes the first.
ENV TRUNNION_LISTEN=0.0.0.0:8080 TRUNNION_DATA_DIR=/data
HEALTHCHECK --interval=15s --timeout=3s --start-period=5s --retries=3 CMD ["trunnion", "healthcheck"]
STOPSIGNAL SIGTERM
ENTRYPOINT ["trunnion"]
CMD ["serve"]
# `deploy/image` gives commit and date.
ARG VERSION=0.2.0
ARG REVISION=
ARG CREATED=
LABEL org.opencontainers.image.title="Trunnion" \
      org.opencontainers.image.description="One HTTP service for five-axis machine tools: kinematics and NC program compensation" \
      org.opencontainers.image.version="$VERSION" \
      org.opencontainers.image.revision="$REVISION" \
      org.opencontainers.image.created="$CREATED" \
      org.opencontainers.image.licenses="MIT OR Apache-2.0" \
      org.opencontainers.image.base.name="docker.io/library/debian:bookworm-slim"
