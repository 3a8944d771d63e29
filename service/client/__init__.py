"""A client of the service, for programs: `Client` waits, `AsyncClient` awaits.

    with Client("http://127.0.0.1:8000") as client:
        design = client.design(spec)
        client.download(design["links"]["profile.csv"], Path("profile.csv"))

Both have the same calls: `AsyncClient` has them as coroutines and asynchronous iterators.
"""

from __future__ import annotations

from collections.abc import AsyncGenerator, Callable, Iterator, Sequence
from pathlib import Path
from typing import Any, Self, TypeVar

import httpx2

from service.client.calls import Calls, Json, Spec
from service.client.download import Told
from service.client.errors import ClientError, Refused, Unreachable
from service.client.retries import Retries
from service.client.watching import Event
from service.client.wire import AwaitingWire, WaitingWire, run

__all__ = [
    "AsyncClient", "Client", "ClientError", "Event", "Refused", "Retries", "Unreachable",
]  # fmt: skip
T = TypeVar("T")
ADDRESS = "http://127.0.0.1:8000"
SILENT_S = 60.0  # without a byte, until a connection counts as lost


class AsyncClient(Calls):
    """The calls of `Calls`, to be awaited.

    Args:
        url: where the service is. retries: how patient to be.
        timeout_s: without a byte, until a connection counts as lost and the request is sent again.
        more: for httpx2.AsyncClient, such as ``headers``, ``verify`` or ``proxy``.
    """

    def __init__(
        self,
        url: str = ADDRESS,
        *,
        retries: Retries = Retries(),  # noqa: B008 (frozen)
        timeout_s: float = SILENT_S,
        **more: Any,
    ) -> None:
        self._http = httpx2.AsyncClient(base_url=url, timeout=timeout_s, **more)
        super().__init__(AwaitingWire(self._http), retries)

    async def __aenter__(self) -> Self:
        return self

    async def __aexit__(self, *_: object) -> None:
        await self.close()

    async def close(self) -> None:
        """Close its connections."""
        await self._http.aclose()


class Client:
    """The calls of `Calls`, waited for.

    Args:
        url: where the service is. retries: how patient to be.
        timeout_s: without a byte, until a connection counts as lost and the request is sent again.
        more: for httpx2.Client, such as ``headers``, ``verify`` or ``proxy``.
    """

    def __init__(
        self,
        url: str = ADDRESS,
        *,
        retries: Retries = Retries(),  # noqa: B008 (frozen)
        timeout_s: float = SILENT_S,
        **more: Any,
    ) -> None:
        self._http = httpx2.Client(base_url=url, timeout=timeout_s, **more)
        self._calls = Calls(WaitingWire(self._http), retries)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Close its connections."""
        self._http.close()

    def get(self, path: str, **query: Any) -> Json:
        """Anything the service has, by its path, such as a link of an answer."""
        return run(self._calls.get(path, **query))

    def design(self, spec: Spec) -> Json:
        """The cam for a DesignSpec."""
        return run(self._calls.design(spec))

    def analyse(self, spec: Spec) -> Json:
        """What a cam does that is given in full."""
        return run(self._calls.analyse(spec))

    def read_back(self, measured: Spec) -> Json:
        """The motion, from measured points of a profile."""
        return run(self._calls.read_back(measured))

    def cam_set(self, spec: Spec) -> Json:
        """The cams of one shaft."""
        return run(self._calls.cam_set(spec))

    def spatial_cam(self, spec: Spec) -> Json:
        """The spatial cam for a SpatialCamSpec."""
        return run(self._calls.spatial_cam(spec))

    def linkage(self, kind: str, spec: Spec) -> Json:
        """A linkage of a kind, such as ``six-bar-shapers``."""
        return run(self._calls.linkage(kind, spec))

    def train_response(self, spec: Spec) -> Json:
        """What a TrainSpec's follower train does on its cam."""
        return run(self._calls.train_response(spec))

    def sweep(self, spec: Spec) -> Json:
        """Start a sweep, or join it where it is under way; as it stands."""
        return run(self._calls.sweep(spec))

    def watch(self, sweep: str, *, after: str = "", items: bool = True) -> Iterator[Event]:
        """Every event of a sweep up to its end, across lost connections."""
        return _each(lambda: self._calls.watch(sweep, after=after, items=items))

    def wait(self, sweep: str) -> Json:
        """The sweep when it is over."""
        return run(self._calls.wait(sweep))

    def items(self, sweep: str, *, status: str | None = None) -> Iterator[Json]:
        """Every item that is finished by now, in the order in which they were finished."""
        return _each(lambda: self._calls.items(sweep, status=status))

    def pareto(
        self, sweep: str, *, minimise: Sequence[str] = (), maximise: Sequence[str] = ()
    ) -> Json:
        """What no other design of the sweep beats in all of these quantities."""
        return run(self._calls.pareto(sweep, minimise=minimise, maximise=maximise))

    def dismiss(self, sweep: str) -> Json:
        """Stop a sweep and keep what is done; one that is over stays as it is."""
        return run(self._calls.dismiss(sweep))

    def delete(self, path: str) -> None:
        """Forget something, by its path; a sweep that is under way is stopped first."""
        run(self._calls.delete(path))

    def download(self, path: str, target: Path, *, told: Told | None = None, **query: Any) -> Path:
        """A file, such as ``/v1/designs/ID/profile.csv``; goes on where an earlier call broke."""
        return run(self._calls.download(path, target, told=told, **query))


def _each(flow: Callable[[], AsyncGenerator[T, None]]) -> Iterator[T]:
    """An asynchronous iterator over a waiting wire, waited for."""
    flowing = flow()
    try:
        while True:
            try:
                found = run(flowing.__anext__())
            except StopAsyncIteration:
                return
            yield found
    finally:
        run(flowing.aclose())
