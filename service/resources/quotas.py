"""Quotas of owners: time in the core, storage, and questions that are worked on."""

from __future__ import annotations

import math
import time
from collections import defaultdict
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from datetime import UTC, datetime, timedelta

from sqlalchemy import func, select
from sqlalchemy.orm import Session

from service.storage.answers import charge
from service.storage.store import Store
from service.storage.tables import AnswerRow, HoldingRow, ItemRow, SweepRow, UsageRow
from service.sweeps.store import UNDER_WAY
from service.wire.access import Caller, limit_headers
from service.wire.errors import ProblemType

MEGABYTE = 1e6  # bytes
DAY_S = 86_400.0  # [s]
AGAIN_S = "5"  # Retry-After where one has to wait for questions of one's own


class UsedQuotas:
    """What owners have used. It is read only for keys that have a quota."""

    def __init__(self, store: Store) -> None:
        self._do = store.do
        self._waiting: dict[str, set[str]] = defaultdict(set)  # waiting in this process, by owner

    @asynccontextmanager
    async def room(self, caller: Caller, id: str) -> AsyncIterator[None]:
        """While a question is accepted, or its answer waited for. ServiceError: no room for it."""
        waiting, new = self._waiting[caller.owner], id not in self._waiting[caller.owner]
        waiting.add(id)  # at once, so that those who ask meanwhile count it
        try:
            if caller.quotas.limited:
                await self._check(caller, id, frozenset(waiting))
            yield
        finally:
            if new:
                waiting.discard(id)
            if not waiting:
                self._waiting.pop(caller.owner, None)

    @asynccontextmanager
    async def core(self, caller: Caller, budget_s: float) -> AsyncIterator[None]:
        """While a worker makes what is not kept, such as a file, in the time that it has [s]."""
        if caller.key is None:
            yield
            return
        await self._check_core_seconds(caller)
        began = time.monotonic()
        try:
            yield
        finally:
            seconds = min(time.monotonic() - began, budget_s)  # it may have waited for a worker
            await self._do(lambda session: charge(session, caller.owner, seconds))

    async def _check_core_seconds(self, caller: Caller) -> None:
        owner, most, now = caller.owner, caller.quotas.core_seconds_per_day, datetime.now(UTC)
        if most is None:
            return
        used = await self._do(lambda s: s.get(UsageRow, (owner, now.date().isoformat())))
        if used is not None and used.core_seconds >= most:
            midnight = datetime.combine(now.date() + timedelta(1), datetime.min.time(), UTC)
            left_s = math.ceil((midnight - now).total_seconds())
            headers = limit_headers("core-seconds", most, DAY_S, 0.0, left_s)
            raise ProblemType.QUOTA_USED_UP(
                f"{owner} may use {most:g} s of the core a day, and has used them. What was "
                "accepted is finished; ask again after midnight UTC, or let the operator raise "
                "the quota.",
                {**headers, "Retry-After": str(left_s)},
            )

    async def _check(self, caller: Caller, id: str, waiting: frozenset[str]) -> None:
        """Refuse what goes beyond a quota, before it is accepted; what was accepted is finished."""
        owner, quotas = caller.owner, caller.quotas
        await self._check_core_seconds(caller)
        if quotas.storage_mb is not None:
            used_mb = await self._do(lambda session: _bytes_held(session, owner)) / MEGABYTE
            if used_mb >= quotas.storage_mb:
                headers = limit_headers("storage", quotas.storage_mb * MEGABYTE, None, 0.0, None)
                raise ProblemType.QUOTA_USED_UP(
                    f"The answers of {owner} take {used_mb:.1f} MB of {quotas.storage_mb:g} MB. "
                    "Delete what is not needed any more: DELETE an answer or a sweep by its path.",
                    headers,
                )
        if quotas.concurrent is not None:
            working = (await self._do(lambda session: _worked_on(session, owner))) | waiting | {id}
            if len(working) > quotas.concurrent:
                raise ProblemType.QUOTA_USED_UP(
                    f"{owner} may have {quotas.concurrent} questions worked on at the same time. "
                    "Ask again when one of them is answered.",
                    {
                        **limit_headers("concurrent", quotas.concurrent, None, 0.0, None),
                        "Retry-After": AGAIN_S,
                    },
                )


def _worked_on(session: Session, owner: str) -> set[str]:
    """Ids of an owner's questions that are accepted and not answered, and of his sweeps."""
    answers = select(AnswerRow.id).join(HoldingRow, HoldingRow.id == AnswerRow.id)
    answers = answers.where(HoldingRow.owner == owner, AnswerRow.state == "accepted")
    sweeps = select(SweepRow.id).where(SweepRow.belongs_to == owner, SweepRow.state.in_(UNDER_WAY))
    return {*session.scalars(answers), *session.scalars(sweeps)}


def _bytes_held(session: Session, owner: str) -> float:
    """Bytes of the answers that an owner holds, those that others hold too included."""
    sizes = func.length(AnswerRow.spec) + func.coalesce(func.length(AnswerRow.body), 0)
    answers = select(func.sum(sizes)).join(HoldingRow, HoldingRow.id == AnswerRow.id)
    items = select(func.sum(func.length(ItemRow.design))).join(
        SweepRow, ItemRow.sweep == SweepRow.sequence
    )
    return float(session.scalar(answers.where(HoldingRow.owner == owner)) or 0) + float(
        session.scalar(items.where(SweepRow.belongs_to == owner)) or 0
    )
