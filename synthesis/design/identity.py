"""Which engine made an answer, and the id that a question has on it."""

from __future__ import annotations

import hashlib
from functools import cache
from importlib.metadata import version

from pydantic import BaseModel

ENGINE_NUMBER = 46
"""The engine's number: part of every id, and so of everything that is stored under one.

Raise it by 1 whenever an answer may change: its numbers, its fields, what it says, the bytes of its
files, whose ETags hold the number. Answers stored under an earlier one are then computed anew. A
test compares the numbers of some answers with those kept for this number; it knows no files.
"""


@cache
def engine_version() -> str:
    """Version of the installed distribution."""
    return version("camwright")


def question_id(spec: BaseModel, *kind: str) -> str:
    """The id of a question of a kind: a hash of its spec and the engine's number, 32 hex digits."""
    return identity(*kind, spec.model_dump_json())


def identity(*parts: str) -> str:
    """Hash of texts and the engine's number."""
    lines = "\n".join((str(ENGINE_NUMBER), *parts))
    return hashlib.sha256(lines.encode()).hexdigest()[:32]


def design_id(spec: BaseModel) -> str:
    """The id of the design that answers a ``DesignSpec``."""
    return question_id(spec)
