# docker build -t brickpose . && docker run --rm -p 8080:8080 brickpose
FROM python:3.13-slim-trixie AS build
WORKDIR /sources
COPY . .
RUN python -m venv /opt/brickpose \
 && /opt/brickpose/bin/pip install --no-cache-dir --require-hashes --requirement requirements.lock \
 && /opt/brickpose/bin/pip install --no-cache-dir --no-deps --no-build-isolation .

FROM python:3.13-slim-trixie
COPY --from=build /opt/brickpose /opt/brickpose
RUN useradd --create-home --uid 1000 driver \
 && install --directory --owner 1000 --group 1000 --mode 700 /var/cache/brickpose
USER 1000
# Recordings, profiles and a student's file are written here; -v keeps them.
WORKDIR /home/driver
# What is compiled lies outside of the home, which a hub's volume hides.
ENV PATH=/opt/brickpose/bin:$PATH NUMBA_CACHE_DIR=/var/cache/brickpose
# What would be compiled at the first start.
RUN python -m app.tools.warm_up
EXPOSE 8080
# Everybody in the network may connect: the program prints a link with a token, or takes the token
# of -e BRICKPOSE_TOKEN=...
ENTRYPOINT ["brickpose"]
CMD ["run", "--host", "0.0.0.0"]
