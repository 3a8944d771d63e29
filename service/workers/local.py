"""Worker processes of the service's own, each at the end of a pair of sockets and of a pipe.

None of them opens a port. The event loop sends a task by the sockets and waits for its answer; the
main thread of the worker runs it. By the pipe the service says what is to be cancelled, which a
second thread there reads. When the pipe ends the service has: so has the worker then. A worker that
ends, for whatever reason, is replaced.
"""

from __future__ import annotations

import asyncio
import contextlib
import logging
import multiprocessing
import os
import pickle
import signal
import socket
import struct
import sys
import traceback
from asyncio import StreamReader, StreamWriter
from collections.abc import AsyncIterator, Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import asynccontextmanager
from functools import partial
from multiprocessing.connection import Connection, wait
from threading import Event, Thread
from typing import Any, TypeVar

import cloudpickle

from service.wire.errors import ProblemType
from service.wire.logs import configure_logs
from service.workers import prefork
from service.workers.memory import SPENT, limit_memory, needed_more, share_of_memory
from synthesis.numerics import clock

log = logging.getLogger("camwright.engine")
T = TypeVar("T")
RETRY = {"Retry-After": "2"}  # [s]: by then a lost worker has been replaced
ANEW_S = 1.0  # after a worker that ended before it was ready
LENGTH = struct.Struct("!Q")  # of a message, which stands before it [bytes]
UNKNOWN = 255  # what multiprocessing says where nobody saw how a process ended


class Worker:
    """A worker process, as the service sees it.

    ``ended`` tells how it ended, in words; "" where that has nothing to do with its task.
    """

    def __init__(
        self, process: Any, answers: StreamReader, tasks: StreamWriter, cancelled: Connection
    ) -> None:
        self.process, self._cancelled = process, cancelled
        self._answers, self._tasks = answers, tasks
        self.ended: asyncio.Future[str] = asyncio.get_running_loop().create_future()
        self.reason: str | None = None  # why it was killed

    def kill(self, reason: str = "") -> None:
        """End it at once."""
        self.reason = reason
        # Not `process.kill`: where the process that forks has died, that takes this one for dead.
        with contextlib.suppress(ProcessLookupError):
            os.kill(self.process.pid, signal.SIGKILL if prefork.FORKED else signal.SIGTERM)

    def cancel(self, key: str) -> None:
        """Ask it to end a task."""
        with contextlib.suppress(OSError):  # it has ended
            self._cancelled.send_bytes(key.encode())

    async def exchange(self, message: bytes) -> bytes | None:
        """Send a task and wait for the answer; None where it ended before it began."""
        try:
            self._tasks.writelines([LENGTH.pack(len(message)), message])
            await self.receive()  # it has begun
        except (EOFError, OSError):
            return None
        return await self.receive()

    async def receive(self) -> bytes:
        """Wait for what it says. EOFError or OSError where it ends before."""
        (length,) = LENGTH.unpack(await self._answers.readexactly(LENGTH.size))
        return await self._answers.readexactly(length)

    def close(self) -> None:
        """Close what leads to it: it has ended."""
        self._tasks.close()
        self._cancelled.close()


class LocalWorkers:
    """A fixed number of worker processes, each replaced when it ends.

    ``memory``: that each may have [bytes]; 0: its share of the machine's.
    """

    def __init__(self, slots: int, prepare: Callable[[], None], memory: int) -> None:
        self.slots, self._prepare = slots, prepare
        self._method: Any = multiprocessing.get_context(prefork.METHOD)
        self._ready: set[Worker] = set()
        # The last one that worked is next: what a design needs is in its processor's caches still.
        self._idle: asyncio.LifoQueue[Worker] = asyncio.LifoQueue()
        self._busy: dict[str, Worker] = {}
        self.all_ready = asyncio.Event()
        # A thread waits for each worker to end. One alone starts them and reads how they ended:
        # multiprocessing looks at all its children at each start.
        self._threads = ThreadPoolExecutor(slots, "workers")
        self._starting = ThreadPoolExecutor(1, "starting")
        self._memory = memory or share_of_memory(slots)

    async def run(self, key: str, work: Callable[..., T], *arguments: Any) -> T:
        message = dumps((key, partial(work, *arguments)))
        while True:
            worker = await self._idle.get()
            if worker.ended.done():
                continue
            self._busy[key] = worker
            try:
                reply = await worker.exchange(message)
            except (OSError, EOFError):
                reply, reason = None, await worker.ended
                if reason:
                    raise ProblemType.WORKER_LOST(
                        f"The process working on this design {reason}. Other work goes on. "
                        "Try again, or ask for a simpler design.",
                        RETRY,
                    ) from None
            finally:
                del self._busy[key]
            if reply is None:  # it had no part in that: another worker does it
                continue
            self._idle.put_nowait(worker)
            succeeded, result = pickle.loads(reply)
            if succeeded:
                return result  # type: ignore[no-any-return]
            raise result

    async def has_begun(self, key: str) -> bool:
        return key in self._busy

    async def cancel(self, keys: Sequence[str]) -> None:
        for key in keys:
            worker = self._busy.get(key)
            if worker is not None:
                worker.cancel(key)

    async def stop(self, key: str) -> None:
        worker = self._busy.get(key)
        if worker is not None:
            worker.kill("was stopped")
            await worker.ended

    async def count(self) -> int:
        return len(self._ready)

    async def keep(self) -> None:
        """Have one worker, and another one whenever it has ended."""
        loop = asyncio.get_running_loop()
        while True:
            try:
                worker = await self._start_worker()
            except (OSError, EOFError):  # what forks has died at it: the next start brings another
                await asyncio.sleep(ANEW_S)
                continue
            ended = loop.run_in_executor(self._threads, wait, [worker.process.sentinel])
            try:
                if await self._answers(worker):
                    self._ready.add(worker)
                    if len(self._ready) == self.slots:
                        self.all_ready.set()
                    self._idle.put_nowait(worker)
                await asyncio.shield(ended)
            finally:
                self._ready.discard(worker)
                if not ended.done():
                    worker.kill()
                    await asyncio.wait({ended})
                code = await loop.run_in_executor(self._starting, exit_code, worker.process)
                if code == UNKNOWN:  # the process that forks has died, and this one may live
                    worker.kill()
                reason = needed_more(self._memory) if code == SPENT else reason_of(code)
                worker.close()
                worker.ended.set_result(reason if worker.reason is None else worker.reason)

    async def _start_worker(self) -> Worker:
        tasks, its_tasks = socket.socketpair()
        its_cancelled, cancelled = multiprocessing.Pipe(duplex=False)
        process = self._method.Process(
            target=serve, args=(its_tasks, its_cancelled, self._prepare, self._memory), daemon=True
        )
        starting = asyncio.get_running_loop().run_in_executor(self._starting, process.start)
        starting.add_done_callback(lambda _: its_tasks.close())
        starting.add_done_callback(lambda _: its_cancelled.close())
        try:
            await asyncio.shield(starting)
        except BaseException:
            tasks.close()
            cancelled.close()
            raise
        return Worker(process, *await asyncio.open_connection(sock=tasks), cancelled)

    async def _answers(self, worker: Worker) -> bool:
        """Whether a new worker becomes ready for work."""
        try:
            await worker.receive()
        except (OSError, EOFError):
            log.error("a worker ended before it was ready")
            await asyncio.sleep(ANEW_S)
            return False
        return True

    def close(self) -> None:
        """Let the threads go: the workers have ended."""
        for threads in (self._threads, self._starting):
            threads.shutdown()


@asynccontextmanager
async def local_workers(
    slots: int, prepare: Callable[[], None], memory: int = 0
) -> AsyncIterator[LocalWorkers]:
    """Worker processes for as long as they are wanted; they are all ready."""
    prefork.start_fork_server()
    workers = LocalWorkers(slots, prepare, memory)
    tasks = [asyncio.create_task(workers.keep()) for _ in range(slots)]
    try:
        await workers.all_ready.wait()
        yield workers
    finally:
        for task in tasks:
            task.cancel()
        await asyncio.gather(*tasks, return_exceptions=True)
        workers.close()


def dumps(value: Any) -> bytes:
    """As pickle does; by value what has no name in a module, such as the writers of files."""
    try:
        return pickle.dumps(value)
    except (AttributeError, TypeError, pickle.PicklingError):
        return bytes(cloudpickle.dumps(value))


def exit_code(process: Any) -> int:
    """How a process has ended: its status, or minus the number of the signal."""
    process.join()
    return int(process.exitcode)


def reason_of(code: int) -> str:
    """How a process has ended, in words."""
    if code >= 0:
        return f"ended by itself with status {code}"
    known = {each.value: f" ({each.name})" for each in signal.Signals}
    return f"was ended by signal {-code}{known.get(-code, '')}, perhaps for lack of memory"


# -- in the worker process ---------------------------------------------------------------------


def serve(
    tasks: socket.socket, cancelled: Connection, prepare: Callable[[], None], memory: int
) -> None:
    """Run tasks from a socket until it ends, in so much memory [bytes]; see ``_listen``."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C reaches it, but the service stops it
    configure_logs("warning")
    events: dict[str, Event] = {}
    Thread(target=_listen, args=(cancelled, events), daemon=True).start()
    try:
        prepare()
    except Exception:  # the worker itself works; the first design will show what is wrong
        log.exception("warm-up failed")
    limit_memory(memory)
    reply = b""  # it is ready
    with contextlib.suppress(OSError), tasks.makefile("rwb") as stream:  # the service has ended
        while True:
            _send(stream, reply)
            if len(head := stream.read(LENGTH.size)) < LENGTH.size:
                break
            message = stream.read(*LENGTH.unpack(head))
            _send(stream, b"")  # it begins
            reply = _reply(message, events)


def _send(stream: Any, message: bytes) -> None:
    stream.write(LENGTH.pack(len(message)))
    stream.write(message)
    stream.flush()


def _listen(cancelled: Connection, events: dict[str, Event]) -> None:
    """Cancel tasks, also one that is about to begin; at the end of the pipe the process ends."""
    with contextlib.suppress(EOFError, OSError):
        while True:
            events.setdefault(cancelled.recv_bytes().decode(), Event()).set()
    os._exit(0)


def _reply(message: bytes, events: dict[str, Event]) -> bytes:
    try:
        key, work = pickle.loads(message)
    except BaseException:  # a task that cannot be read: it is lost with its worker
        traceback.print_exc(file=sys.stderr)
        os._exit(1)
    try:
        with clock.cancellation_scope(events.setdefault(key, Event())):
            return reply_of(work)
    finally:
        events.clear()  # what was cancelled too late too: tasks come one at a time


def reply_of(work: Callable[[], Any]) -> bytes:
    """Run a task; whether it succeeded, and its result or the exception.

    The process ends where it takes too much memory: whatever it holds still, it is replaced.
    """
    try:
        return dumps((True, work()))
    except MemoryError:
        os._exit(SPENT)
    except Exception as error:
        error.add_note(traceback.format_exc())  # the traceback itself stays here
        try:
            reply = dumps((False, error))
            pickle.loads(reply)
        except Exception:
            text = "".join(traceback.format_exception(error))
            return dumps((False, RuntimeError(text)))
        return reply
