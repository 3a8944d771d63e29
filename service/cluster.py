"""The worker processes of our own engine, and who replaces them."""

from __future__ import annotations

from typing import Any

from distributed import LocalCluster, Status

GONE = (Status.closed, Status.failed)


class OwnCluster(LocalCluster):
    """A local cluster in which only the keepers of the workers bring them back.

    Each worker process has a keeper (Dask's nanny) that starts it anew when it dies. Dask's cluster
    gives a keeper up as well, a fixed time after any death of its worker, if the worker happens to
    be away at that moment: on a busy machine that meets a later restart half-way, and then two
    keepers start a worker of the same name and one of them is turned away. Here a keeper is
    replaced when it has ended, and not before.
    """

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
