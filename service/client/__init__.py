"""A client of the service, for programs: `Client` blocks, `AsyncClient` is for asyncio.

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
from service.client.download import ProgressCallback
from service.client.errors import ClientError, Refused, Unreachable
from service.client.events import Event
from service.client.retries import Retries
from service.client.transport import AsyncTransport, BlockingTransport, run

__all__ = [
    "AsyncClient", "Client", "ClientError", "Event", "Refused", "Retries", "Unreachable",
]  # fmt: skip
T = TypeVar("T")
ADDRESS = "http://127.0.0.1:8000"
SILENCE_S = 60.0  # without a byte, after which a connection counts as lost


class AsyncClient(Calls):
    """The calls of `Calls`, as coroutines.

    Args:
        url: address of the service. retries: how often and how long to try.
        timeout_s: without a byte, after which the connection counts as lost.
        more: for httpx2.AsyncClient, such as ``headers``, ``verify`` or ``proxy``.
    """

    def __init__(
        self,
        url: str = ADDRESS,
        *,
        retries: Retries = Retries(),  # noqa: B008 (frozen)
        timeout_s: float = SILENCE_S,
        **more: Any,
    ) -> None:
        self._http = httpx2.AsyncClient(base_url=url, timeout=timeout_s, **more)
        super().__init__(AsyncTransport(self._http), retries)

    async def __aenter__(self) -> Self:
        return self

    async def __aexit__(self, *_: object) -> None:
        await self.close()

    async def close(self) -> None:
        """Close its connections."""
        await self._http.aclose()


class Client:
    """The calls of `Calls`, blocking.

    Args:
        url: address of the service. retries: how often and how long to try.
        timeout_s: without a byte, after which the connection counts as lost.
        more: for httpx2.Client, such as ``headers``, ``verify`` or ``proxy``.
    """

    def __init__(
        self,
        url: str = ADDRESS,
        *,
        retries: Retries = Retries(),  # noqa: B008 (frozen)
        timeout_s: float = SILENCE_S,
        **more: Any,
    ) -> None:
        self._http = httpx2.Client(base_url=url, timeout=timeout_s, **more)
        self._calls = Calls(BlockingTransport(self._http), retries)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Close its connections."""
        self._http.close()

    def get(self, path: str, **query: Any) -> Json:
        """Any JSON document of the service, by its path, such as a link of an answer."""
        return run(self._calls.get(path, **query))

    def design(self, spec: Spec) -> Json:
        """The cam for a DesignSpec."""
        return run(self._calls.design(spec))

    def analyse(self, spec: Spec) -> Json:
        """The analysis of a given cam."""
        return run(self._calls.analyse(spec))

    def read_back(self, measured: Spec) -> Json:
        """The motion that measured points of a profile give."""
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
        """The response of a follower train to its cam."""
        return run(self._calls.train_response(spec))

    def sweep(self, spec: Spec) -> Json:
        """Start a sweep, or join it where it is running; its current state."""
        return run(self._calls.sweep(spec))

    def watch(self, sweep: str, *, after: str = "", items: bool = True) -> Iterator[Event]:
        """All events of a sweep, continued after lost connections."""
        return _each(lambda: self._calls.watch(sweep, after=after, items=items))

    def wait(self, sweep: str) -> Json:
        """The sweep when it has ended."""
        return run(self._calls.wait(sweep))

    def items(self, sweep: str, *, status: str | None = None) -> Iterator[Json]:
        """All items finished by now, in the order in which they were finished."""
        return _each(lambda: self._calls.items(sweep, status=status))

    def pareto(
        self, sweep: str, *, minimise: Sequence[str] = (), maximise: Sequence[str] = ()
    ) -> Json:
        """The Pareto front of a sweep in these quantities."""
        return run(self._calls.pareto(sweep, minimise=minimise, maximise=maximise))

    def dismiss(self, sweep: str) -> Json:
        """Stop a sweep and keep what is done; one that has ended stays as it is."""
        return run(self._calls.dismiss(sweep))

    def delete(self, path: str) -> None:
        """Delete an answer or a sweep, by its path; a running sweep is stopped first."""
        run(self._calls.delete(path))

    def download(
        self, path: str, target: Path, *, progress: ProgressCallback | None = None, **query: Any
    ) -> Path:
        """A file, such as ``/v1/designs/ID/profile.csv``; continues an interrupted download."""
        return run(self._calls.download(path, target, progress=progress, **query))


def _each(flow: Callable[[], AsyncGenerator[T, None]]) -> Iterator[T]:
    """A blocking iterator over an asynchronous one on a blocking transport."""
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
