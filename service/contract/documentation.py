"""Texts and schemas of the OpenAPI document beyond what FastAPI reads from the handlers."""

from __future__ import annotations

import json
from typing import Any

from fastapi import FastAPI
from fastapi.openapi.utils import get_openapi
from fastapi.routing import APIRoute
from pydantic import BaseModel

from service.contract.components import share_components
from service.contract.examples import examples
from service.wire.errors import ProblemType
from service.wire.problem import MEDIA_TYPE, LateProblem, Problem
from synthesis.design.identity import engine_version
from synthesis.machines.dynamics import TrainSpec
from synthesis.machines.linkages import LINKAGES
from synthesis.machines.spatial.spec import SpatialCamSpec
from synthesis.studies.measured import MeasuredCam
from synthesis.studies.sweeps import SweepSpec

TITLE = "Camwright"
DESCRIPTION = """\
Specify the motion of the follower and the limits of the cam; Camwright chooses base radius, offset
and motion law **together**, proves that every limit holds at **every** cam angle, and returns the
profile.

1. `POST /v1/designs` with a spec: the motion program, the follower, the limits, the objective.
   The worked examples below are a good start.
2. Read `status`, `dimensions`, `extremes` (each limit: value, where, margin) and `certificate`
   (how close the answer is to the optimum).
3. Get the points: `/v1/designs/{id}/profile.csv`, `.txt`, `.json`, `.svg`, and `/motion.*`.

`POST /v1/analyses` analyses a given cam: its extremes, which limits it breaks, by how much and
where, and which changes would help. `POST /v1/profile-analyses` takes measured points of a real
cam's profile and returns the motion of its follower.

`POST /v1/cam-sets` designs several cams on one shaft, each with its phase: one timing diagram, and
one archive with all files, in the cams' own frames and in the shaft's.

`POST /v1/spatial-cams` designs cams whose rollers' axes are not parallel to the cam's, such as
globoidal indexers: walls, pressure angle, undercut, with place and roller.

`POST /v1/train-responses` computes the response of an elastic follower train to a cam, speed by
speed: residual vibration in the dwells, contact force, the speed at which contact is lost.

`POST /v1/linkages/six-bar-shapers` analyses a six-bar shaper, or sizes one for a stroke and a
quick-return ratio; `POST /v1/linkages/palletising-arms` analyses a palletising arm.

`POST /v1/sweeps` computes many designs: a base spec, the fields to vary, and how their values are
combined. Follow its events, get the items as a table, and the Pareto front of any quantities.

**Units** are in the field names: mm, degrees of cam angle, rpm; velocity to jerk in mm/s to mm/s³
at the given speed, or in deg/s to deg/s³ where the follower swings on an arm (`lift_deg`).
**Angles** count from the start of the program in the sense that the program runs. **A number**
fixes a dimension, `{"min", "max"}` leaves it free in between, leaving it out leaves it free. **A
law** is named, or `spline`: then it is part of the answer.

Infeasible is a result, not an error: `status` is `infeasible` and `conflict` names the limits that
cannot hold together and the least change of each that would help. Every error is a problem document
(RFC 9457, `application/problem+json`) that names field, value, rule and what to do.

The same spec gives the same id and the same bytes; results carry a strong `ETag`.
"""
TAGS = [
    {"name": "designs", "description": "Synthesise a cam; get, list and delete designs."},
    {"name": "analyses", "description": "Analyses of given and of measured cams."},
    {"name": "cam sets", "description": "Several cams on one shaft, with their phases."},
    {
        "name": "spatial cams",
        "description": "Cams with rollers whose axes are not parallel to the cam's.",
    },
    {
        "name": "follower trains",
        "description": "Response of masses, springs and dampers that a cam drives.",
    },
    {"name": "linkages", "description": "Shapers and palletising arms."},
    {"name": "sweeps", "description": "Many designs from one base spec, and their trade-offs."},
    {"name": "files", "description": "Points, curves, pictures and solids of a finished design."},
    {"name": "catalogue", "description": "What a spec can contain, and the limits of this server."},
    {"name": "operation", "description": "For those who run the service."},
]
# Statuses of several types of problems.
SEVERAL = {
    404: "Not found",
    409: "Conflict with the current state",
    422: "The request is invalid",
    500: "Internal error",
    503: "Temporarily unavailable: try again",
}
OPENAPI_URL = "/openapi.json"
# Models that no handler's signature names.
UNNAMED: tuple[type[BaseModel], ...] = (
    Problem, LateProblem, MeasuredCam, SpatialCamSpec, SweepSpec, TrainSpec,
    *(each.spec for each in LINKAGES.values()),
)  # fmt: skip


def problems(*statuses: int) -> dict[int | str, dict[str, Any]]:
    """Responses that are problem documents, by reference."""
    titles = {kind.status: kind.title for kind in ProblemType} | SEVERAL
    return {
        status: {"description": f"{titles[status]}.", "content": _problem(status)}
        for status in statuses
    }


def _problem(status: int) -> dict[str, Any]:
    """The schema of a problem; only that of 504 contains a design, which is large."""
    model = LateProblem if status == 504 else Problem
    return {MEDIA_TYPE: {"schema": {"$ref": f"#/components/schemas/{model.__name__}"}}}


def tagged(status: int = 200, **more: Any) -> dict[int | str, dict[str, Any]]:
    """A response with a strong ETag, and 304 for those who have it."""
    return {
        status: {"headers": {"ETag": _header("Strong: the same tag, the same bytes.")}, **more},
        304: {"description": "The caller has it already."},
    }


def in_parts(**more: Any) -> dict[int | str, dict[str, Any]]:
    """A file with a tag, of which parts can be requested by Range."""
    return {
        **tagged(**more),
        206: {
            "description": "With `Range: bytes=…` and, if given, the file's tag in `If-Range`: the "
            "requested part, uncompressed.",
            "headers": {"Content-Range": _header("The range and the total size.")},
            **({"content": more["content"]} if "content" in more else {}),
        },
        **problems(416),
    }


def _header(description: str) -> dict[str, Any]:
    return {"description": description, "schema": {"type": "string"}}


UNDER_WAY_HEADERS = {
    "Location": _header("Address to ask again."),
    "Retry-After": _header("Seconds until then."),
}


def spec_body(part: str = "", schema: str = "DesignSpec") -> dict[str, Any]:
    """A spec as request body, with the worked examples of a folder."""
    content = {
        "schema": {"$ref": f"#/components/schemas/{schema}"},
        "examples": examples(part),
    }
    return {"requestBody": {"required": True, "content": {"application/json": content}}}


def client_name(route: APIRoute) -> str:
    """The operation id: the name of the method of generated clients."""
    return route.name


def describe(app: FastAPI) -> dict[str, Any]:
    """The OpenAPI document, made once."""
    if app.openapi_schema is None:
        document = get_openapi(
            title=TITLE,
            version=engine_version(),
            summary="Certified cam synthesis over HTTP",
            description=DESCRIPTION,
            routes=app.routes,
            tags=TAGS,
            license_info={"name": "MIT", "identifier": "MIT"},
            separate_input_output_schemas=False,
        )
        schemas = document["components"]["schemas"]
        reference = "#/components/schemas/{model}"
        for model in UNNAMED:
            own = model.model_json_schema(ref_template=reference)
            for name, schema in own.pop("$defs").items():
                schemas.setdefault(name, schema)
            schemas[model.__name__] = own
        _remove_default_errors(document)
        _describe_default_objects(document)
        document["components"]["schemas"] = dict(sorted(schemas.items()))
        share_components(document)
        app.openapi_schema = document
    return app.openapi_schema


def _describe_default_objects(document: dict[str, Any]) -> None:
    """Move defaults that are objects into descriptions: client generators drop their schemas."""
    for schema in document["components"]["schemas"].values():
        for field in schema.get("properties", {}).values():
            if isinstance(field.get("default"), dict):
                default = json.dumps(field.pop("default"))
                text = field.get("description", "")
                field["description"] = f"{text} Default: `{default}`.".strip()


def _remove_default_errors(document: dict[str, Any]) -> None:
    """Remove FastAPI's own form of 422: the service answers with problem documents."""
    for unused in ("HTTPValidationError", "ValidationError"):
        document["components"]["schemas"].pop(unused, None)
    for methods in document["paths"].values():
        for operation in methods.values():
            added = operation["responses"].get("422", {}).get("content", {})
            if "application/json" in added:
                del operation["responses"]["422"]
