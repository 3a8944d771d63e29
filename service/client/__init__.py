"""A client of the service, for programs: `Client` blocks, `AsyncClient` is for asyncio.

    with Client("http://127.0.0.1:8000") as client:
        design = client.design(spec)
        client.download(design["links"]["profile.csv"], Path("profile.csv"))

Both have the same calls, of `AsyncClient` as coroutines and asynchronous iterators; a sweep of
`Client` can be waited for and read as a table (`sweeps`). `exchange`
sends requests again where that is safe, and continues downloads. Begin with `calls.py`.
"""

from __future__ import annotations

import asyncio
import threading
from collections.abc import AsyncGenerator, Callable, Coroutine, Iterator
from functools import wraps
from typing import Any, Concatenate, ParamSpec, Self, TypeVar

from service.client.calls import ADDRESS, SILENCE_S, AsyncClient, Event, Spec
from service.client.exchange import ClientError, Refused, Retries, Unreachable
from service.client.sweeps import Sweep

__all__ = [
    "AsyncClient", "Client", "ClientError", "Event", "Refused", "Retries", "Sweep", "Unreachable",
]  # fmt: skip
P = ParamSpec("P")
T = TypeVar("T")


def _as_blocking(
    call: Callable[Concatenate[AsyncClient, P], Coroutine[Any, Any, T]],
) -> Callable[Concatenate[Client, P], T]:
    """A call of `AsyncClient` as one of `Client`."""

    @wraps(call)
    def blocking(self: Client, /, *args: P.args, **kwargs: P.kwargs) -> T:
        return self._run(call(self._client, *args, **kwargs))

    return blocking


def _as_iterator(
    call: Callable[Concatenate[AsyncClient, P], AsyncGenerator[T, None]],
) -> Callable[Concatenate[Client, P], Iterator[T]]:
    """An asynchronous iterator of `AsyncClient` as an iterator of `Client`; no item is None."""

    @wraps(call)
    def iterating(self: Client, /, *args: P.args, **kwargs: P.kwargs) -> Iterator[T]:
        items = call(self._client, *args, **kwargs)

        async def next_item() -> T | None:
            return await anext(items, None)

        try:
            while (item := self._run(next_item())) is not None:
                yield item
        finally:
            self._run(items.aclose())

    return iterating


class Client:
    """The calls of `AsyncClient`, blocking. They run in an event loop in a thread of its own.

    Args:
        url, retries, timeout_s, key, more: as of `AsyncClient`.
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
        self._client = AsyncClient(url, retries=retries, timeout_s=timeout_s, key=key, **more)
        self._loop = asyncio.new_event_loop()
        self._thread = threading.Thread(target=self._loop.run_forever, daemon=True)
        self._thread.start()

    def _run(self, coroutine: Coroutine[Any, Any, T]) -> T:
        """The result of a coroutine; where the caller is interrupted, it is cancelled."""
        future = asyncio.run_coroutine_threadsafe(coroutine, self._loop)
        try:
            return future.result()
        finally:
            future.cancel()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Close its connections."""
        if self._loop.is_closed():
            return
        self._run(self._client.close())
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join()
        self._loop.close()

    def sweep(self, spec: Spec) -> Sweep:
        """Start a sweep, or join it where it is running."""
        return Sweep(self, self._run(self._client.sweep(spec)))

    get = _as_blocking(AsyncClient.get)
    answer = _as_blocking(AsyncClient.answer)
    design = _as_blocking(AsyncClient.design)
    analyse = _as_blocking(AsyncClient.analyse)
    read_back = _as_blocking(AsyncClient.read_back)
    cam_set = _as_blocking(AsyncClient.cam_set)
    spatial_cam = _as_blocking(AsyncClient.spatial_cam)
    linkage = _as_blocking(AsyncClient.linkage)
    train_response = _as_blocking(AsyncClient.train_response)
    watch = _as_iterator(AsyncClient.watch)
    wait = _as_blocking(AsyncClient.wait)
    items = _as_iterator(AsyncClient.items)
    pareto = _as_blocking(AsyncClient.pareto)
    dismiss = _as_blocking(AsyncClient.dismiss)
    delete = _as_blocking(AsyncClient.delete)
    download = _as_blocking(AsyncClient.download)
