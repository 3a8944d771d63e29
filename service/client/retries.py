"""When a request is sent again, and how long to wait before."""

from __future__ import annotations

import random
from dataclasses import dataclass
from datetime import UTC, datetime
from email.utils import parsedate_to_datetime

import httpx2

from service.client.errors import Refused, Unreachable
from service.client.wire import Answer, Asked, Wire

BUSY = frozenset({429, 503})  # the service's own word, with Retry-After
PROXY = frozenset({502, 503, 504})  # somebody before the service
PROBLEM = "application/problem+json"


@dataclass(frozen=True)
class Retries:
    """How patient a client is.

    Attributes:
        tries: how often a request is sent at most.
        first_s: pause after the first try where the service names none; doubled every time,
            up to ``most_s``, and shortened by chance so that clients do not come back together.
        patience_s: longest Retry-After that is waited for; a longer one is an error at once.
    """

    tries: int = 5
    first_s: float = 0.5
    most_s: float = 20.0
    patience_s: float = 120.0

    def pause_s(self, tried: int) -> float:
        """After so many tries, where the service names no time."""
        return random.uniform(0.5, 1.0) * min(self.first_s * 2.0 ** (tried - 1), self.most_s)


async def sent(wire: Wire, retries: Retries, asked: Asked) -> Answer:
    """The answer to a request, sent again where that is safe and promises something.

    Raises:
        Refused: any status from 400 on. Unreachable: no answer.
    """
    tried = 0
    while True:
        tried += 1
        try:
            answer = await wire.send(asked)
        except httpx2.TransportError as error:
            if tried >= retries.tries or not asked.repeatable:
                raise lost(asked, error, tried) from error
            pause = retries.pause_s(tried)
        else:
            if answer.status < 400:
                return answer
            found = pause_before_retry(retries, answer, tried)
            if found is None:
                raise refused(answer)
            pause = found
        await wire.pause(pause)


def pause_before_retry(retries: Retries, answer: Answer, tried: int) -> float | None:
    """Seconds until a refused request is sent again; None where it is not."""
    if tried >= retries.tries:
        return None
    said = retry_after_s(answer.headers)
    if answer.status in BUSY and said is not None:
        return said if said <= retries.patience_s else None
    from_proxy = answer.status in PROXY and PROBLEM not in answer.headers.get("content-type", "")
    return retries.pause_s(tried) if from_proxy else None


def retry_after_s(headers: httpx2.Headers) -> float | None:
    """Retry-After in seconds from now, given as a number or as a date; None without one."""
    said = headers.get("retry-after", "").strip()
    if said.isascii() and said.isdecimal():
        return float(said)
    try:
        until = parsedate_to_datetime(said)
    except ValueError:
        return None
    if until.tzinfo is None:
        until = until.replace(tzinfo=UTC)
    return max(0.0, (until - datetime.now(UTC)).total_seconds())


def refused(answer: Answer) -> Refused:
    """An answer that is a no, as an exception."""
    problem: object = None
    if PROBLEM in answer.headers.get("content-type", ""):
        problem = httpx2.Response(200, content=answer.body).json()
    if not isinstance(problem, dict):
        text = answer.body[:200].decode("utf-8", "replace").strip()
        detail = f"HTTP status {answer.status} without a problem document: {text or 'empty'}"
        problem = {"title": "No problem document", "status": answer.status, "detail": detail}
    return Refused(problem, answer.status, retry_after_s(answer.headers))


def lost(asked: Asked, error: Exception, tried: int) -> Unreachable:
    """A request without an answer, as an exception."""
    again = "" if asked.repeatable else " It was not sent again, since that might do it twice."
    times = "once" if tried == 1 else f"{tried} times"
    why = str(error) or type(error).__name__
    return Unreachable(f"{asked.method} {asked.path}, tried {times}: {why}.{again}")
