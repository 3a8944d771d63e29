"""An adversary for the fair queue: random owners, costs and cancellations against its theorem.

Start-time fair queueing promises, of a server that does one work at a time, that an owner who waits
and whose last work took ``c`` is served again within

    what is under way, and for each other owner c and his longest work

(Goyal, Vin, Cheng 1997, theorem 4, for equal weights). Of any number of servers: before the first
work of an owner who comes anew each other owner begins one work at most.
"""

from __future__ import annotations

import asyncio
import heapq
from collections import defaultdict
from dataclasses import dataclass, field
from itertools import count

from hypothesis import example, given, settings
from hypothesis import strategies as st

from service.wire.fair_queue import FairQueue, Turn, current_owner

ROUNDING = 1e-9  # of tags, relative
Plan = list[tuple[int, float, float, bool, float | None]]


@dataclass(eq=False)
class Job:
    """A work: who wants it from when on, how long it takes, and when he leaves if it waits [s]."""

    owner: str
    arrives: float
    cost: float
    urgent: bool
    leaves: float | None
    task: asyncio.Task[Turn] | None = None
    begun: float | None = None
    gone: float | None = None
    waited_since: float = 0.0  # for which its owner was not served, though he waited
    last_cost: float = 0.0  # of the owner's work before
    residual: float = 0.0  # of what was under way by then [s]
    is_new: bool = False  # whether its owner had nothing under way when it came
    begun_meanwhile: dict[str, int] = field(default_factory=lambda: defaultdict(int))


async def play(plan: Plan, slots: int) -> list[Job]:
    """The works of a plan in the order in which they came, as a queue has served them."""
    now, order = [0.0], count()
    queue = FairQueue(lambda: slots, clock=lambda: now[0])
    events: list[tuple[float, int, str, Job]] = []
    jobs: list[Job] = []
    at = 0.0
    for owner, after, cost, urgent, stays in plan:
        at += after
        job = Job(f"owner {owner}", at, cost, urgent, None if stays is None else at + stays)
        jobs.append(job)
        heapq.heappush(events, (at, next(order), "comes", job))
        if job.leaves is not None:
            heapq.heappush(events, (job.leaves, next(order), "leaves", job))
    running: dict[Job, float] = {}  # until when
    lines: dict[str, list[Job]] = defaultdict(list)
    last: dict[str, float] = defaultdict(float)

    async def wait_for(job: Job) -> Turn:
        current_owner.set(job.owner)
        return await queue.acquire(urgent=job.urgent)

    waits: dict[str, tuple[float, float, float]] = {}  # of owners: as in `Job`

    def look(owner: str) -> None:
        """Note since when an owner waits."""
        if not lines[owner]:
            waits.pop(owner, None)
        elif owner not in waits:
            residual = max((end - now[0] for end in running.values()), default=0.0)
            waits[owner] = now[0], last[owner], residual

    while events:
        now[0], _, what, job = heapq.heappop(events)
        if what == "comes":
            job.is_new = not lines[job.owner] and all(r.owner != job.owner for r in running)
            lines[job.owner].append(job)
            job.task = asyncio.create_task(wait_for(job))
            look(job.owner)
        elif what == "leaves" and job.begun is None and job.task is not None:
            job.gone = now[0]
            job.task.cancel()
            lines[job.owner].remove(job)
            look(job.owner)
        elif what == "ends":
            assert job.task is not None
            del running[job]
            queue.release(job.task.result())
        for _ in range(4):  # until nothing more happens at this moment
            await asyncio.sleep(0)
        begun = [each for line in lines.values() for each in line if each.task and each.task.done()]
        for each in begun:
            each.begun = now[0]
            each.waited_since, each.last_cost, each.residual = waits.pop(each.owner)
            lines[each.owner].remove(each)
            for line in lines.values():
                for waiting in line:
                    waiting.begun_meanwhile[each.owner] += 1
        for each in begun:
            running[each] = now[0] + each.cost
            last[each.owner] = each.cost
            heapq.heappush(events, (now[0] + each.cost, next(order), "ends", each))
            look(each.owner)
    assert (queue.running, queue.waiting) == (0, 0)
    return jobs


def check(jobs: list[Job], slots: int) -> None:
    """Fail where a work has waited for longer than the theorem allows, or for ever."""
    longest: dict[str, float] = defaultdict(float)
    for job in jobs:
        longest[job.owner] = max(longest[job.owner], job.cost)
    for job in jobs:
        if job.gone is not None:
            continue
        assert job.begun is not None, "stuck"
        others = [name for name in longest if name != job.owner]
        if slots == 1:
            most = job.residual + sum(job.last_cost + longest[name] for name in others)
            waited = job.begun - job.waited_since
            assert waited <= most * (1.0 + ROUNDING) + ROUNDING, (waited, most, job)
        if job.is_new and job.last_cost == 0.0 and job.urgent:
            assert max((job.begun_meanwhile[name] for name in others), default=0) <= 1, job


WORK = st.tuples(
    st.integers(0, 4),
    st.sampled_from((0.0, 0.0, 0.01, 0.3, 2.0)),
    st.sampled_from((0.001, 0.01, 0.1, 0.5, 3.0, 20.0)),
    st.booleans(),
    st.sampled_from((None, None, None, 0.0, 0.1, 1.0)),
)


# One whose long work was taken for a short one, and who asks again while it is under way.
OWED: Plan = [
    (0, 0.0, 20.0, True, None),
    *[(1, 0.0, 3.0, True, None)] * 2,
    (2, 4.0, 0.1, True, None),
    *[(0, 0.3, 0.5, True, None)] * 3,
]


@settings(max_examples=40, deadline=None)
@example(OWED, 2)
@given(st.lists(WORK, min_size=2, max_size=40), st.integers(1, 3))
def test_no_owner_waits_for_longer_than_the_theorem_says(plan: Plan, slots: int) -> None:
    check(asyncio.run(play(plan, slots)), slots)
