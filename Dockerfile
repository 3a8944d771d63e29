# One image for the service, the Dask scheduler and the workers.

# The image below all: name it by its digest to have the same bytes each time (docs/deployment.md).
ARG PYTHON_IMAGE=python:3.11-slim

FROM ${PYTHON_IMAGE} AS build

ENV PIP_DISABLE_PIP_VERSION_CHECK=1 PIP_NO_CACHE_DIR=1 PIP_NO_INPUT=1
RUN python -m venv /opt/venv
ENV PATH=/opt/venv/bin:$PATH
WORKDIR /src

# The locked packages first, each checked against its hash: this layer changes only with the lock.
# It holds the extras of a deployed service too: the PostgreSQL driver, Parquet, DXF and traces.
COPY requirements-image.lock ./
RUN pip install -r requirements-image.lock

COPY pyproject.toml README.md CONTRIBUTING.md CHANGELOG.md LICENSE ./
COPY docs docs
COPY checker checker
COPY openapi openapi
COPY synthesis synthesis
COPY service service
RUN pip install --no-deps . && pip check


FROM ${PYTHON_IMAGE}

RUN openssl version \
 && useradd --system --uid 10001 --home-dir /var/lib/camwright --create-home camwright
COPY --from=build /opt/venv /opt/venv

ENV PATH=/opt/venv/bin:$PATH \
    PYTHONUNBUFFERED=1 \
    CAMWRIGHT_HOST=0.0.0.0 \
    CAMWRIGHT_PORT=8000 \
    CAMWRIGHT_DATABASE_URL=sqlite:////var/lib/camwright/camwright.db \
    DASK_TEMPORARY_DIRECTORY=/tmp
WORKDIR /app
USER camwright
VOLUME /var/lib/camwright
EXPOSE 8000

HEALTHCHECK --interval=10s --timeout=3s --start-period=30s --retries=3 \
    CMD ["python", "-c", "import os, urllib.request as r; r.urlopen('http://127.0.0.1:' + os.environ['CAMWRIGHT_PORT'] + '/livez', timeout=2)"]

CMD ["python", "-m", "service"]
