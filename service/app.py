"""The application: routes, problem documents, OpenAPI document, middleware."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Callable
from contextlib import AbstractAsyncContextManager, asynccontextmanager
from functools import partial
from operator import attrgetter

from fastapi import FastAPI
from starlette.middleware.cors import CORSMiddleware
from starlette.middleware.gzip import GZipMiddleware

from service import pages
from service.contract.documentation import TITLE, describe, problems
from service.resources.jobs import Jobs, Questions, questions
from service.resources.quotas import UsedQuotas
from service.resources.records import PROOFS, RESOURCES
from service.routes import catalogue, designs, operation, proofs, resource_routes, sweeps
from service.settings import Settings
from service.state import State
from service.storage.keys import ApiKeys
from service.storage.store import Store
from service.storage.tables import LOCAL
from service.sweeps.sweeps import Sweeps
from service.wire import problem
from service.wire.access import Caller, Guard
from service.wire.conditional import Heads, Ranges, TagEncodings
from service.wire.errors import ProblemType
from service.wire.fair_queue import TakeTurns
from service.wire.observe import Metrics, Observe
from service.wire.places import Places
from service.wire.tracing import telemetry
from service.wire.validation import prepare
from service.workers.engine import Engine, running_engine
from service.workers.side_processes import readers_of, writers_of

EngineOf = Callable[[Settings, Metrics], AbstractAsyncContextManager[Engine]]
ROUTES = (designs, sweeps, proofs, catalogue, operation)
GZIP_LEVEL = 4  # of 9: a third of the time of the highest for a twentieth more bytes
EXPOSED = (
    "Accept-Ranges", "Content-Location", "Content-Range", "ETag", "Location", "RateLimit",
    "RateLimit-Policy", "Retry-After", "X-Request-ID",
)  # fmt: skip


def create_app(
    settings: Settings, engine_of: EngineOf = running_engine, *, keys_needed: bool = False
) -> FastAPI:
    """The application.

    Args:
        engine_of: makes the engine that runs its tasks. keys_needed: whether those without a key
            are refused; else all they ask belongs to one local owner.
    """
    metrics = Metrics()

    @asynccontextmanager
    async def lifespan(app: FastAPI) -> AsyncIterator[None]:
        store = Store(settings, metrics)
        async with engine_of(settings, metrics) as engine:
            all_sweeps = Sweeps(engine, store, settings)
            jobs: dict[str, Jobs] = {}
            accepted = questions(store, settings, jobs)
            for path, resource in {**RESOURCES, PROOFS.path: PROOFS}.items():
                jobs[path] = Jobs(resource, engine, store, metrics, settings, accepted)
            helpers = readers_of(settings), writers_of(settings)
            most, each = settings.max_streams, settings.max_streams_per_client
            streams = Places("streams of events", ProblemType.BUSY, most, each)
            app.state.parts = State(
                settings, metrics, engine, store, all_sweeps, *helpers, streams, jobs,
                ApiKeys(store, settings), UsedQuotas(store),
            )  # fmt: skip
            for work in (all_sweeps, accepted):
                await work.resume()
            # In a thread, for it takes a second; until then the first wrong bodies take longer.
            models = [resource.spec for resource in RESOURCES.values()]
            app.state.preparing = asyncio.create_task(asyncio.to_thread(prepare, models))
            yield
            await app.state.preparing
            engine.closing = True
            working: list[Sweeps | Questions | Jobs] = [all_sweeps, accepted, *jobs.values()]
            for doing in working:
                await doing.close()
            for one in helpers:
                one.close()
        store.dispose()

    app = FastAPI(
        title=TITLE,
        lifespan=lifespan,
        openapi_url=None,  # as a page, with a tag
        docs_url=None,
        redoc_url=None,
        swagger_ui_oauth2_redirect_url=None,
        generate_unique_id_function=attrgetter("name"),  # the method of generated clients
        redirect_slashes=False,
        telemetry=telemetry(),
        responses=problems(),  # of every route that names no others
    )
    for resource in RESOURCES.values():
        app.include_router(resource_routes.router_of(resource))
    for routes in ROUTES:
        app.include_router(routes.router)
    pages.install(app)
    problem.install(app)
    # Middleware, from the innermost to the outermost.
    app.add_middleware(Heads)
    app.add_middleware(GZipMiddleware, minimum_size=1000, compresslevel=GZIP_LEVEL)
    app.add_middleware(TagEncodings)
    app.add_middleware(Ranges)
    app.add_middleware(
        Guard,
        hosts=settings.hosts,
        caller_of=lambda key: app.state.parts.keys.caller(key),
        without_key=None if keys_needed else Caller(LOCAL, operator=True),
    )
    if settings.cors_origins:
        app.add_middleware(
            CORSMiddleware,
            allow_origins=settings.cors_origins,
            allow_methods=["GET", "POST", "DELETE"],
            allow_headers=["*"],
            expose_headers=EXPOSED,
        )
    app.add_middleware(TakeTurns)
    app.add_middleware(Observe, metrics=metrics)
    app.openapi = partial(describe, app)  # type: ignore[method-assign]
    return app
