"""Turns by owner: who comes anew waits for one work of each other at most; refusals are honest."""

from __future__ import annotations

import asyncio
import contextlib
from collections import deque
from collections.abc import Coroutine
from typing import Any

import pytest

from service.wire.errors import ServiceError
from service.wire.fair_queue import FairQueue, address_of, current_owner


class Clock:
    """Time that passes when a test says so."""

    def __init__(self) -> None:
        self.now = 1000.0

    def __call__(self) -> float:
        return self.now


@pytest.fixture
def clock() -> Clock:
    return Clock()


async def waits(work: Coroutine[Any, Any, None]) -> asyncio.Task[None]:
    task = asyncio.create_task(work)
    await asyncio.sleep(0)
    return task


def test_a_newcomer_waits_for_one_work_of_each_other_at_most(clock: Clock) -> None:
    begun: list[str] = []

    async def run() -> None:
        queue = FairQueue(lambda: 1, clock=clock)

        async def work(owner: str, seconds: float, urgent: bool = True) -> None:
            current_owner.set(owner)
            async with queue.turn(urgent=urgent):
                begun.append(owner if urgent else f"{owner}'s sweep")
                await asyncio.sleep(0)
                clock.now += seconds
            if len(begun) == 4:
                newcomer.set_result(None)

        async def late() -> None:
            await newcomer
            await work("quiet", 1.0)

        newcomer: asyncio.Future[None] = asyncio.get_running_loop().create_future()
        first = await queue.acquire()
        tasks = [await waits(work("loud", 1.0, urgent=False)) for _ in range(3)]
        tasks += [await waits(work("loud", 3.0)) for _ in range(6)]
        tasks += [await waits(work("other", 6.0)) for _ in range(3)]
        tasks.append(await waits(late()))
        queue.release(first)
        await asyncio.gather(*tasks)
        at = begun.index("quiet")
        assert {"loud", "other"} >= set(begun[4:at])
        assert at - 4 <= 2
        # Urgent work of an owner goes first, and time is shared, not turns: 6 s here as there.
        assert begun[-3:] == ["loud's sweep"] * 3
        assert begun[:9].count("loud") >= 5

    asyncio.run(run())


def test_who_leaves_while_he_waits_blocks_nobody() -> None:
    async def run() -> None:
        queue = FairQueue(lambda: 1)
        first = await queue.acquire()
        gone = [asyncio.create_task(queue.acquire()) for _ in range(2)]
        await asyncio.sleep(0)
        gone[0].cancel()  # while it waits
        queue.release(first)
        gone[1].cancel()  # when its turn has come
        await asyncio.gather(*gone, return_exceptions=True)
        assert (queue.waiting, queue.running) == (0, 0)
        queue.release(await queue.acquire())

    asyncio.run(run())


def test_a_full_queue_has_room_for_who_has_none_yet(clock: Clock) -> None:
    async def run() -> None:
        queue = FairQueue(lambda: 1, 4, "questions", clock)
        for _ in range(5):
            await waits(queue.acquire())  # type: ignore[arg-type]
        with pytest.raises(ServiceError, match="4 questions are waiting already, 4 of them yours"):
            queue.room().__enter__()
        current_owner.set("quiet")
        with queue.room():
            assert queue.waiting == 5

    asyncio.run(run())


def test_work_that_is_being_accepted_has_its_place_though_a_slot_is_free(clock: Clock) -> None:
    queue = FairQueue(lambda: 2, 4, "questions", clock)
    with contextlib.ExitStack() as accepted:
        for _ in range(6):
            accepted.enter_context(queue.room())
        assert not queue.is_free
        with pytest.raises(ServiceError, match="6 questions are waiting already, 6 of them yours"):
            queue.room().__enter__()


def refused_s(queue: FairQueue, name: str) -> float:
    """For how long this work is sent away [s]; 0: there is room."""
    try:
        queue.room(name).__enter__()
    except ServiceError as refused:
        return float(refused.headers["Retry-After"])
    return 0.0


def test_a_place_is_kept_for_the_work_that_was_told(clock: Clock) -> None:
    """Whoever else comes when it is due, or before, does not get it."""

    async def run() -> None:
        queue = FairQueue(lambda: 1, 1, "questions", clock)
        for _ in range(40):  # works of 8 s
            turn = await queue.acquire()
            clock.now += 8.0
            queue.release(turn)
        first = await queue.acquire()
        await waits(queue.acquire())  # type: ignore[arg-type]
        told_s = refused_s(queue, "told")
        assert 8.0 < told_s < 12.0
        assert refused_s(queue, "another") > told_s
        clock.now += 1.0
        assert refused_s(queue, "told") == told_s - 1.0
        clock.now -= 1.0
        clock.now += 2.0
        queue.release(first)
        await asyncio.sleep(0)
        assert refused_s(queue, "one more") > told_s - 2.0
        clock.now += told_s
        assert refused_s(queue, "a third") > 0
        assert refused_s(queue, "told") == 0

    asyncio.run(run())


def test_who_was_told_too_soon_goes_before_those_who_were_told_later(clock: Clock) -> None:
    async def run() -> None:
        queue = FairQueue(lambda: 1, 1, "questions", clock)
        await queue.acquire()
        await waits(queue.acquire())  # type: ignore[arg-type]
        first = refused_s(queue, "first")
        clock.now += 0.9 * first
        later = [refused_s(queue, f"later {n}") for n in range(20)]
        clock.now += 0.1 * first
        assert refused_s(queue, "first") <= 1.0 < later[-1]

    asyncio.run(run())


def test_who_comes_back_when_he_was_told_finds_room(clock: Clock) -> None:
    """Forty clients of one owner for a queue of four: each asks anew at once when answered."""

    async def run() -> None:
        queue, found = FairQueue(lambda: 1, 4, "questions", clock), [0, 0]
        due = [clock.now] * 40
        told = [False] * 40
        serving: list[tuple[float, int, Any]] = []
        for _ in range(4000):
            clock.now += 0.05
            for client, time in enumerate(due):
                if time > clock.now:
                    continue
                try:
                    with queue.room(str(client)):
                        pass
                except ServiceError as refused:
                    found[0] += told[client]
                    told[client] = True
                    due[client] = clock.now + float(refused.headers["Retry-After"])
                    continue
                found[0] += told[client]
                found[1] += told[client]
                told[client], due[client] = False, float("inf")
                task = asyncio.create_task(queue.acquire())
                await asyncio.sleep(0)
                serving.append((0.0, client, task))
            # A work takes 0.3 s; who is answered asks anew.
            for i, (began, client, task) in enumerate(list(serving)):
                if task.done() and not began:
                    serving[i] = (clock.now, client, task)
                elif began and clock.now - began >= 0.3:
                    queue.release(task.result())
                    await asyncio.sleep(0)
                    due[client] = clock.now
                    serving.remove((began, client, task))
                    break
        for _, _, task in serving:
            task.cancel()
        came, room = found
        assert came > 100
        assert room > 0.9 * came

    asyncio.run(run())


def test_he_does_so_where_a_work_takes_longer_to_be_accepted_than_to_be_done(clock: Clock) -> None:
    """A busy machine: 0.3 s until a work is accepted, one after the other, and 0.1 s at work.

    In between there is work of a sweep, which takes as long.
    """

    async def run() -> None:
        queue, found = FairQueue(lambda: 1, 4, "questions", clock), [0, 0]
        due = dict.fromkeys(range(40), clock.now)
        told: set[int] = set()
        accepted: deque[tuple[int, Any]] = deque()
        serving = {asyncio.create_task(queue.acquire(urgent=False)): -1 for _ in range(2)}
        await asyncio.sleep(0)
        for step in range(4000):
            clock.now += 0.1
            for turn in [each for each in serving if each.done()]:
                queue.release(turn.result())
                client = serving.pop(turn)
                if client < 0:
                    serving[asyncio.create_task(queue.acquire(urgent=False))] = -1
                else:
                    due[client] = clock.now
            if step % 3 == 0 and accepted:
                client, room = accepted.popleft()
                serving[asyncio.create_task(queue.acquire())] = client
                await asyncio.sleep(0)
                room.__exit__(None, None, None)
            await asyncio.sleep(0)
            for client in [each for each, time in due.items() if time <= clock.now]:
                found[0] += client in told
                room = queue.room(str(client))
                try:
                    room.__enter__()
                except ServiceError as refused:
                    told.add(client)
                    due[client] = clock.now + float(refused.headers["Retry-After"])
                else:
                    found[1] += client in told
                    told.discard(client)
                    del due[client]
                    accepted.append((client, room))
        for turn in serving:
            turn.cancel()
        came, room_found = found
        assert came > 100
        assert room_found > 0.9 * came

    asyncio.run(run())


@pytest.mark.parametrize(
    ("client", "name"),
    [(None, ""), (("10.0.0.7", 1), "10.0.0.7"), (("2001:db8::7:1", 1), "2001:db8::/64")],
)
def test_clients_are_told_apart_by_address(client: Any, name: str) -> None:
    assert address_of({"client": client}) == name
