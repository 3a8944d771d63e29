"""Errors of the client.

ClientError
├── Unreachable     no response after all tries
└── Refused         the response is a problem document
"""

from __future__ import annotations

from typing import Any


class ClientError(Exception):
    """Base class of the client's errors."""


class Unreachable(ClientError):
    """No response, or a broken one, after all tries."""


class Refused(ClientError):
    """The service answered with a problem document; ``str`` of it is the problem's detail.

    Attributes:
        problem: the document (RFC 9457) as sent; for another response, such as a proxy's, one made
            from its status.
        status: the HTTP status.
        retry_after_s: Retry-After of the response [s]; None where there is none.
    """

    def __init__(
        self, problem: dict[str, Any], status: int, retry_after_s: float | None = None
    ) -> None:
        super().__init__(problem.get("detail") or problem.get("title") or f"HTTP status {status}")
        self.problem, self.status, self.retry_after_s = problem, status, retry_after_s

    @property
    def kind(self) -> str:
        """The kind of problem, such as ``invalid-request``: the end of its type."""
        return str(self.problem.get("type", "")).rpartition("/")[2]

    @property
    def errors(self) -> list[dict[str, Any]]:
        """Each wrong field: where, value, rule, way out."""
        return list(self.problem.get("errors", ()))

    @property
    def best(self) -> dict[str, Any] | None:
        """With status 504: the best answer found in time."""
        return self.problem.get("best")
