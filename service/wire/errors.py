"""The errors that the service raises, and the table from exceptions to problem documents."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from sqlalchemy.exc import SQLAlchemyError

from synthesis.errors import ExtraMissing, InputError, SolverFailed, TimeBudgetExceeded


class ServiceError(Exception):
    """Base class of the service's errors; its text is for the caller.

    Args:
        detail: what is wrong and what to do, in sentences. headers: of the response.
    """

    def __init__(self, detail: str, headers: dict[str, str] | None = None) -> None:
        super().__init__(detail)
        self.detail, self.headers = detail, headers or {}


class InvalidBody(ServiceError):
    """The body is JSON but does not satisfy its schema; ``errors`` says where and why."""

    def __init__(self, detail: str, violations: list[dict[str, Any]]) -> None:
        super().__init__(detail)
        self.violations = violations


class NotJson(ServiceError):
    """The body is not valid JSON."""


class WrongMediaType(ServiceError):
    """The body is not declared as JSON."""


class BodyTooLarge(ServiceError):
    """The body is larger than this server's limit."""


class UnknownDesign(ServiceError):
    """No design has this id."""


class UnknownCamSet(ServiceError):
    """No cam set has this id."""


class UnknownSpatialCam(ServiceError):
    """No spatial cam has this id."""


class UnknownSweep(ServiceError):
    """No sweep has this id, or it has no such item yet."""


class FormatMissing(ServiceError):
    """An optional package that writes the format is not installed on this server."""


class UnknownAnalysis(ServiceError):
    """No analysis of this kind has this id."""


class UnknownTrainResponse(ServiceError):
    """No response of a follower train has this id."""


class UnknownLinkage(ServiceError):
    """No linkage of this kind has this id."""


class BadQuery(ServiceError):
    """A query parameter or a header is invalid."""


class NotDone(ServiceError):
    """The answer is still being worked on, or the work failed: it has no files."""


class PartOfSweep(ServiceError):
    """The design is an item of a sweep and is deleted with the sweep."""


class NothingFits(ServiceError):
    """The limits are infeasible: there is no cam to export."""


class KeyReused(ServiceError):
    """An Idempotency-Key was used before with another body."""


class Busy(ServiceError):
    """The queue of this server is full."""


class WorkerLost(ServiceError):
    """The worker process died while it worked on the question."""


class EngineUnreachable(ServiceError):
    """No worker can be reached."""


class Dismissed(ServiceError):
    """The question was deleted while it was being worked on."""


@dataclass(frozen=True)
class ProblemType:
    """A type of problem: its HTTP status, its slug under /problems/, and its title.

    ``again_s`` [s] is for Retry-After, where the exception names no time.
    """

    status: int
    slug: str
    title: str
    again_s: int | None = None


PROBLEMS: dict[type[Exception], ProblemType] = {
    InvalidBody: ProblemType(422, "invalid-request", "The request is invalid"),
    BadQuery: ProblemType(422, "invalid-parameter", "A parameter or header is invalid"),
    InputError: ProblemType(422, "invalid-design", "The spec is invalid"),
    KeyReused: ProblemType(
        422, "idempotency-key-reused", "The idempotency key was used for another request"
    ),
    NotJson: ProblemType(400, "not-json", "The body is not JSON"),
    UnknownDesign: ProblemType(404, "unknown-design", "No such design"),
    UnknownCamSet: ProblemType(404, "unknown-cam-set", "No such cam set"),
    UnknownSpatialCam: ProblemType(404, "unknown-spatial-cam", "No such spatial cam"),
    UnknownSweep: ProblemType(404, "unknown-sweep", "No such sweep or item"),
    FormatMissing: ProblemType(501, "format-missing", "This server does not write the format"),
    UnknownTrainResponse: ProblemType(404, "unknown-train-response", "No such train response"),
    UnknownAnalysis: ProblemType(404, "unknown-analysis", "No such analysis"),
    UnknownLinkage: ProblemType(404, "unknown-linkage", "No such linkage"),
    NotDone: ProblemType(409, "not-done", "The answer is not finished"),
    PartOfSweep: ProblemType(409, "part-of-sweep", "The design belongs to a sweep"),
    NothingFits: ProblemType(409, "nothing-fits", "The design is infeasible and has no files"),
    Dismissed: ProblemType(409, "dismissed", "The question was deleted"),
    BodyTooLarge: ProblemType(413, "body-too-large", "The body is too large"),
    WrongMediaType: ProblemType(415, "wrong-media-type", "The body must be application/json"),
    Busy: ProblemType(429, "busy", "The queue is full"),
    SolverFailed: ProblemType(500, "solver-failed", "The solver failed"),
    ExtraMissing: ProblemType(501, "not-installed", "An optional package is not installed here"),
    WorkerLost: ProblemType(503, "worker-lost", "The worker process died"),
    EngineUnreachable: ProblemType(503, "engine-unreachable", "No worker can be reached"),
    SQLAlchemyError: ProblemType(
        503, "store-unreachable", "The store cannot be reached", again_s=2
    ),
    TimeBudgetExceeded: ProblemType(504, "time-budget", "The time budget ended first"),
}
BY_STATUS: dict[int, ProblemType] = {
    404: ProblemType(404, "not-found", "Not found"),
    405: ProblemType(405, "method-not-allowed", "The resource does not have this method"),
    416: ProblemType(416, "no-such-bytes", "The range is not satisfiable"),
    500: ProblemType(500, "internal", "Internal error"),
}


def problem_type(error: Exception) -> ProblemType | None:
    """The problem type of an exception, by its nearest base class; None if there is none."""
    rows = (PROBLEMS[base] for base in type(error).__mro__ if base in PROBLEMS)
    return next(rows, None)
