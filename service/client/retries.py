"""When a request is sent again, and after what pause."""

from __future__ import annotations

import random
from dataclasses import dataclass
from datetime import UTC, datetime
from email.utils import parsedate_to_datetime

import httpx2

from service.client.errors import Refused, Unreachable
from service.client.transport import Answer, Request, Transport

BUSY = frozenset({429, 503})  # from the service, with Retry-After
PROXY = frozenset({502, 503, 504})  # from a proxy before the service
PROBLEM = "application/problem+json"


@dataclass(frozen=True)
class Retries:
    """How often and how long a client tries.

    Attributes:
        tries: how often a request is sent at most.
        first_s: pause [s] after the first try where the service names none; doubled every time, up
            to ``most_s``, and shortened at random so that clients do not retry together.
        patience_s: longest Retry-After [s] that is waited for; a longer one is an error.
    """

    tries: int = 5
    first_s: float = 0.5
    most_s: float = 20.0
    patience_s: float = 120.0

    def pause_s(self, tried: int) -> float:
        """The pause [s] after so many tries, where the service names none."""
        return random.uniform(0.5, 1.0) * min(self.first_s * 2.0 ** (tried - 1), self.most_s)


async def send_with_retries(transport: Transport, retries: Retries, request: Request) -> Answer:
    """The response to a request, which is sent again where that is safe and may help.

    Raises:
        Refused: any status from 400 on. Unreachable: no response.
    """
    tried = 0
    while True:
        tried += 1
        try:
            answer = await transport.send(request)
        except httpx2.TransportError as error:
            if tried >= retries.tries or not request.repeatable:
                raise unreachable(request, error, tried) from error
            pause = retries.pause_s(tried)
        else:
            if answer.status < 400:
                return answer
            found = pause_before_retry(retries, answer, tried)
            if found is None:
                raise refused(answer)
            pause = found
        await transport.pause(pause)


def pause_before_retry(retries: Retries, answer: Answer, tried: int) -> float | None:
    """Seconds until a refused request is sent again; None where it is not."""
    if tried >= retries.tries:
        return None
    wait = retry_after_s(answer.headers)
    if answer.status in BUSY and wait is not None:
        return wait if wait <= retries.patience_s else None
    from_proxy = answer.status in PROXY and PROBLEM not in answer.headers.get("content-type", "")
    return retries.pause_s(tried) if from_proxy else None


def retry_after_s(headers: httpx2.Headers) -> float | None:
    """Retry-After in seconds from now, given as a number or as a date; None without one."""
    text = headers.get("retry-after", "").strip()
    if text.isascii() and text.isdecimal():
        return float(text)
    try:
        until = parsedate_to_datetime(text)
    except ValueError:
        return None
    if until.tzinfo is None:
        until = until.replace(tzinfo=UTC)
    return max(0.0, (until - datetime.now(UTC)).total_seconds())


def refused(answer: Answer) -> Refused:
    """The exception for a response with a status from 400 on."""
    problem: object = None
    if PROBLEM in answer.headers.get("content-type", ""):
        problem = httpx2.Response(200, content=answer.body).json()
    if not isinstance(problem, dict):
        text = answer.body[:200].decode("utf-8", "replace").strip()
        detail = f"HTTP status {answer.status} without a problem document: {text or 'empty'}"
        problem = {"title": "No problem document", "status": answer.status, "detail": detail}
    return Refused(problem, answer.status, retry_after_s(answer.headers))


def unreachable(request: Request, error: Exception, tried: int) -> Unreachable:
    """The exception for a request without a response."""
    again = "" if request.repeatable else " It was not sent again, as that might repeat its effect."
    times = "once" if tried == 1 else f"{tried} times"
    why = str(error) or type(error).__name__
    return Unreachable(f"{request.method} {request.path}, tried {times}: {why}.{again}")
