"""Texts and schemas of the OpenAPI document beyond what FastAPI reads from the handlers."""

from __future__ import annotations

import json
from collections import Counter
from pathlib import Path
from typing import Any

from fastapi import FastAPI
from fastapi.openapi.utils import get_openapi
from pydantic import BaseModel
from pydantic.json_schema import models_json_schema

from service.contract.examples import examples
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
    409: "Conflict with the current state",
    422: "The request is invalid",
    500: "Internal error",
    503: "Temporarily unavailable: try again",
}
OPENAPI_URL = "/openapi.json"
REFERENCE = "#/components/schemas/"
# Models that no handler's signature names.
UNNAMED: tuple[type[BaseModel], ...] = (
    Problem, LateProblem, MeasuredCam, SpatialCamSpec, SweepSpec, TrainSpec,
    *(each.spec for each in LINKAGES.values()),
)  # fmt: skip


def problems(*statuses: int) -> dict[int | str, Json]:
    """Responses that are problem documents, by reference."""
    titles = {kind.status: kind.title for kind in ProblemType} | SEVERAL
    responses: dict[int | str, Json] = {}
    for status in statuses:
        model = LateProblem if status == 504 else Problem  # only 504 has a design, which is large
        schema = {"$ref": f"{REFERENCE}{model.__name__}"}
        content = {MEDIA_TYPE: {"schema": schema}}
        responses[status] = {"description": f"{titles[status]}.", "content": content}
    return responses


def etag_response(status: int = 200, **more: Any) -> dict[int | str, Json]:
    """A response with a strong ETag, and 304 for those who have it."""
    return {
        status: {"headers": {"ETag": _header("Strong: the same tag, the same bytes.")}, **more},
        304: {"description": "The caller has it already."},
    }


def file_response(**more: Any) -> dict[int | str, Json]:
    """A file with a tag, of which parts can be requested by Range."""
    return {
        **etag_response(**more),
        206: {
            "description": "With `Range: bytes=…` and, if given, the file's tag in `If-Range`: the "
            "requested part, uncompressed.",
            "headers": {"Content-Range": _header("The range and the total size.")},
            **({"content": more["content"]} if "content" in more else {}),
        },
        **problems(416),
    }


def _header(description: str) -> Json:
    return {"description": description, "schema": {"type": "string"}}


UNDER_WAY_HEADERS = {
    "Location": _header("Address to ask again."),
    "Retry-After": _header("Seconds until then."),
}


def spec_body(part: str = "", schema: str = "DesignSpec") -> Json:
    """A spec as request body, with the worked examples of a folder."""
    content = {"schema": {"$ref": f"{REFERENCE}{schema}"}, "examples": examples(part)}
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
            license_info={"name": "MIT", "identifier": "MIT"},
            separate_input_output_schemas=False,
        )
        _, unnamed = models_json_schema(
            [(model, "validation") for model in UNNAMED], ref_template=f"{REFERENCE}{{model}}"
        )
        own = {model.__name__: unnamed["$defs"][model.__name__] for model in UNNAMED}
        schemas = {**unnamed["$defs"], **document["components"]["schemas"], **own}
        document["components"]["schemas"] = dict(sorted(schemas.items()))
        _tidy(document)
        app.openapi_schema = document
    return app.openapi_schema


def _tidy(document: Json) -> None:
    """Remove what FastAPI adds, and share what several operations have in common."""
    components = document["components"]
    operations = [each for methods in document["paths"].values() for each in methods.values()]
    lists = [operation.get("parameters", []) for operation in operations]
    answers = [operation["responses"] for operation in operations]
    # FastAPI's own form of 422: the service answers with problem documents.
    for unused in ("HTTPValidationError", "ValidationError"):
        components["schemas"].pop(unused, None)
    for responses in answers:
        if "application/json" in responses.get("422", {}).get("content", {}):
            del responses["422"]
    fields = [
        (name, field)
        for schema in components["schemas"].values()
        for name, field in schema.get("properties", {}).items()
    ]
    for _, field in fields:
        # Defaults that are objects become text: client generators drop the schemas of their fields.
        if isinstance(field.get("default"), dict):
            default = json.dumps(field.pop("default"))
            field["description"] = f"{field.get('description', '')} Default: `{default}`.".strip()
    parameters = [(each["name"], each["schema"]) for one in lists for each in one]
    for name, field in [*fields, *parameters]:
        if field.get("title") == name.replace("_", " ").title():  # it only repeats the name
            del field["title"]
    places = [(each, at, each[at]["name"]) for each in lists for at in range(len(each))]
    components["parameters"] = _share(places, "parameters")
    # Responses of status 200 stay with their operation, for readers.
    named = [
        (each, status, f"{'Problem' if status >= '400' else 'Answer'}{status}")
        for each in answers
        for status in each
        if status != "200"
    ]
    components["responses"] = _share(named, "responses")


def _share(places: list[tuple[Any, Any, str]], kind: str) -> Json:
    """What occurs at several places, by name; the places become references to it.

    Args:
        places: container, key and name of each; different ones of a name are numbered.
        kind: the section of the components.
    """
    texts = [json.dumps((name, holder[key]), sort_keys=True) for holder, key, name in places]
    often, names, parts = Counter(texts), dict[str, str](), Json()
    for (holder, key, name), text in zip(places, texts, strict=True):
        if often[text] == 1:
            continue
        if text not in names:
            same = sum(each.partition("_no_")[0] == name for each in parts)
            names[text] = f"{name}_no_{same + 1}" if same else name
            parts[names[text]] = holder[key]
        holder[key] = {"$ref": f"#/components/{kind}/{names[text]}"}
    return parts
