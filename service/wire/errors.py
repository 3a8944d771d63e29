"""The types of problems, and the errors of the service, each with its type."""

from __future__ import annotations

import sqlite3
from dataclasses import dataclass
from enum import Enum
from typing import Any

from sqlalchemy.exc import SQLAlchemyError

from synthesis.errors import ExtraMissing, InputError, SolverFailed, TimeBudgetExceeded


class ProblemType(Enum):
    """A type of problem: its HTTP status, its title, and when it occurs if the title is too short.

    The name is the slug under /problems/.
    """

    NOT_HTTP = 400, "The request is not HTTP/1.1", "It cannot be parsed, or comes with too many."
    NOT_JSON = 400, "The body is not JSON"
    KEY_NEEDED = 401, "A key is needed", "None was sent, or one that is not valid (any more)."
    NOT_ALLOWED = 403, "This key does not open that"
    NOT_FOUND = 404, "Not found"
    UNKNOWN_DESIGN = 404, "No such design"
    UNKNOWN_CAM_SET = 404, "No such cam set"
    UNKNOWN_SPATIAL_CAM = 404, "No such spatial cam"
    UNKNOWN_SWEEP = 404, "No such sweep or item", "No sweep has this id, or not this item yet."
    UNKNOWN_ANALYSIS = 404, "No such analysis"
    UNKNOWN_TRAIN_RESPONSE = 404, "No such train response"
    UNKNOWN_LINKAGE = 404, "No such linkage"
    METHOD_NOT_ALLOWED = 405, "The resource does not have this method"
    REQUEST_TIMEOUT = 408, "The request took too long to arrive"
    NOT_DONE = 409, "The answer is not finished", "It is being worked on, or the work failed."
    PART_OF_SWEEP = 409, "The design belongs to a sweep", "It is deleted with the sweep."
    NOTHING_FITS = 409, "The design has no cam and so no files"
    DISMISSED = 409, "The question was deleted", "That happened while it was being worked on."
    BODY_TOO_LARGE = (413, "The body is too large", "Or it takes too long to read.")
    WRONG_MEDIA_TYPE = 415, "The body must be application/json"
    NO_SUCH_BYTES = 416, "The range is not satisfiable"
    MISDIRECTED = 421, "This service has another name", "See the header Host."
    INVALID_REQUEST = 422, "The request is invalid", "It is JSON, but does not satisfy its schema."
    INVALID_PARAMETER = 422, "A parameter or header is invalid"
    INVALID_DESIGN = 422, "The spec is invalid", "A value breaks a rule of the core."
    IDEMPOTENCY_KEY_REUSED = 422, "The idempotency key was used for another request"
    BUSY = 429, "The queue is full"
    QUOTA_USED_UP = 429, "The key's quota is used up", "`Retry-After` says when there is more."
    HEAD_TOO_LARGE = 431, "Path, query and headers are too large"
    INTERNAL = 500, "Internal error"
    SOLVER_FAILED = 500, "The solver failed", "It stopped without a usable point."
    NOT_INSTALLED = 501, "An optional package is not installed here"
    WORKER_LOST = 503, "The worker process died", "That happened while it worked on the question."
    ENGINE_UNREACHABLE = 503, "No worker can be reached"
    TOO_MANY_CONNECTIONS = 503, "Too many connections", "In all, or from one address."
    STORE_UNREACHABLE = 503, "The store cannot be reached"
    TIME_BUDGET = 504, "The time budget ended first", "`best` is the best design by then, if any."

    def __init__(self, status: int, title: str, meaning: str = "") -> None:
        self.status, self.title, self.meaning = status, title, meaning or f"{title}."

    @property
    def slug(self) -> str:
        """The last part of its address."""
        return self.name.lower().replace("_", "-")

    def __call__(
        self,
        detail: str,
        headers: dict[str, str] | None = None,
        violations: list[dict[str, Any]] | None = None,
    ) -> ServiceError:
        """An error of this type."""
        return ServiceError(self, detail, headers or {}, violations or [])


@dataclass(eq=False)
class ServiceError(Exception):
    """An error of the service; its text is for the caller.

    Attributes:
        problem: its type. detail: what is wrong and what to do, in sentences.
        headers: of the response. violations: the wrong fields, as problem documents list them.
    """

    problem: ProblemType
    detail: str
    headers: dict[str, str]
    violations: list[dict[str, Any]]

    def __str__(self) -> str:
        return self.detail


TYPES: dict[type[Exception], ProblemType] = {
    InputError: ProblemType.INVALID_DESIGN,
    SolverFailed: ProblemType.SOLVER_FAILED,
    ExtraMissing: ProblemType.NOT_INSTALLED,
    SQLAlchemyError: ProblemType.STORE_UNREACHABLE,
    TimeBudgetExceeded: ProblemType.TIME_BUDGET,
}


def problem_type(error: Exception) -> ProblemType:
    """The type of an exception; by the nearest base class, where it is not the service's own."""
    if isinstance(error, ServiceError):
        return error.problem
    rows = (TYPES[base] for base in type(error).__mro__ if base in TYPES)
    return next(rows, ProblemType.INTERNAL)


# SQLSTATEs of PostgreSQL for pages that are not what was written (XX001, XX002).
DAMAGED = ("XX001", "XX002")


def is_damage(error: BaseException) -> bool:
    """Whether a database says that its file is damaged, which no waiting mends."""
    found = getattr(error, "orig", None)
    # SQLite has no class of its own for it: what is neither lock nor disk is this.
    return type(found) is sqlite3.DatabaseError or getattr(found, "sqlstate", "") in DAMAGED
