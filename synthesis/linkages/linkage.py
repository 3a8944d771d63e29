"""What the service and the command line need to know of a kind of linkage."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from pydantic import BaseModel


@dataclass(frozen=True)
class Linkage:
    """A kind of linkage.

    Attributes:
        name: plural, as in ``/v1/linkages/{name}``. noun: of one, for people.
        title: what is asked, and purpose: what the answer holds.
        spec, found: question and answer. work: spec and deadline [s, monotonic] to the answer.
        told: what lists show of an answer, by names with units.
    """

    name: str
    noun: str
    title: str
    purpose: str
    spec: type[BaseModel]
    found: type[BaseModel]
    work: Callable[[Any, float | None], Any]
    told: Callable[[Any], dict[str, float]]
