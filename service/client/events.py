"""The events of a sweep, continued after lost connections."""

from __future__ import annotations

import json
from collections.abc import AsyncGenerator
from contextlib import aclosing
from dataclasses import dataclass, replace
from typing import Any

import httpx2

from service.client.retries import Retries, pause_before_retry, refused, unreachable
from service.client.transport import Request, Transport


@dataclass(frozen=True)
class Event:
    """An event of a sweep.

    Attributes:
        kind: ``item``, ``progress`` or ``end``. data: the item, or the sweep's summary.
        id: of the last item so far, after which the stream continues; empty before the first.
    """

    kind: str
    data: dict[str, Any]
    id: str


async def watch_events(
    transport: Transport, retries: Retries, sweep: str, after: str, items: bool
) -> AsyncGenerator[Event, None]:
    """All events up to ``end``; after a lost connection the stream continues with the next item.

    Args:
        sweep: path of the sweep. after: id of the last item that is known, or empty.
        items: events for every item; otherwise for progress only.

    Raises:
        Refused, Unreachable: as for every call; every event resets the number of tries.
    """
    tried, seen = 0, after
    request = Request("GET", f"{sweep}/events", {"items": str(items).lower()})
    while True:
        tried += 1
        headers = {"Accept": "text/event-stream", **({"Last-Event-ID": seen} if seen else {})}
        pause = retries.pause_s(tried)
        try:
            async with transport.stream(replace(request, headers=headers)) as response:
                if response.status >= 400:
                    answer = await response.read()
                    wait = pause_before_retry(retries, answer, tried)
                    if wait is None:
                        raise refused(answer)
                    pause = wait
                else:
                    async with aclosing(response.events()) as events:
                        async for event in events:
                            tried, seen = 0, event.id or seen
                            yield Event(event.event, json.loads(event.data), event.id)
                            if event.event == "end":
                                return
                    raise httpx2.RemoteProtocolError("the stream ended before the event `end`")
        except httpx2.TransportError as error:
            if tried >= retries.tries:
                raise unreachable(request, error, tried) from error
        await transport.pause(pause)
