"""What a client can ask of a service: every call once, as a coroutine over a wire."""

from __future__ import annotations

import json
import uuid
from collections.abc import AsyncGenerator, Mapping, Sequence
from contextlib import aclosing
from pathlib import Path
from typing import Any

from pydantic_core import to_json

from service.client.download import Told, downloaded
from service.client.retries import Retries, sent
from service.client.watching import Event, watched
from service.client.wire import Answer, Asked, Wire

Json = dict[str, Any]
Spec = Mapping[str, Any] | Any  # a body, or a model of pydantic that has its fields
LOOK_S = 1.0  # between looks at what is under way, where the service names no time


class Calls:
    """Questions, answers, sweeps, files. Bodies are dictionaries, as on the wire.

    Every call raises Refused where the service says no, and Unreachable where it does not answer.
    """

    def __init__(self, wire: Wire, retries: Retries) -> None:
        self._wire, self._retries = wire, retries

    async def get(self, path: str, **query: Any) -> Json:
        """Anything the service has, by its path, such as a link of an answer."""
        return _body(await self._sent(Asked("GET", path, query)))

    async def design(self, spec: Spec) -> Json:
        """The cam for a DesignSpec."""
        return await self._asked("/v1/designs", spec)

    async def analyse(self, spec: Spec) -> Json:
        """What a cam does that is given in full."""
        return await self._asked("/v1/analyses", spec)

    async def read_back(self, measured: Spec) -> Json:
        """The motion, from measured points of a profile."""
        return await self._asked("/v1/profile-analyses", measured)

    async def cam_set(self, spec: Spec) -> Json:
        """The cams of one shaft."""
        return await self._asked("/v1/cam-sets", spec)

    async def spatial_cam(self, spec: Spec) -> Json:
        """The spatial cam for a SpatialCamSpec."""
        return await self._asked("/v1/spatial-cams", spec)

    async def linkage(self, kind: str, spec: Spec) -> Json:
        """A linkage of a kind, such as ``six-bar-shapers``."""
        return await self._asked(f"/v1/linkages/{kind}", spec)

    async def train_response(self, spec: Spec) -> Json:
        """What a TrainSpec's follower train does on its cam."""
        return await self._asked("/v1/train-responses", spec)

    async def sweep(self, spec: Spec) -> Json:
        """Start a sweep, or join it where it is under way; as it stands."""
        return _body(await self._sent(_question("/v1/sweeps", spec)))

    def watch(
        self, sweep: str, *, after: str = "", items: bool = True
    ) -> AsyncGenerator[Event, None]:
        """Every event of a sweep up to its end, across lost connections."""
        return watched(self._wire, self._retries, _sweep(sweep), after, items)

    async def wait(self, sweep: str) -> Json:
        """The sweep when it is over."""
        async with aclosing(self.watch(sweep, items=False)) as events:
            async for _ in events:
                pass
        return await self.get(_sweep(sweep))

    async def items(self, sweep: str, *, status: str | None = None) -> AsyncGenerator[Json, None]:
        """Every item that is finished by now, in the order in which they were finished."""
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
        """What no other design of the sweep beats in all of these quantities."""
        path = f"{_sweep(sweep)}/pareto"
        return await self.get(path, minimise=list(minimise), maximise=list(maximise))

    async def dismiss(self, sweep: str) -> Json:
        """Stop a sweep and keep what is done; one that is over stays as it is."""
        asked = Asked("DELETE", _sweep(sweep), {"discard": "false"})
        return _body(await self._sent(asked))

    async def delete(self, path: str) -> None:
        """Forget something, by its path; a sweep that is under way is stopped first."""
        await self._sent(Asked("DELETE", path, repeatable=False))

    async def download(
        self, path: str, target: Path, *, told: Told | None = None, **query: Any
    ) -> Path:
        """A file, such as ``/v1/designs/ID/profile.csv``; goes on where an earlier call broke."""
        return await downloaded(self._wire, self._retries, Asked("GET", path, query), target, told)

    async def _asked(self, path: str, spec: Spec) -> Json:
        """The answer to a question, however long it takes."""
        answer = await self._sent(_question(path, spec))
        where = answer.headers.get("location", "")
        while answer.status == 202:
            await self._wire.pause(float(answer.headers.get("retry-after", LOOK_S)))
            answer = await self._sent(Asked("GET", where))
        return _body(answer)

    async def _sent(self, asked: Asked) -> Answer:
        return await sent(self._wire, self._retries, asked)


def _question(path: str, spec: Spec) -> Asked:
    """A spec as a request: its key makes it safe to send again."""
    key = str(uuid.uuid4())
    headers = {"Content-Type": "application/json", "Idempotency-Key": key}
    return Asked("POST", path, body=to_json(spec), headers=headers)


def _sweep(sweep: str) -> str:
    return f"/v1/sweeps/{sweep}"


def _body(answer: Answer) -> Json:
    found: Json = json.loads(answer.body)
    return found
