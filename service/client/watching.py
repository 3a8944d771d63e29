"""The events of a sweep, across lost connections."""

from __future__ import annotations

import json
from collections.abc import AsyncGenerator
from contextlib import aclosing
from dataclasses import dataclass, replace
from typing import Any

import httpx2

from service.client.retries import Retries, lost, pause_before_retry, refused
from service.client.wire import Asked, Wire


@dataclass(frozen=True)
class Event:
    """Something happened to a sweep.

    Attributes:
        kind: ``item``, ``progress`` or ``end``. data: the item, or the sweep's summary.
        id: of the last item so far; watching goes on after it. Empty before the first.
    """

    kind: str
    data: dict[str, Any]
    id: str


async def watched(
    wire: Wire, retries: Retries, sweep: str, after: str, items: bool
) -> AsyncGenerator[Event, None]:
    """Every event up to ``end``; a lost connection is opened again after the last item seen.

    Args:
        sweep: path of the sweep. after: id of the last item that is known, or empty.
        items: tell of every item; otherwise of progress only.

    Raises:
        Refused, Unreachable: as for every call; an event starts the count of tries anew.
    """
    tried, seen = 0, after
    asked = Asked("GET", f"{sweep}/events", {"items": str(items).lower()})
    while True:
        tried += 1
        headers = {"Accept": "text/event-stream", **({"Last-Event-ID": seen} if seen else {})}
        pause = retries.pause_s(tried)
        try:
            async with wire.opened(replace(asked, headers=headers)) as opened:
                if opened.status >= 400:
                    answer = await opened.read()
                    wait = pause_before_retry(retries, answer, tried)
                    if wait is None:
                        raise refused(answer)
                    pause = wait
                else:
                    async with aclosing(opened.events()) as events:
                        async for told in events:
                            tried, seen = 0, told.id or seen
                            yield Event(told.event, json.loads(told.data), told.id)
                            if told.event == "end":
                                return
                    raise httpx2.RemoteProtocolError("the service ended the events before `end`")
        except httpx2.TransportError as error:
            if tried >= retries.tries:
                raise lost(asked, error, tried) from error
        await wire.pause(pause)
