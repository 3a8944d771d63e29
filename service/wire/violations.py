"""Violations on the wire: what a request's body, and its parameters, break."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Any

from pydantic import BaseModel, Field

from synthesis.errors.schema import Body
from synthesis.errors.violations import MAX_LISTED, describe_errors

AS_IN_JSON = re.compile(r'"(\w+)": "?([^\s,"]+?)"?(?=[.,]?(?: |$))')  # a field and its value


class Violation(BaseModel):
    """One error of the request."""

    pointer: str | None = Field(
        None, description="JSON pointer (RFC 6901) into the body as it was sent."
    )
    parameter: str | None = Field(
        None, description="Name of the query parameter, path part or header instead."
    )
    value: Any = Field(description="The value found there, shortened if it is long.")
    rule: str = Field(description="The rule that it breaks.")
    remedy: str = Field(description="What to do about it.")


def describe_parameter_errors(
    errors: Sequence[Any], query: dict[str, Any], options: Body
) -> list[dict[str, Any]]:
    """The violations of query parameters, path parts and headers.

    Args:
        query: the query as it was sent. options: what it may hold, where that is known.
    """
    described = []
    for error in errors[:MAX_LISTED]:
        name = str(error["loc"][1])  # after where it stands: query, path or header
        within = error["loc"][0] == "query" and name in query
        known = options if within else None
        own = {**error, "loc": (name,)}
        (entry, *_), _ = describe_errors([own], query if within else {name: error["input"]}, known)
        rule = entry["rule"].replace("is not a field here", "is not a parameter here")
        remedy = AS_IN_JSON.sub(r"\1=\2", entry["remedy"]).replace('"', "")
        told = {"value": entry["value"], "rule": rule, "remedy": remedy}
        described.append({"parameter": name, **told})
    return described
