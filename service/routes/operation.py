"""/livez, /readyz, /metrics, /v1/version, /problems/{slug}: for those who run the service."""

from __future__ import annotations

import platform
from typing import Literal

from fastapi import APIRouter, Response
from pydantic import BaseModel, Field
from sqlalchemy.exc import SQLAlchemyError
from starlette.exceptions import HTTPException

from service.contract.documentation import problems
from service.resources.records import DESIGNS
from service.state import Parts
from service.wire.errors import ProblemType
from synthesis.design.identity import ENGINE_NUMBER, engine_version

router = APIRouter(tags=["operation"])


class Alive(BaseModel):
    """The process answers."""

    status: Literal["alive"] = Field("alive", description="Always this.")


class Ready(BaseModel):
    """Whether designs can be worked on now."""

    ready: bool = Field(description="Store and at least one worker answer.")
    store: bool = Field(description="The database answers.")
    workers: int = Field(description="Workers that can be reached.")


class Version(BaseModel):
    """What is running."""

    name: Literal["camwright"] = Field("camwright", description="Always this.")
    version: str = Field(description="Version of Camwright.")
    engine: int = Field(
        description="Number of the engine, part of every id: it rises whenever answers may "
        "change, and answers stored under an earlier one are computed anew."
    )
    python: str = Field(description="Version of Python under it.")


class ProblemKind(BaseModel):
    """A kind of problem."""

    type: str = Field(description="As in problem documents.")
    title: str = Field(description="As in problem documents.")
    status: int = Field(description="HTTP status.")
    meaning: str = Field(description="When it occurs.")


@router.get("/livez", summary="Is the process alive?")
async def get_livez() -> Alive:
    """Answers as long as the process does."""
    return Alive()


@router.get(
    "/readyz",
    responses={503: {"model": Ready, "description": "Not now."}},
    summary="Can it take designs?",
)
async def get_readyz(parts: Parts, response: Response) -> Ready:
    """200 when the store answers and a worker can be reached, otherwise 503."""
    store = await parts.store.works()
    workers = await parts.engine.workers()
    ready = store and workers > 0
    response.status_code = 200 if ready else 503
    return Ready(ready=ready, store=store, workers=workers)


@router.get(
    "/metrics",
    response_class=Response,
    responses={200: {"content": {"text/plain": {"schema": {"type": "string"}}}}, **problems(403)},
    summary="For Prometheus",
)
async def get_metrics(parts: Parts) -> Response:
    """Requests by route, solve times, designs by status, the queue."""
    queue, sweeps = parts.engine.queue, len(parts.sweeps.work.runners)
    try:
        counts = await parts.jobs[DESIGNS.path].answers.counts()
    except SQLAlchemyError:
        counts = None
    workers = await parts.engine.workers()
    page = parts.metrics.page(counts, queue.waiting, queue.running, sweeps, workers)
    return Response(page, media_type="text/plain; version=0.0.4")


@router.get("/v1/version", summary="What is running")
async def get_version() -> Version:
    """The version that answers."""
    return Version(version=engine_version(), engine=ENGINE_NUMBER, python=platform.python_version())


@router.get("/problems/{slug}", responses=problems(404), summary="What a kind of problem means")
async def get_problem_kind(slug: str) -> ProblemKind:
    """Where `type` of a problem document leads."""
    for kind in ProblemType:
        if kind.slug == slug:
            return ProblemKind(
                type=f"/problems/{slug}", title=kind.title, status=kind.status, meaning=kind.meaning
            )
    raise HTTPException(404)
