"""Turns at what many share: workers, readers, files, the store, the event loop.

Start-time fair queueing (Goyal, Vin, Cheng: IEEE/ACM Transactions on Networking 5(5), 1997, pages
690-704) by who asks. Each has a start tag, the time [s] that he has been served, on a common scale.
Whoever has the least is served next; his tag then grows by what that costs. The virtual time is the
tag of whoever was served last, and who comes anew begins there: he owes nothing and is owed
nothing. So all who wait have tags from there on, and before a newcomer's first work each of them
has at most one of theirs begun: that one takes its owner's tag beyond the newcomer's.
"""

from __future__ import annotations

import asyncio
import contextlib
import math
import time
from bisect import insort
from collections import deque
from collections.abc import AsyncIterator, Callable, Iterator
from contextlib import asynccontextmanager, contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, field
from ipaddress import ip_network

from starlette.types import ASGIApp, Receive, Scope, Send

from service.wire.errors import ProblemType

# For whom the work at hand is done: the owner of a key, or an address; "": the service itself.
# Tasks inherit it from whoever makes them, so that it need not pass through every call.
current_owner: ContextVar[str] = ContextVar("current_owner", default="")
UNMEASURED_S = 0.1  # cost of a work until one was measured: of the order of a usual design [s]
NEWEST = 0.2  # weight of the last work in the average of costs: about the last ten count
# Works over which the pace is averaged at which places get free: about as many as wait, so that the
# past that is looked at is as long as the wait that is told.
PACED = 64
# How long a place is kept for what was told to come back [s]: clients wait a little longer rather
# than less, and a busy machine takes seconds to read what they send. No slot is kept for anybody.
KEPT_S = 10.0
MOST_RETURNS = 1024  # places that are kept of one owner: as many as there may be connections
# Times as long as measured that places are taken for to get free: so a fifth of them is left for
# whoever comes unannounced, and work that takes longer makes nobody come in vain.
SPARE = 1.25
# After which a place is taken to get free at the soonest [s]: a measured cost of 0 says nothing.
LEAST_PLACE_S = 1e-3
SUBSCRIBER = 64  # bits of an IPv6 address that name a network (RFC 6177: each site has one or more)


@dataclass(eq=False)
class _Flow:
    """The work of one owner: ``tag``, ``mean_s`` of his urgent work [s], what waits and runs.

    ``expected``: places that work takes which is being accepted. ``returns``: when what found no
    room is to come back, and its name, in order. ``pace_s``: from one of his places that gets free
    to the next [s], averaged over ``paced`` of them. ``freed``: when the last one did; None where
    he had no other since.
    """

    tag: float
    mean_s: float
    urgent: deque[asyncio.Future[Turn]] = field(default_factory=deque)
    rest: deque[asyncio.Future[Turn]] = field(default_factory=deque)
    running: int = 0
    expected: int = 0
    returns: list[tuple[float, str]] = field(default_factory=list)
    pace_s: float = 0.0
    paced: int = 0
    freed: float | None = None

    def free(self, now: float) -> None:
        """One of his places gets free: urgent work of his begins."""
        if self.freed is not None:
            self.paced = min(self.paced + 1, PACED)
            self.pace_s += (now - self.freed - self.pace_s) / self.paced
        self.freed = now

    @property
    def places(self) -> int:
        """Places of the queue that he has."""
        return len(self.urgent) + self.expected

    @property
    def waits(self) -> bool:
        """Whether some of his work could begin."""
        return bool(self.urgent or self.rest)


@dataclass(eq=False)
class Turn:
    """A turn that somebody has: since when, and the cost [s] that it was begun with."""

    flow: _Flow
    urgent: bool
    cost: float
    began: float


class FairQueue:
    """Who is served next by something that serves so many at once; see above.

    Of one owner urgent work goes before the rest, and what came first before what came later.

    Args:
        slots: how many are served at once; it may change.
        most: urgent works that may wait. what: they are, in the plural. clock: the time [s].
    """

    def __init__(
        self, slots: Callable[[], int], most: int = 0, what: str = "",
        clock: Callable[[], float] = time.monotonic,
    ) -> None:  # fmt: skip
        self._slots, self._most, self._what, self._clock = slots, most, what, clock
        self._flows: dict[str, _Flow] = {}
        self._virtual, self._mean_s = 0.0, UNMEASURED_S
        self.running = 0

    @property
    def waiting(self) -> int:
        """Urgent works that wait, or are being accepted."""
        return sum(flow.places for flow in self._flows.values())

    @property
    def is_free(self) -> bool:
        """Whether what comes now begins at once."""
        busy = any(flow.waits for flow in self._flows.values())
        return self._idle > self.waiting and not busy

    @property
    def _idle(self) -> int:
        """Slots that nobody has; what is being accepted will take as many of them."""
        return max(0, self._slots() - self.running)

    @asynccontextmanager
    async def turn(self, *, urgent: bool = True) -> AsyncIterator[None]:
        """While something is served, once it is its turn."""
        turn = await self.acquire(urgent=urgent)
        try:
            yield
        finally:
            self.release(turn)

    async def acquire(self, *, urgent: bool = True, limited: bool = False) -> Turn:
        """Wait for a turn, which has to be released; ``limited``: if there is ``room`` to wait."""
        flow = self._flow()
        if limited:
            self._check_room(flow, "")
        place: asyncio.Future[Turn] = asyncio.get_running_loop().create_future()
        line = flow.urgent if urgent else flow.rest
        line.append(place)
        self.look_again()
        try:
            return await place
        except asyncio.CancelledError:
            if place.cancelled():
                with contextlib.suppress(ValueError):  # it may have been dropped already
                    line.remove(place)
            else:  # its turn had come
                self.release(place.result(), served=False)
            raise

    def release(self, turn: Turn, *, served: bool = True) -> None:
        """Give a turn back, and begin with what is next; what it cost is known now."""
        flow, cost = turn.flow, self._clock() - turn.began if served else 0.0
        flow.running -= 1
        self.running -= 1
        # Never below the virtual time: who was charged too much is not owed several turns at once.
        flow.tag = max(flow.tag + cost - turn.cost, self._virtual)
        if turn.urgent and served:
            self._mean_s += NEWEST * (cost - self._mean_s)
            flow.mean_s += NEWEST * (cost - flow.mean_s)
        self.look_again()

    def look_again(self) -> None:
        """Begin what can begin: somebody has come or gone, or there are more slots."""
        while self.running < self._slots():
            waiting = [flow for flow in self._flows.values() if flow.waits]
            if not waiting:
                break
            flow = min(waiting, key=lambda each: each.tag)
            urgent = bool(flow.urgent)
            place = (flow.urgent if urgent else flow.rest).popleft()
            if place.cancelled():
                continue
            self._virtual = flow.tag
            turn = Turn(flow, urgent, flow.mean_s, self._clock())
            if urgent:
                flow.free(turn.began)
            flow.tag += turn.cost
            flow.running += 1
            self.running += 1
            place.set_result(turn)

    @contextmanager
    def room(self, name: str = "") -> Iterator[None]:
        """A place in the queue, until the work that is being accepted takes it itself.

        ServiceError where there is none for whoever asks: the queue is full, and he has as many
        places as there are for each of those who have some. By ``name`` the work is known again
        when it comes back; without one, whatever has none is taken for it.
        """
        flow = self._flow()
        self._check_room(flow, name)
        flow.expected += 1
        try:
            yield
        finally:
            flow.expected -= 1

    def _check_room(self, flow: _Flow, name: str) -> None:
        again_s = self._until_room(flow, name)
        if again_s:
            raise ProblemType.BUSY(
                f"{self.waiting} {self._what} are waiting already, {flow.places} of them yours. By "
                f"what they take, there is room in {again_s} s.",
                {"Retry-After": str(again_s)},
            )

    def _until_room(self, flow: _Flow, name: str) -> int:
        """After how many seconds there is room for one more work of an owner; 0: there is now."""
        flows, now = self._flows.values(), self._clock()
        if self.is_free:
            return 0
        owners = 1 + sum(1 for each in flows if each is not flow and each.places)
        most = self._most + self._idle
        free = max(most - self.waiting, most // owners - flow.places)
        # Places of his get free as his work begins: by what it takes, and his share of the slots.
        busy = 1 + sum(1 for each in flows if each is not flow and (each.running or each.waits))
        # Where the machine is busy with what comes before a turn (bodies, the store), or with other
        # programs, they get free more slowly than that, and as slowly as they did of late.
        served_s = flow.mean_s * busy / max(1, self._slots())
        place_s = max(SPARE * max(served_s, flow.pace_s), LEAST_PLACE_S)
        flow.returns = [each for each in flow.returns if each[0] > now - KEPT_S]
        told = [each for each in flow.returns if each[1] == name and (name or each[0] <= now)][:1]
        is_due = bool(told) and told[0][0] <= now
        flow.returns = [each for each in flow.returns if each not in told]
        # The k-th of those who were told needs k + 1 places: those of today, and those that get
        # free until he comes. Whoever comes unannounced goes before none for whom that is tight.
        dues = [due - now for due, _ in flow.returns]
        before = 0 if is_due else max(
            (k + 1 for k, due in enumerate(dues) if free + max(0.0, due) / place_s < k + 2),
            default=0,
        )  # fmt: skip
        if free > 0 and not before:
            return 0
        # His place is the one after theirs, and after those who come before that; or still his own.
        again_s = math.ceil((1 + before - free) * place_s)
        while before < len(dues) and dues[before] <= again_s:
            before += 1
            again_s = math.ceil((1 + before - free) * place_s)
        if told and not is_due:
            again_s = math.ceil(told[0][0] - now)
        if len(flow.returns) < MOST_RETURNS:
            insort(flow.returns, (now + again_s, name))
        return again_s

    def _flow(self) -> _Flow:
        """Whose work it is; where nothing of his waits he begins at the virtual time, or later.

        Though some is under way: what that costs is not known yet, and would be owed to him.
        """
        name = current_owner.get()
        flow = self._flows.get(name)
        if flow is None:
            self._forget()
            flow = self._flows[name] = _Flow(self._virtual, self._mean_s)
        elif not flow.waits:
            flow.tag = max(flow.tag, self._virtual)
        if not flow.places:  # the time without a place says nothing about how soon one gets free
            flow.freed = None
        return flow

    def _forget(self) -> None:
        """Drop those of whom nothing need be known: they would begin anew as they would go on."""
        now = self._clock() - KEPT_S
        self._flows = {
            name: flow for name, flow in self._flows.items()
            if flow.running or flow.waits or flow.expected
            or (flow.returns and flow.returns[-1][0] > now)
            or (flow.tag > self._virtual and self.running)
        }  # fmt: skip


class TakeTurns:
    """Middleware: one request at a time begins in the event loop, by turns of clients' addresses.

    A request that has begun goes on by itself: what it waits for has queues of its own. So who
    floods the service with requests delays others by one of them, not by as many as he sends.
    """

    def __init__(self, app: ASGIApp) -> None:
        self._app, self._queue = app, FairQueue(lambda: 1)

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] == "http":
            current_owner.set(address_of(scope))
            turn = await self._queue.acquire()
            asyncio.get_running_loop().call_soon(self._queue.release, turn)
        await self._app(scope, receive, send)


def address_of(scope: Scope) -> str:
    """The address that a request comes from; of IPv6 the network, which is one subscriber's."""
    client = scope.get("client")
    address = client[0] if client else ""
    if ":" not in address:
        return str(address)
    try:
        return str(ip_network((address, SUBSCRIBER), strict=False))
    except ValueError:  # no address of IPv6 after all
        return str(address)
