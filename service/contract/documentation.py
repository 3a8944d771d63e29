"""What the OpenAPI document says beyond what FastAPI reads from the handlers."""

from __future__ import annotations

import json
from typing import Any

from fastapi import FastAPI
from fastapi.openapi.utils import get_openapi
from fastapi.routing import APIRoute
from pydantic import BaseModel

from service.contract.components import refer_to_what_repeats
from service.contract.examples import examples
from service.wire.errors import BY_STATUS, PROBLEMS
from service.wire.problem import MEDIA_TYPE, LateProblem, Problem
from synthesis.design import engine_version
from synthesis.dynamics import TrainSpec
from synthesis.linkages import LINKAGES
from synthesis.measured import MeasuredCam
from synthesis.spatial.spec import SpatialCamSpec
from synthesis.sweeps import SweepSpec

TITLE = "Camwright"
DESCRIPTION = """\
Say what the follower must do and what the cam must not exceed; Camwright picks base radius, offset
and motion law **together**, proves that every limit holds at **every** cam angle, and hands back
the profile.

1. `POST /v1/designs` with a spec: the motion program, the follower, the limits, what to make small.
   The worked examples below are a good start.
2. Read `status`, `dimensions`, `extremes` (each limit: value, where, margin) and `certificate`
   (how close to the best possible the answer is).
3. Take the points: `/v1/designs/{id}/profile.csv`, `.txt`, `.json`, `.svg`, and `/motion.*`.

A cam that exists already goes to `POST /v1/analyses`: what it does, which limits it breaks, by how
much and where, and what would mend it. Of a cam that exists as metal only, send measured points of
its profile to `POST /v1/profile-analyses`: the motion that it gives its follower.

Several cams on one shaft go to `POST /v1/cam-sets`, each with its phase: one timing diagram, and
one archive with all files, in the cams' own frames and in the shaft's.

Cams whose rollers' axes do not lie along the cam's, as those of globoidal indexers, go to
`POST /v1/spatial-cams`: their walls, pressure angle, undercut, where and at which roller.

What an elastic follower train does on a cam, speed by speed, says `POST /v1/train-responses`:
residual vibration in the dwells, contact force, the speed at which contact is lost.

Linkages have places of their own: a six-bar shaper, given or sized for a stroke and a quick-return
ratio, goes to `POST /v1/linkages/six-bar-shapers`, a palletising arm to
`POST /v1/linkages/palletising-arms`.

Many designs out of one go to `POST /v1/sweeps`: a base spec, the fields to vary, and how their
values are combined. Watch them come in, take them as a table, and see what is traded for what.

**Units** are in the field names: mm, degrees of cam angle, rpm; velocity to jerk in mm/s to mm/s³
at the given speed, or in deg/s to deg/s³ where the follower swings on an arm (`lift_deg`).
**Angles** count from the start of the program in the sense that the program runs. **A number**
fixes a dimension, `{"min", "max"}` leaves it free in between, leaving it out leaves it free. **A
law** is named, or `spline`: then it is part of the answer.

Infeasible is a result, not an error: `status` is `infeasible` and `conflict` names the limits that
cannot hold together and the least change of each that would help. Everything that does go wrong is
a problem document (RFC 9457, `application/problem+json`) that names field, value, rule and way out.

The same spec gives the same id and the same bytes; results carry a strong `ETag`.
"""
TAGS = [
    {"name": "designs", "description": "Ask for a cam; look at it, list them, forget it."},
    {"name": "analyses", "description": "What a cam does that is given in full."},
    {"name": "cam sets", "description": "Several cams on one shaft, with their phases."},
    {"name": "spatial cams", "description": "Cams for rollers whose axes lie across the cam's."},
    {"name": "follower trains", "description": "Masses, springs and dampers that a cam drives."},
    {"name": "linkages", "description": "Shapers and palletising arms."},
    {"name": "sweeps", "description": "Many designs out of one, and their trade-offs."},
    {"name": "files", "description": "Points and curves of a finished design."},
    {"name": "catalogue", "description": "What a spec may name, and what this server allows."},
    {"name": "operation", "description": "For those who run the service."},
]
# of statuses that stand for several kinds of problems
SEVERAL = {
    404: "Nothing is here",
    409: "Not as things stand now",
    422: "The request makes no sense",
    503: "Not now, try again",
}
OPENAPI_URL = "/openapi.json"
# Bodies that no handler's signature names.
UNNAMED: tuple[type[BaseModel], ...] = (
    Problem, LateProblem, MeasuredCam, SpatialCamSpec, SweepSpec, TrainSpec,
    *(each.spec for each in LINKAGES.values()),
)  # fmt: skip


def problems(*statuses: int) -> dict[int | str, dict[str, Any]]:
    """Responses that are problem documents, by reference."""
    titles = {kind.status: kind.title for kind in (*PROBLEMS.values(), *BY_STATUS.values())}
    titles |= SEVERAL
    return {
        status: {"description": f"{titles[status]}.", "content": _problem(status)}
        for status in statuses
    }


def _problem(status: int) -> dict[str, Any]:
    """The form of a problem; only what comes too late has a design in it: a large schema."""
    model = LateProblem if status == 504 else Problem
    return {MEDIA_TYPE: {"schema": {"$ref": f"#/components/schemas/{model.__name__}"}}}


def tagged(status: int = 200, **more: Any) -> dict[int | str, dict[str, Any]]:
    """A response with a strong ETag, and 304 for those who have it."""
    return {
        status: {"headers": {"ETag": _header("Strong: the same tag, the same bytes.")}, **more},
        304: {"description": "You have it already."},
    }


def in_parts(**more: Any) -> dict[int | str, dict[str, Any]]:
    """A file: tagged, and to be had in parts by those who send Range."""
    return {
        **tagged(**more),
        206: {
            "description": "With `Range: bytes=…` and, if given, the file's tag in `If-Range`: the "
            "part asked for, uncompressed.",
            "headers": {"Content-Range": _header("Which bytes of how many.")},
            **({"content": more["content"]} if "content" in more else {}),
        },
        **problems(416),
    }


def _header(description: str) -> dict[str, Any]:
    return {"description": description, "schema": {"type": "string"}}


UNDER_WAY_HEADERS = {
    "Location": _header("Where to ask again."),
    "Retry-After": _header("Seconds until then."),
}


def spec_body(part: str = "", schema: str = "DesignSpec") -> dict[str, Any]:
    """A spec as request body, with the worked examples of a part of the service."""
    content = {
        "schema": {"$ref": f"#/components/schemas/{schema}"},
        "examples": examples(part),
    }
    return {"requestBody": {"required": True, "content": {"application/json": content}}}


def client_name(route: APIRoute) -> str:
    """The handler's own name: what a generated client's method is called."""
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
        _without_default_errors(document)
        _without_default_objects(document)
        document["components"]["schemas"] = dict(sorted(schemas.items()))
        refer_to_what_repeats(document)
        app.openapi_schema = document
    return app.openapi_schema


def _without_default_objects(document: dict[str, Any]) -> None:
    """A default that is an object is said in words: generators of clients drop its schema."""
    for schema in document["components"]["schemas"].values():
        for field in schema.get("properties", {}).values():
            if isinstance(field.get("default"), dict):
                default = json.dumps(field.pop("default"))
                said = field.get("description", "")
                field["description"] = f"{said} Left out, it is `{default}`.".strip()


def _without_default_errors(document: dict[str, Any]) -> None:
    """FastAPI adds its own form of 422 to what has parameters; ours is a problem document."""
    for unused in ("HTTPValidationError", "ValidationError"):
        document["components"]["schemas"].pop(unused, None)
    for methods in document["paths"].values():
        for operation in methods.values():
            added = operation["responses"].get("422", {}).get("content", {})
            if "application/json" in added:
                del operation["responses"]["422"]
