"""Processes that do short work beside the event loop: they read long bodies, and make files.

A spec of many segments takes longer to check than to write: 1 MiB may take seconds; a file of many
points likewise. A thread would hold the interpreter's lock for most of that time, and nothing could
end it; a process has a limit of time and one of memory.
"""

from __future__ import annotations

import asyncio
import multiprocessing
import pickle
import signal
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from threading import local
from typing import Any, TypeVar

from service.settings import Settings
from service.wire.errors import ProblemType
from service.wire.fair_queue import FairQueue
from service.workers import prefork
from service.workers.local import dumps, reply_of
from service.workers.memory import MIB, SPENT, limit_memory, needed_more
from synthesis.errors import TimeBudgetExceeded

T = TypeVar("T")
ENDED = getattr(signal, "SIGPROF", 0)  # by this signal the kernel ends one that takes too long
TIMED = hasattr(signal, "setitimer")
PATIENCE = 6.0  # times its limit of processor time that one may take on a busy machine
AGAIN = {"Retry-After": "2"}  # [s]: by then others have been served
# Of each: a body of 1 MiB takes 60 MiB to read, an archive of 50 cams some 300 MiB to make.
MEMORY = 768 * MIB


class SideProcesses:
    """Some processes, each started when it is first needed, with a thread that waits for it.

    Args:
        slots: how many. most: works that may wait. limit_s: of processor time [s] for each.
        what: they are, in the plural. too_long: the error where one takes more time.
        memory: that each process may have [bytes].
    """

    def __init__(
        self, slots: int, most: int, limit_s: float, what: str, too_long: Callable[[], Exception],
        memory: int = MEMORY,
    ) -> None:  # fmt: skip
        self._limit_s, self._too_long, self._memory = limit_s, too_long, memory
        self._queue = FairQueue(lambda: slots, most, what)
        self._threads = ThreadPoolExecutor(slots, "helper")
        self._own = local()  # of each thread: its process and the pipe to it
        self._processes: set[Any] = set()

    async def run(self, work: Callable[..., T], *arguments: Any) -> T:
        """What a function makes of its arguments in another process; ServiceError on limits."""
        turn = await self._queue.acquire(limited=True)
        loop, message = asyncio.get_running_loop(), dumps(partial(work, *arguments))
        answer = loop.run_in_executor(self._threads, self._exchange, message)
        # Where nobody waits any more, its process is busy nevertheless.
        answer.add_done_callback(lambda _: self._queue.release(turn))
        succeeded, made = await asyncio.shield(answer)
        if not succeeded:
            raise made
        result: T = made
        return result

    def _exchange(self, message: bytes) -> tuple[bool, Any]:
        """Whether the process succeeded, and the value or the exception that came of it."""
        if getattr(self._own, "child", None) is None:
            self._own.child = self._start()
        process, pipe = self._own.child
        ended = None
        try:
            pipe.send_bytes(message)
            if pipe.poll(PATIENCE * self._limit_s):
                answer: tuple[bool, Any] = pickle.loads(pipe.recv_bytes())
                return answer
        except (EOFError, OSError):
            process.join()
            ended = process.exitcode
        self._own.child = None
        process.kill()
        process.join()
        self._processes.discard(process)
        # Where the kernel measures, the machine was busy with other things if the clock was first.
        if ended == -ENDED or (ended is None and not TIMED):
            return False, self._too_long()
        reason = needed_more(self._memory) if ended == SPENT else "died, or had no time"
        return False, ProblemType.WORKER_LOST(
            f"The process that worked on this request {reason}. Send it again, or ask for less at "
            "once.", AGAIN,
        )  # fmt: skip

    def _start(self) -> tuple[Any, Any]:
        prefork.start_fork_server()  # it runs already where workers are the service's own
        context: Any = multiprocessing.get_context(prefork.METHOD)
        pipe, far = context.Pipe()
        process = context.Process(
            target=serve, args=(far, self._limit_s, self._memory), name="helper", daemon=True
        )
        process.start()
        far.close()
        self._processes.add(process)
        pipe.recv_bytes()  # it is there: time counts from here on
        return process, pipe

    def close(self) -> None:
        """End the processes; nobody waits for them any more."""
        for process in list(self._processes):
            process.kill()
        self._threads.shutdown()


def readers_of(settings: Settings) -> SideProcesses:
    """Processes that read long bodies."""
    limit_s = settings.reading_s

    def too_long() -> Exception:
        return ProblemType.BODY_TOO_LARGE(
            f"The body takes more than {limit_s:g} s of processor time to read, the "
            "limit of this server. Send less at once: fewer segments, windows, cams or values."
        )

    return SideProcesses(settings.readers, settings.max_waiting, limit_s, "long bodies", too_long)


def writers_of(settings: Settings) -> SideProcesses:
    """Processes that make files, as many as read bodies."""
    limit_s = settings.budget_s(None)
    too_long = partial(TimeBudgetExceeded, limit_s)
    return SideProcesses(settings.readers, settings.max_waiting, limit_s, "files", too_long)


def serve(pipe: Any, limit_s: float, memory: int) -> None:
    """Say that it is there, and do what comes through a pipe, until its other end is closed.

    The kernel ends the process where something takes more than ``limit_s`` of processor time [s]:
    on a busy machine the clock on the wall would refuse what is sensible.
    """
    limit_memory(memory)
    pipe.send_bytes(b"")
    while True:
        try:
            message = pipe.recv_bytes()
        except (EOFError, OSError):
            return
        if TIMED:
            signal.setitimer(signal.ITIMER_PROF, limit_s)
        answer = reply_of(partial(_run, message))
        if TIMED:
            signal.setitimer(signal.ITIMER_PROF, 0.0)
        pipe.send_bytes(answer)


def _run(message: bytes) -> Any:
    return pickle.loads(message)()
