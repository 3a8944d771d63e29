"""Texts and schemas of the OpenAPI document beyond what FastAPI reads from the handlers."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from fastapi import FastAPI
from fastapi.openapi.utils import get_openapi
from pydantic import BaseModel
from pydantic.json_schema import models_json_schema

from service.contract.examples import VARIANTS, examples
from service.contract.sharing import share
from service.wire.errors import ProblemType
from service.wire.problem import MEDIA_TYPE, LateProblem, Problem
from synthesis.design.identity import engine_version
from synthesis.machines.dynamics import TrainSpec
from synthesis.machines.linkages import LINKAGES
from synthesis.machines.spatial.spec import SpatialCamSpec
from synthesis.studies.measured import MeasuredCam
from synthesis.studies.sweeps import SweepSpec

Json = dict[str, Any]
TITLE = "Camwright"
DESCRIPTION = Path(__file__).with_name("description.md").read_text(encoding="utf-8")
TAGS = {
    "designs": "Synthesise a cam; get, list and delete designs.",
    "analyses": "Analyses of given and of measured cams.",
    "cam sets": "Several cams on one shaft, with their phases.",
    "spatial cams": "Cams with rollers whose axes are not parallel to the cam's.",
    "follower trains": "Response of masses, springs and dampers that a cam drives.",
    "linkages": "Shapers and palletising arms.",
    "sweeps": "Many designs from one base spec, and their trade-offs.",
    "files": "Points, curves, pictures and solids of a finished design.",
    "catalogue": "What a spec can contain, and the limits of this server.",
    "operation": "For those who run the service.",
}
# Statuses of several types of problems.
SEVERAL = {
    404: "Not found",
    409: "Unfinished, no cam, or deleted meanwhile",
    422: "The request is invalid",
    429: "Busy, or a quota used up",
    500: "Internal error",
    503: "Temporarily unavailable: try again",
}
# What any request may be answered with: by the connection, the guard before all routes, the store.
# The document's description says what they mean.
ANY_REQUEST = (400, 401, 408, 421, 429, 431, 500, 503)
OPENAPI_URL = "/openapi.json"
REFERENCE = "#/components/schemas/"
# Models that no handler's signature names.
UNNAMED: tuple[type[BaseModel], ...] = (
    Problem, LateProblem, MeasuredCam, SpatialCamSpec, SweepSpec, TrainSpec,
    *(each.spec for each in LINKAGES.values()),
)  # fmt: skip


def problems(*statuses: int, late: bool = True) -> dict[int | str, Json]:
    """Every problem that an operation may answer with, as its ``default`` response.

    Args:
        statuses: those beside ``ANY_REQUEST``.
        late: whether 504 brings the best design by then along, and so stands by itself.
    """
    titles = {kind.status: kind.title for kind in ProblemType} | SEVERAL
    alone = {504} & set(statuses) if late else set()
    own = sorted({*statuses} - alone)
    lines = "".join(f"* {status}: {titles[status]}.\n" for status in own)
    lines += f"* {', '.join(map(str, ANY_REQUEST))}: as of any request."
    responses: dict[int | str, Json] = {"default": _problem(Problem, lines)}
    return responses | {each: _problem(LateProblem, f"{titles[each]}.") for each in alone}


def _problem(model: type[BaseModel], description: str) -> Json:
    schema = {"$ref": f"{REFERENCE}{model.__name__}"}
    return {"description": description, "content": {MEDIA_TYPE: {"schema": schema}}}


def etag_response(**more: Any) -> dict[int | str, Json]:
    """A response with a strong ETag, and 304 for those who have it."""
    return {
        200: {"headers": {"ETag": _header("Strong: the same tag, the same bytes.")}, **more},
        304: {"description": "The caller has it already."},
    }


def file_response(content: Json, may_lack: bool = True) -> dict[int | str, Json]:
    """A file with a tag, of which parts can be requested by Range, and what may go wrong.

    What HTTP makes of tags and ranges, 304 and 206, is told once, by the headers of all files.

    Args:
        may_lack: whether it takes an optional part.
    """
    headers = {"ETag": FILE_TAG, "Accept-Ranges": FILE_PARTS}
    return {
        200: {"description": "The file.", "headers": headers, "content": content},
        **problems(404, 409, 416, 422, 504, *((501,) if may_lack else ()), late=False),
    }


def _header(description: str) -> Json:
    return {"description": description, "schema": {"type": "string"}}


KEY_SCHEME = {"type": "http", "scheme": "bearer"}
FILE_TAG = _header(
    "Strong: the same tag, the same bytes. Sent back in `If-None-Match`, the answer is 304 without "
    "a body while that is so."
)
FILE_PARTS = _header(
    "`bytes`: asked with `Range: bytes=…` and, if given, the file's tag in `If-Range`, the answer "
    "is 206 with the requested part, uncompressed; its `Content-Range` has range and total size."
)
UNDER_WAY_HEADERS = {
    "Location": _header("Address to ask again."),
    "Retry-After": _header("Seconds until then."),
}


def spec_body(part: str = "", schema: str = "DesignSpec") -> Json:
    """A spec as request body, with the worked examples of a folder but for variants of others."""
    shown = {name: each for name, each in examples(part).items() if name not in VARIANTS}
    content = {"schema": {"$ref": f"{REFERENCE}{schema}"}, "examples": shown}
    return {"requestBody": {"required": True, "content": {"application/json": content}}}


def describe(app: FastAPI) -> Json:
    """The OpenAPI document, made once."""
    if app.openapi_schema is None:
        document = get_openapi(
            title=TITLE,
            version=engine_version(),
            summary="Certified cam synthesis over HTTP",
            description=DESCRIPTION,
            routes=app.routes,
            tags=[{"name": name, "description": text} for name, text in TAGS.items()],
            contact={"name": "Camwright founders"},
            license_info={"name": "MIT", "identifier": "MIT"},
            servers=[{"url": "/", "description": "The service that this document comes from."}],
            separate_input_output_schemas=False,
        )
        _, unnamed = models_json_schema(
            [(model, "validation") for model in UNNAMED], ref_template=f"{REFERENCE}{{model}}"
        )
        own = {model.__name__: unnamed["$defs"][model.__name__] for model in UNNAMED}
        schemas = {**unnamed["$defs"], **document["components"]["schemas"], **own}
        document["components"]["schemas"] = schemas
        document["components"]["securitySchemes"] = {"key": KEY_SCHEME}
        document["security"] = [{}, {"key": []}]  # where the service listens on the loopback: none
        _tidy(document)
        share(document)
        app.openapi_schema = document
    return app.openapi_schema


def _tidy(document: Json) -> None:
    """Remove what FastAPI adds and the service does not do."""
    schemas = document["components"]["schemas"]
    operations = [each for methods in document["paths"].values() for each in methods.values()]
    for responses in (operation["responses"] for operation in operations):
        for response in responses.values():
            for content in response.get("content", {}).values():
                if content.pop("itemSchema", None):  # a word of OpenAPI 3.2: text in 3.1
                    content["schema"] = {"type": "string"}
            if response["description"] == "Successful Response":
                response["description"] = "The answer." if "content" in response else "Done."
    for schema in schemas.values():
        if "description" in schema:  # a docstring; its "Note:" is for readers of the code
            schema["description"] = schema["description"].partition("\n\nNote:\n")[0]
        for field in schema.get("properties", {}).values():
            # Defaults that are objects become text: client generators drop their fields' schemas.
            if isinstance(field.get("default"), dict):
                said = f" Default: `{json.dumps(field.pop('default'))}`."
                field["description"] = (field.get("description", "") + said).strip()
