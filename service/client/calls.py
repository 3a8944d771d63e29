"""The calls of a client, as coroutines."""

from __future__ import annotations

import asyncio
import json
import os
import uuid
from collections.abc import AsyncGenerator, Callable, Coroutine, Mapping, Sequence
from contextlib import aclosing
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Self

import httpx2
from pydantic_core import to_json

from service.client.exchange import Exchange, ProgressCallback, Request, Retries, download

Json = dict[str, Any]
Spec = Mapping[str, Any] | Any  # a body, or a model of pydantic that has its fields
KEY = "CAMWRIGHT_KEY"  # the variable with the key, where none is given
ADDRESS = "http://127.0.0.1:8000"
SILENCE_S = 60.0  # without a byte, after which a connection counts as lost
POLL_S = 1.0  # between requests for an answer under way, where the service names no time


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


def _ask(path: str, text: str) -> Callable[[AsyncClient, Spec], Coroutine[Any, Any, Json]]:
    """The call for questions of one collection; ``text`` is its docstring."""

    async def ask(self: AsyncClient, spec: Spec, /) -> Json:
        return await self.answer(path, spec)

    ask.__doc__ = text
    return ask


class AsyncClient:
    """Questions, answers, sweeps, files. Bodies are dictionaries, as on the wire.

    Every call raises Refused for a problem document, and Unreachable where there is no response.

    Args:
        url: address of the service. retries: how often and how long to try.
        key: to the service, where it asks for one; None: that of CAMWRIGHT_KEY, "": none.
        timeout_s: without a byte, after which the connection counts as lost.
        more: for httpx2.AsyncClient, such as ``headers``, ``verify`` or ``proxy``.
    """

    def __init__(
        self,
        url: str = ADDRESS,
        *,
        retries: Retries = Retries(),  # noqa: B008 (frozen)
        timeout_s: float = SILENCE_S,
        key: str | None = None,
        **more: Any,
    ) -> None:
        http = httpx2.AsyncClient(base_url=url, timeout=timeout_s, **more)
        key = os.environ.get(KEY) if key is None else key
        if key:
            http.headers["Authorization"] = f"Bearer {key}"
        self._exchange = Exchange(http, retries)

    async def __aenter__(self) -> Self:
        return self

    async def __aexit__(self, *_: object) -> None:
        await self.close()

    async def close(self) -> None:
        """Close its connections."""
        await self._exchange.http.aclose()

    async def get(self, /, path: str, **query: Any) -> Json:
        """Any JSON document of the service, by its path, such as a link of an answer."""
        return _document(await self._exchange.send(Request("GET", path, query)))

    async def answer(self, path: str, spec: Spec) -> Json:
        """The answer to a question, by the path of its collection; waits until it is done."""
        response = await self._exchange.send(_question(path, spec))
        location = response.headers.get("location", "")
        while response.status_code == 202:
            await asyncio.sleep(float(response.headers.get("retry-after", POLL_S)))
            response = await self._exchange.send(Request("GET", location))
        return _document(response)

    design = _ask("/v1/designs", "The cam for a DesignSpec.")
    analyse = _ask("/v1/analyses", "The analysis of a given cam.")
    read_back = _ask("/v1/profile-analyses", "The motion that points of a profile give.")
    cam_set = _ask("/v1/cam-sets", "The cams of one shaft.")
    spatial_cam = _ask("/v1/spatial-cams", "The spatial cam for a SpatialCamSpec.")
    train_response = _ask("/v1/train-responses", "The response of a follower train to its cam.")

    async def linkage(self, kind: str, spec: Spec) -> Json:
        """A linkage of a kind, such as ``six-bar-shapers``."""
        return await self.answer(f"/v1/linkages/{kind}", spec)

    async def sweep(self, spec: Spec) -> Json:
        """Start a sweep, or join it where it is running; its current state."""
        return _document(await self._exchange.send(_question("/v1/sweeps", spec)))

    async def watch(
        self, sweep: str, *, after: str = "", items: bool = True
    ) -> AsyncGenerator[Event, None]:
        """All events of a sweep up to ``end``, continued after lost connections.

        ``after`` is the id of the last item that is known; without ``items`` progress alone.
        """
        last, query = after, {"items": str(items).lower()}

        def next_request() -> Request:
            resuming = {"Last-Event-ID": last} if last else {}
            headers = {"Accept": "text/event-stream", **resuming}
            return Request("GET", f"{_sweep(sweep)}/events", query, headers=headers)

        async def read(response: httpx2.Response) -> AsyncGenerator[Event, None]:
            async for event in httpx2.EventSource(response):
                yield Event(event.event, json.loads(event.data), event.id)
                if event.event == "end":
                    return
            raise httpx2.RemoteProtocolError("the stream ended before the event `end`")

        async with aclosing(self._exchange.receive(next_request, read)) as events:
            async for event in events:
                last = event.id or last
                yield event

    async def wait(self, sweep: str) -> Json:
        """The sweep when it has ended."""
        async with aclosing(self.watch(sweep, items=False)) as events:
            async for _ in events:
                pass
        return await self.get(_sweep(sweep))

    async def items(self, sweep: str, *, status: str | None = None) -> AsyncGenerator[Json, None]:
        """All items finished by now, in the order in which they were finished."""
        query: Json = {"limit": 500} if status is None else {"limit": 500, "status": status}
        while True:
            page = await self.get(f"{_sweep(sweep)}/items", **query)
            for item in page["items"]:
                yield item
            if page["next"] is None or not page["items"]:
                return
            query["cursor"] = page["next"]

    async def pareto(
        self,
        sweep: str,
        *,
        minimise: Sequence[str] = (),
        maximise: Sequence[str] = (),
        tolerance: float | None = None,
    ) -> Json:
        """The Pareto front of a sweep in these quantities.

        ``tolerance``: relative difference that does not count; None: the gap that is left between
        a design and its proven bound, in the quantity that was minimised.
        """
        path, query = f"{_sweep(sweep)}/pareto", {"minimise": list(minimise)}
        chosen = {} if tolerance is None else {"tolerance": tolerance}
        return await self.get(path, **query, maximise=list(maximise), **chosen)

    async def dismiss(self, sweep: str) -> Json:
        """Stop a sweep and keep what is done; one that has ended stays as it is."""
        request = Request("DELETE", _sweep(sweep), {"discard": "false"})
        return _document(await self._exchange.send(request))

    async def delete(self, path: str) -> None:
        """Delete an answer or a sweep, by its path; a running sweep is stopped first."""
        await self._exchange.send(Request("DELETE", path, repeatable=False))

    async def download(
        self, /, path: str, target: Path, *, progress: ProgressCallback | None = None, **query: Any
    ) -> Path:
        """A file, such as ``/v1/designs/ID/profile.csv``; continues an interrupted download."""
        return await download(self._exchange, Request("GET", path, query), target, progress)


def _question(path: str, spec: Spec) -> Request:
    """A spec as a request: its key makes it safe to send again."""
    headers = {"Content-Type": "application/json", "Idempotency-Key": str(uuid.uuid4())}
    return Request("POST", path, body=to_json(spec), headers=headers)


def _sweep(sweep: str) -> str:
    return f"/v1/sweeps/{sweep}"


def _document(response: httpx2.Response) -> Json:
    document: Json = json.loads(response.content)
    return document
