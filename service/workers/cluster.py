"""The worker processes of the service's own engine, and what replaces them when they die."""

from __future__ import annotations

import asyncio
import signal
from typing import Any

from distributed import LocalCluster, Nanny, Status

ENDED = (Status.closed, Status.failed)
DIED = "died"
EXIT_REPORT_S = 1.0  # at most, until a nanny knows how its worker ended


class WorkerNanny(Nanny):
    """Remembers how its worker ended."""

    exit_reason: str | None = None

    def _on_worker_exit_sync(self, exitcode: int) -> None:
        self.exit_reason = f"ended by itself with status {exitcode}"
        if exitcode < 0:
            known = {each.value: f" ({each.name})" for each in signal.Signals}
            self.exit_reason = f"was ended by signal {-exitcode}{known.get(-exitcode, '')}"
        super()._on_worker_exit_sync(exitcode)  # type: ignore[no-untyped-call]


class OwnCluster(LocalCluster):
    """A local cluster that replaces a nanny only after the nanny has ended.

    Each worker process has a nanny (Dask's) that starts it anew when it dies. Dask's cluster also
    gives a nanny up, a fixed time after any death of its worker, if the worker is away at that
    moment. On a busy machine this coincides with a later restart; two nannies then start a worker
    of the same name, and one of them is turned away.
    """

    async def in_process_address(self) -> str:
        """An address of the scheduler for this process: messages to it pass no socket.

        Of the time that a task takes besides its work, the client's four messages were a third.
        """
        scheduler: Any = self.scheduler
        await scheduler.listen("inproc://")
        return str(scheduler.listeners[-1].contact_address)

    def _update_worker_status(self, op: str, msg: Any) -> None:
        """Update the table of workers. An unknown one may leave: an error would end the watch."""
        workers = self.scheduler_info["workers"]
        if op == "remove":
            workers.pop(msg, None)
        else:
            workers.update(msg["workers"])

    def replace_lost_workers(self) -> None:
        """Start a new nanny, and so a worker, for each that has ended; return at once."""
        lost = [name for name, nanny in self.workers.items() if nanny.status in ENDED]
        for name in lost:
            del self.workers[name]
        if lost:
            scale: Any = self.scale
            scale(len(self.worker_spec))

    async def exit_reason(self, name: Any) -> str:
        """What ended the worker of this name, in words."""
        nanny: Any = self.workers.get(name)
        for _ in range(10):
            if nanny is None or nanny.exit_reason is not None:
                break
            await asyncio.sleep(0.1 * EXIT_REPORT_S)
        if nanny is None or nanny.exit_reason is None:
            return DIED
        reason, nanny.exit_reason = nanny.exit_reason, None
        return str(reason)
