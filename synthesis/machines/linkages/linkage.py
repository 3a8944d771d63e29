"""Linkage: what the service and the command line ask of every kind of linkage."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from pydantic import BaseModel


@dataclass(frozen=True)
class Linkage:
    """A kind of linkage.

    Attributes:
        name: plural, as in ``/v1/linkages/{name}``. noun: singular, for people.
        title: what can be asked. purpose: what the answer holds.
        spec, answer: request and response bodies.
        solve: from a spec and a deadline [s, monotonic] to the answer.
        summary: numbers of an answer that lists show, by names with units.
    """

    name: str
    noun: str
    title: str
    purpose: str
    spec: type[BaseModel]
    answer: type[BaseModel]
    solve: Callable[[Any, float | None], Any]
    summary: Callable[[Any], dict[str, float]]
