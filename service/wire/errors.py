"""What the service raises on purpose, and the one table from exceptions to problems."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from sqlalchemy.exc import SQLAlchemyError

from synthesis.errors import ExtraMissing, InputError, SolverFailed, TimeBudgetExceeded


class ServiceError(Exception):
    """Root of what the service raises; its text is for the caller.

    Args:
        detail: what went wrong and the way out, in sentences.
        headers: to send with the answer.
    """

    def __init__(self, detail: str, headers: dict[str, str] | None = None) -> None:
        super().__init__(detail)
        self.detail, self.headers = detail, headers or {}


class InvalidBody(ServiceError):
    """The body is JSON but not what was asked for; ``violations`` says where and why."""

    def __init__(self, detail: str, violations: list[dict[str, Any]]) -> None:
        super().__init__(detail)
        self.violations = violations


class NotJson(ServiceError):
    """The body cannot be read as JSON."""


class WrongMediaType(ServiceError):
    """The body is declared as something else than JSON."""


class BodyTooLarge(ServiceError):
    """The body is larger than this server reads."""


class UnknownDesign(ServiceError):
    """No design has this id."""


class UnknownCamSet(ServiceError):
    """No cam set has this id."""


class UnknownSpatialCam(ServiceError):
    """No spatial cam has this id."""


class UnknownSweep(ServiceError):
    """No sweep has this id, or it has no such item yet."""


class FormatMissing(ServiceError):
    """This server was installed without what writes the format."""


class UnknownAnalysis(ServiceError):
    """No analysis of this kind has this id."""


class UnknownTrainResponse(ServiceError):
    """No response of a follower train has this id."""


class UnknownLinkage(ServiceError):
    """No linkage of this kind has this id."""


class BadQuery(ServiceError):
    """A query parameter or a header makes no sense."""


class NotDone(ServiceError):
    """The design is still being worked on: it has no files yet."""


class PartOfSweep(ServiceError):
    """The design is an item of a sweep and goes with it."""


class NothingFits(ServiceError):
    """The design is infeasible: there is no cam to export."""


class KeyReused(ServiceError):
    """An Idempotency-Key came back with another body."""


class Busy(ServiceError):
    """More designs are waiting than this server takes."""


class WorkerLost(ServiceError):
    """The process that worked on the design died."""


class EngineUnreachable(ServiceError):
    """There is no worker to send the design to."""


class Dismissed(ServiceError):
    """The design was deleted while it was being worked on."""


@dataclass(frozen=True)
class Kind:
    """A type of problem: its HTTP status, its slug under /problems/, and its title.

    ``again_s`` is for Retry-After, where it passes by itself and the exception names no time [s].
    """

    status: int
    slug: str
    title: str
    again_s: int | None = None


PROBLEMS: dict[type[Exception], Kind] = {
    InvalidBody: Kind(422, "invalid-request", "The request makes no sense"),
    BadQuery: Kind(422, "invalid-parameter", "A parameter or header makes no sense"),
    InputError: Kind(422, "invalid-design", "The design makes no sense"),
    KeyReused: Kind(422, "idempotency-key-reused", "The key belongs to another request"),
    NotJson: Kind(400, "not-json", "The body is not JSON"),
    UnknownDesign: Kind(404, "unknown-design", "No such design"),
    UnknownCamSet: Kind(404, "unknown-cam-set", "No such cam set"),
    UnknownSpatialCam: Kind(404, "unknown-spatial-cam", "No such spatial cam"),
    UnknownSweep: Kind(404, "unknown-sweep", "No such sweep or item"),
    FormatMissing: Kind(501, "format-missing", "This server does not write the format"),
    UnknownTrainResponse: Kind(404, "unknown-train-response", "No such train response"),
    UnknownAnalysis: Kind(404, "unknown-analysis", "No such analysis"),
    UnknownLinkage: Kind(404, "unknown-linkage", "No such linkage"),
    NotDone: Kind(409, "not-done", "The design is not finished"),
    PartOfSweep: Kind(409, "part-of-sweep", "The design belongs to a sweep"),
    NothingFits: Kind(409, "nothing-fits", "The design is infeasible and has no files"),
    Dismissed: Kind(409, "dismissed", "The design was dismissed"),
    BodyTooLarge: Kind(413, "body-too-large", "The body is too large"),
    WrongMediaType: Kind(415, "wrong-media-type", "The body must be application/json"),
    Busy: Kind(429, "busy", "Too many designs are waiting"),
    SolverFailed: Kind(500, "solver-failed", "The solver gave no usable answer"),
    ExtraMissing: Kind(501, "not-installed", "An optional part is not installed here"),
    WorkerLost: Kind(503, "worker-lost", "The worker was lost"),
    EngineUnreachable: Kind(503, "engine-unreachable", "No worker can be reached"),
    SQLAlchemyError: Kind(503, "store-unreachable", "The store cannot be reached", again_s=2),
    TimeBudgetExceeded: Kind(504, "time-budget", "The time budget ended first"),
}
BY_STATUS: dict[int, Kind] = {
    404: Kind(404, "not-found", "Nothing is here"),
    405: Kind(405, "method-not-allowed", "This resource does not know the method"),
    416: Kind(416, "no-such-bytes", "The file has no such bytes"),
    500: Kind(500, "internal", "Something went wrong in the service"),
}


def kind_of(error: Exception) -> Kind | None:
    """The row of the table for an exception, by its nearest class; None where there is none."""
    rows = (PROBLEMS[base] for base in type(error).__mro__ if base in PROBLEMS)
    return next(rows, None)
