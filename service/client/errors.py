"""What goes wrong between a client and its service.

ClientError
├── Unreachable     no answer, however often it was asked
└── Refused         the service's answer is a problem document
"""

from __future__ import annotations

from typing import Any


class ClientError(Exception):
    """Root of what the client raises."""


class Unreachable(ClientError):
    """The service gave no answer, or broke off, as often as it was asked."""


class Refused(ClientError):
    """The service said no; ``str`` of it is the problem's detail.

    Attributes:
        problem: the document (RFC 9457) as the service sent it; of an answer that is none, such as
            a proxy's, one made up from its status.
        status: the HTTP status.
        retry_after_s: when the service asked to be tried again [s]; None where it did not.
    """

    def __init__(
        self, problem: dict[str, Any], status: int, retry_after_s: float | None = None
    ) -> None:
        super().__init__(problem.get("detail") or problem.get("title") or f"HTTP status {status}")
        self.problem, self.status, self.retry_after_s = problem, status, retry_after_s

    @property
    def kind(self) -> str:
        """What kind of problem, such as ``invalid-request``: the end of its type."""
        return str(self.problem.get("type", "")).rpartition("/")[2]

    @property
    def errors(self) -> list[dict[str, Any]]:
        """Each wrong field: where, value, rule, way out."""
        return list(self.problem.get("errors", ()))

    @property
    def best(self) -> dict[str, Any] | None:
        """With status 504: the best that was found in time."""
        return self.problem.get("best")
