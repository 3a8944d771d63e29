"""Processes that read long bodies, so that the event loop answers others meanwhile.

A spec of many segments takes longer to check than to write: 1 MiB may take seconds. A thread would
hold the interpreter's lock for most of that time; a process that takes too long can be killed.
"""

from __future__ import annotations

import asyncio
import multiprocessing
import signal
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from threading import local
from typing import Any, TypeVar

from service.settings import Settings
from service.wire.errors import ProblemType
from service.wire.fair_queue import FairQueue
from service.workers import prefork

T = TypeVar("T")
ENDED = getattr(signal, "SIGPROF", 0)  # by this signal the kernel ends a reader that takes too long
TIMED = hasattr(signal, "setitimer")
PATIENCE = 6.0  # times its limit of processor time that a reader may take on a busy machine
AGAIN = {"Retry-After": "2"}  # [s]: by then others have been read


class Readers:
    """Some processes, each started when it is first needed, with a thread that waits for it."""

    def __init__(self, settings: Settings) -> None:
        self._limit_s = settings.reading_s
        self._queue = FairQueue(lambda: settings.readers, settings.max_waiting, "long bodies")
        self._threads = ThreadPoolExecutor(settings.readers, "reader")
        self._own = local()  # of each thread: its process and the pipe to it
        self._processes: set[Any] = set()

    async def run(self, work: Callable[..., T], *arguments: Any) -> T:
        """What a function makes of its arguments in another process; ServiceError on limits.

        Args:
            work: a function that a process can import.
        """
        with self._queue.room():
            loop, asked = asyncio.get_running_loop(), (work, arguments)
        async with self._queue.turn():
            succeeded, answer = await loop.run_in_executor(self._threads, self._exchange, asked)
        if not succeeded:
            raise answer
        made: T = answer
        return made

    def _exchange(self, message: Any) -> tuple[bool, Any]:
        """Whether the process succeeded, and the value or the exception that came of it."""
        if getattr(self._own, "child", None) is None:
            self._own.child = self._start()
        process, pipe = self._own.child
        try:
            pipe.send(message)
            if pipe.poll(PATIENCE * self._limit_s):
                answer: tuple[bool, Any] = pipe.recv()
                return answer
            process.kill()
            too_long = (
                not TIMED
            )  # where the kernel measures, the machine was busy with other things
        except (EOFError, OSError):
            process.join()
            too_long = process.exitcode == -ENDED
        self._own.child = None
        process.kill()
        process.join()
        self._processes.discard(process)
        if too_long:
            return False, ProblemType.BODY_TOO_LARGE(
                f"The body takes more than {self._limit_s:g} s of processor time to read, the "
                "limit of this server. Send less at once: fewer segments, windows, cams or values."
            )
        return False, ProblemType.WORKER_LOST(
            "The process that read the body died, perhaps for lack of memory, or had no time on a "
            "busy machine. Send it again, or less at once.",
            AGAIN,
        )

    def _start(self) -> tuple[Any, Any]:
        prefork.start_fork_server()  # it runs already where workers are the service's own
        context: Any = multiprocessing.get_context(prefork.METHOD)
        pipe, far = context.Pipe()
        process = context.Process(
            target=serve, args=(far, self._limit_s), name="reader", daemon=True
        )
        process.start()
        far.close()
        self._processes.add(process)
        pipe.recv()  # it is there: time counts from here on
        return process, pipe

    def close(self) -> None:
        """End the processes; nobody waits for them any more."""
        for process in list(self._processes):
            process.kill()
        self._threads.shutdown()


def serve(pipe: Any, limit_s: float) -> None:
    """Say that it is there, and do what comes through a pipe, until its other end is closed.

    The kernel ends the process where something takes more than ``limit_s`` of processor time [s]:
    on a busy machine the clock on the wall would refuse what is sensible.
    """
    pipe.send(None)
    while True:
        try:
            work, arguments = pipe.recv()
        except (EOFError, OSError):
            return
        if TIMED:
            signal.setitimer(signal.ITIMER_PROF, limit_s)
        try:
            answer = True, work(*arguments)
        except Exception as error:  # it belongs to the caller
            answer = False, error
        if TIMED:
            signal.setitimer(signal.ITIMER_PROF, 0.0)
        pipe.send(answer)
