"""create_app: routes, error table, documentation and what surrounds every request."""

from __future__ import annotations

from collections.abc import AsyncIterator, Callable
from contextlib import AbstractAsyncContextManager, asynccontextmanager
from functools import partial
from typing import Any

from fastapi import FastAPI
from starlette.middleware.cors import CORSMiddleware
from starlette_compress import CompressMiddleware

from service import pages
from service.contract.documentation import OPENAPI_URL, TITLE, client_name, describe
from service.resources.jobs import Jobs
from service.resources.resource import LINKAGE_RESOURCES, RESOURCES
from service.routes import (
    analyses,
    analysis_pictures,
    cam_sets,
    catalogue,
    confirmation,
    designs,
    files,
    linkages,
    operation,
    profile_analyses,
    spatial_cams,
    spatial_files,
    sweep_items,
    sweeps,
    train_responses,
)
from service.settings import Settings
from service.state import State
from service.storage.store import Store
from service.sweeps.sweeps import Sweeps
from service.wire import problem
from service.wire.body_limit import BodyLimit
from service.wire.etag import TagEncodings
from service.wire.metrics import Metrics
from service.wire.observe import Observe
from service.wire.ranges import Ranges
from service.workers.engine import Engine, running_engine

EngineOf = Callable[[Settings], AbstractAsyncContextManager[Engine]]
ROUTES = (
    designs, confirmation, files, cam_sets, spatial_cams, spatial_files, sweeps, sweep_items,
    analyses, analysis_pictures, profile_analyses, linkages, train_responses,
    catalogue, operation,
)  # fmt: skip
EXPOSED = (
    "Accept-Ranges", "Content-Location", "Content-Range", "ETag", "Location", "Retry-After",
    "X-Request-ID",
)  # fmt: skip


def create_app(settings: Settings, engine_of: EngineOf = running_engine) -> FastAPI:
    """The service; ``engine_of`` makes the engine that it runs its designs on."""
    metrics = Metrics()

    @asynccontextmanager
    async def lifespan(app: FastAPI) -> AsyncIterator[None]:
        store = Store(settings)
        async with engine_of(settings) as engine:
            many = Sweeps(engine, store, settings)
            work_on = partial(Jobs, engine=engine, store=store, metrics=metrics, settings=settings)
            kinds = [work_on(each) for each in RESOURCES]
            linkages = {name: work_on(each) for name, each in LINKAGE_RESOURCES.items()}
            app.state.parts = State(settings, metrics, engine, store, many, linkages, *kinds)
            under_way: list[Jobs | Sweeps] = [many, *kinds, *linkages.values()]
            for work in under_way:
                await work.resume()
            yield
            engine.closing = True
            for work in under_way:
                await work.close()
        store.dispose()

    app = FastAPI(
        title=TITLE,
        lifespan=lifespan,
        openapi_url=OPENAPI_URL,
        docs_url=None,
        redoc_url=None,
        swagger_ui_oauth2_redirect_url=None,
        generate_unique_id_function=client_name,
        redirect_slashes=False,
    )
    for routes in ROUTES:
        app.include_router(routes.router)
    pages.install(app)
    problem.install(app)
    _surround(app, settings, metrics)
    _document(app)
    return app


def _surround(app: FastAPI, settings: Settings, metrics: Metrics) -> None:
    """From the inside out."""
    app.add_middleware(BodyLimit, max_bytes=settings.max_body_bytes)
    app.add_middleware(CompressMiddleware, minimum_size=1000)
    app.add_middleware(TagEncodings)
    app.add_middleware(Ranges)
    if settings.cors_origins:
        app.add_middleware(
            CORSMiddleware,
            allow_origins=settings.cors_origins,
            allow_methods=["GET", "POST", "DELETE"],
            allow_headers=["*"],
            expose_headers=EXPOSED,
        )
    app.add_middleware(Observe, metrics=metrics)


def _document(app: FastAPI) -> None:
    def openapi() -> dict[str, Any]:
        return describe(app)

    app.openapi = openapi  # type: ignore[method-assign]
