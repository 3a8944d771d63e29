"""The calls of a client, as coroutines over a transport."""

from __future__ import annotations

import json
import uuid
from collections.abc import AsyncGenerator, Mapping, Sequence
from contextlib import aclosing
from pathlib import Path
from typing import Any

from pydantic_core import to_json

from service.client.download import ProgressCallback, download
from service.client.events import Event, watch_events
from service.client.retries import Retries, send_with_retries
from service.client.transport import Answer, Request, Transport

Json = dict[str, Any]
Spec = Mapping[str, Any] | Any  # a body, or a model of pydantic that has its fields
POLL_S = 1.0  # between requests for an answer under way, where the service names no time


class Calls:
    """Questions, answers, sweeps, files. Bodies are dictionaries, as on the wire.

    Every call raises Refused for a problem document, and Unreachable where there is no response.
    """

    def __init__(self, transport: Transport, retries: Retries) -> None:
        self._transport, self._retries = transport, retries

    async def get(self, path: str, **query: Any) -> Json:
        """Any JSON document of the service, by its path, such as a link of an answer."""
        return _body(await self._send(Request("GET", path, query)))

    async def design(self, spec: Spec) -> Json:
        """The cam for a DesignSpec."""
        return await self._answer_to("/v1/designs", spec)

    async def analyse(self, spec: Spec) -> Json:
        """The analysis of a given cam."""
        return await self._answer_to("/v1/analyses", spec)

    async def read_back(self, measured: Spec) -> Json:
        """The motion that measured points of a profile give."""
        return await self._answer_to("/v1/profile-analyses", measured)

    async def cam_set(self, spec: Spec) -> Json:
        """The cams of one shaft."""
        return await self._answer_to("/v1/cam-sets", spec)

    async def spatial_cam(self, spec: Spec) -> Json:
        """The spatial cam for a SpatialCamSpec."""
        return await self._answer_to("/v1/spatial-cams", spec)

    async def linkage(self, kind: str, spec: Spec) -> Json:
        """A linkage of a kind, such as ``six-bar-shapers``."""
        return await self._answer_to(f"/v1/linkages/{kind}", spec)

    async def train_response(self, spec: Spec) -> Json:
        """The response of a follower train to its cam."""
        return await self._answer_to("/v1/train-responses", spec)

    async def sweep(self, spec: Spec) -> Json:
        """Start a sweep, or join it where it is running; its current state."""
        return _body(await self._send(_question("/v1/sweeps", spec)))

    def watch(
        self, sweep: str, *, after: str = "", items: bool = True
    ) -> AsyncGenerator[Event, None]:
        """All events of a sweep, continued after lost connections."""
        return watch_events(self._transport, self._retries, _sweep(sweep), after, items)

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
        self, sweep: str, *, minimise: Sequence[str] = (), maximise: Sequence[str] = ()
    ) -> Json:
        """The Pareto front of a sweep in these quantities."""
        path = f"{_sweep(sweep)}/pareto"
        return await self.get(path, minimise=list(minimise), maximise=list(maximise))

    async def dismiss(self, sweep: str) -> Json:
        """Stop a sweep and keep what is done; one that has ended stays as it is."""
        request = Request("DELETE", _sweep(sweep), {"discard": "false"})
        return _body(await self._send(request))

    async def delete(self, path: str) -> None:
        """Delete an answer or a sweep, by its path; a running sweep is stopped first."""
        await self._send(Request("DELETE", path, repeatable=False))

    async def download(
        self, path: str, target: Path, *, progress: ProgressCallback | None = None, **query: Any
    ) -> Path:
        """A file, such as ``/v1/designs/ID/profile.csv``; continues an interrupted download."""
        return await download(
            self._transport, self._retries, Request("GET", path, query), target, progress
        )

    async def _answer_to(self, path: str, spec: Spec) -> Json:
        """The answer to a question; waits until it is done."""
        answer = await self._send(_question(path, spec))
        where = answer.headers.get("location", "")
        while answer.status == 202:
            await self._transport.pause(float(answer.headers.get("retry-after", POLL_S)))
            answer = await self._send(Request("GET", where))
        return _body(answer)

    async def _send(self, request: Request) -> Answer:
        return await send_with_retries(self._transport, self._retries, request)


def _question(path: str, spec: Spec) -> Request:
    """A spec as a request: its key makes it safe to send again."""
    key = str(uuid.uuid4())
    headers = {"Content-Type": "application/json", "Idempotency-Key": key}
    return Request("POST", path, body=to_json(spec), headers=headers)


def _sweep(sweep: str) -> str:
    return f"/v1/sweeps/{sweep}"


def _body(answer: Answer) -> Json:
    found: Json = json.loads(answer.body)
    return found
