"""The worker processes of our own engine, and who replaces them."""

from __future__ import annotations

import asyncio
import signal
from typing import Any

from distributed import LocalCluster, Nanny, Status

GONE = (Status.closed, Status.failed)
DIED = "died"
TOLD_S = 1.0  # until a keeper has heard of its worker's end, at the longest


class Keeper(Nanny):
    """Remembers how its worker ended."""

    ended: str | None = None

    def _on_worker_exit_sync(self, exitcode: int) -> None:
        self.ended = _in_words(exitcode)
        super()._on_worker_exit_sync(exitcode)  # type: ignore[no-untyped-call]


def _in_words(exitcode: int) -> str:
    if exitcode >= 0:
        return f"ended by itself with status {exitcode}"
    known = {each.value for each in signal.Signals}
    name = f" ({signal.Signals(-exitcode).name})" if -exitcode in known else ""
    return f"was ended by signal {-exitcode}{name}"


class OwnCluster(LocalCluster):
    """A local cluster in which only the keepers of the workers bring them back.

    Each worker process has a keeper (Dask's nanny) that starts it anew when it dies. Dask's cluster
    gives a keeper up as well, a fixed time after any death of its worker, if the worker happens to
    be away at that moment: on a busy machine that meets a later restart half-way, and then two
    keepers start a worker of the same name and one of them is turned away. Here a keeper is
    replaced when it has ended, and not before.
    """

    async def within(self) -> str:
        """An address of its scheduler for this process: messages to it pass through no socket.

        Those between workers and scheduler do; of the time that a task takes besides its work, the
        client's four were a third.
        """
        scheduler: Any = self.scheduler
        await scheduler.listen("inproc://")
        return str(scheduler.listeners[-1].contact_address)

    def _update_worker_status(self, op: str, msg: Any) -> None:
        """Note who is there. One that is unknown may leave: an error would end the watch."""
        workers = self.scheduler_info["workers"]
        if op == "remove":
            workers.pop(msg, None)
        else:
            workers.update(msg["workers"])

    def replace_the_lost(self) -> None:
        """Start a new keeper, and so a worker, for each that has ended; return at once."""
        lost = [name for name, keeper in self.workers.items() if keeper.status in GONE]
        for name in lost:
            del self.workers[name]
        if lost:
            scale: Any = self.scale
            scale(len(self.worker_spec))

    async def how_it_ended(self, name: Any) -> str:
        """What ended the worker of this name, in words."""
        keeper: Any = self.workers.get(name)
        for _ in range(10):
            if keeper is None or keeper.ended is not None:
                break
            await asyncio.sleep(0.1 * TOLD_S)
        if keeper is None or keeper.ended is None:
            return DIED
        told, keeper.ended = keeper.ended, None
        return str(told)
