"""Answers by id, and who holds them."""

from __future__ import annotations

from collections.abc import Sequence
from datetime import UTC, datetime
from functools import cache
from typing import Any

from sqlalchemy import (
    Float,
    String,
    and_,
    bindparam,
    delete,
    func,
    inspect,
    null,
    select,
    true,
    update,
)  # fmt: skip
from sqlalchemy.dialects import postgresql, sqlite
from sqlalchemy.orm import Session, defer

from service.storage.store import LeaseLost, Lookup, Store, find_or_add, relax
from service.storage.tables import AnswerRow, HoldingRow, UsageRow, in_utc

UNANSWERED = ("accepted", "failed")
# What an answer says of its question, and of itself.
ASKED = ("id", "kind", "engine", "name", "spec")
ENDED = ("created", "state", "status", "body", "etag", "summary")

# What every question asks of the store. Statements are built once: that takes longer than SQLite
# takes to run one.
_INSERTS: dict[str, Any] = {"postgresql": postgresql.insert, "sqlite": sqlite.insert}
ID, KIND, OWNER = (bindparam(name, type_=String) for name in ("id", "kind", "owner"))
ANSWER = select(AnswerRow).where(AnswerRow.id == ID, AnswerRow.kind == KIND)
LOCK = ANSWER.with_only_columns(AnswerRow.sequence).with_for_update()
HELD = select(AnswerRow, HoldingRow).join(HoldingRow, HoldingRow.id == AnswerRow.id)
HELD = HELD.where(HoldingRow.owner == OWNER, HoldingRow.kind == KIND)
HELD_ANSWER = HELD.where(AnswerRow.id == ID)
HOLDS = and_(HoldingRow.id == AnswerRow.id, HoldingRow.owner == OWNER)
CLAIMED = select(AnswerRow, HoldingRow).outerjoin(HoldingRow, HOLDS)
CLAIMED = CLAIMED.where(AnswerRow.id == ID, AnswerRow.kind == KIND)
LOCKED = ANSWER.with_for_update()
WITHOUT_BODY = (defer(AnswerRow.body), defer(AnswerRow.spec))
HELD_HEAD = HELD_ANSWER.options(*WITHOUT_BODY)
BODY = ANSWER.with_only_columns(AnswerRow.body)


class Answers:
    """The answers of one kind; every method is one transaction of the store's.

    An ``owner`` sees the answers that he holds, as if there were no others: when he has asked is
    when they were created. None is the service itself, which sees all. ``elsewhere`` finds answers
    that are kept as part of others.
    """

    def __init__(self, kind: str, store: Store, elsewhere: Lookup | None = None) -> None:
        self._kind, self._do, self._elsewhere = kind, store.do, elsewhere

    async def find(self, id: str, owner: str | None, *, with_body: bool = True) -> AnswerRow | None:
        """The answer with this id, if the owner holds it; its body and spec left out if wanted."""

        def work(session: Session) -> AnswerRow | None:
            names = {"id": id, "kind": self._kind}
            if owner is None:
                row = session.scalar(ANSWER, names)
            else:
                query = HELD_ANSWER if with_body else HELD_HEAD
                found = session.execute(query, {**names, "owner": owner}).first()
                row = None if found is None else _as_held(session, *found)
            if row is None and self._elsewhere is not None:
                return self._elsewhere(session, id, owner)
            return row

        return await self._do(work)

    async def body(self, row: AnswerRow) -> bytes | None:
        """The body of an answer that was found; None where it has been deleted since then."""
        if "body" not in inspect(row).unloaded:
            return row.body
        names = {"id": row.id, "kind": self._kind}
        return await self._do(lambda session: session.scalar(BODY, names))

    async def claim(self, id: str, owner: str) -> AnswerRow | None:
        """Let an owner hold the answer to a question that he has asked; the answer, if any."""
        names = {"id": id, "kind": self._kind, "owner": owner}

        def work(session: Session) -> AnswerRow | None:
            row, holding = session.execute(CLAIMED, names).first() or (None, None)
            if row is not None and holding is not None:
                return _as_held(session, row, holding)
            if self._elsewhere is not None:
                kept = self._elsewhere(session, id, owner)
                if kept is not None:
                    return kept
            if row is None:  # that he holds it was told to nobody: his answer, or 202, is kept
                relax(session)
            else:  # nobody may delete it before he holds it: read it as it is then
                row = session.scalar(LOCKED, names, execution_options={"populate_existing": True})
            now = datetime.now(UTC)
            session.execute(_hold(session.get_bind().dialect.name), {**names, "created": now})
            return None if row is None else _as_held(session, row, HoldingRow(created=now))

        return await self._do(work)

    def _lock(self, session: Session, id: str) -> None:
        """Let nobody else begin or end to hold an answer until the transaction ends."""
        session.execute(LOCK, {"id": id, "kind": self._kind})

    async def first_owner(self, id: str) -> str:
        """Whoever was first to ask of those who hold it; "" where nobody does."""
        query = select(HoldingRow.owner).filter_by(id=id).order_by(HoldingRow.sequence).limit(1)
        return await self._do(lambda session: session.scalar(query)) or ""

    async def is_held(self, id: str, owner: str) -> bool:
        """Whether an owner has asked the question and not deleted it, answered or not."""
        query = select(HoldingRow.sequence).filter_by(owner=owner, id=id, kind=self._kind)
        return await self._do(lambda session: session.scalar(query)) is not None

    async def release(self, id: str, owner: str, seconds: float = 0.0) -> tuple[bool, bool, bool]:
        """Let an owner hold it no longer, and delete it where nobody else does.

        Whether he held it, whether others do, and whether there was an answer, or a question that
        was accepted. ``seconds``: that the core has worked on it so far; used by this owner if he
        was the last.
        """

        def work(session: Session) -> tuple[bool, bool, bool]:
            self._lock(session, id)
            own = delete(HoldingRow).filter_by(owner=owner, id=id, kind=self._kind)
            held = session.scalar(own.returning(HoldingRow.sequence)) is not None
            other = session.scalar(select(HoldingRow.sequence).filter_by(id=id).limit(1))
            kept = select(AnswerRow.sequence).filter_by(id=id, kind=self._kind)
            there = session.scalar(kept) is not None
            if held and other is None:
                if seconds:
                    charge(session, owner, seconds)
                session.execute(delete(AnswerRow).filter_by(id=id, kind=self._kind))
            return held, other is not None, there

        return await self._do(work)

    async def accept(self, row: AnswerRow) -> AnswerRow:
        """Keep a question; where there is one with its id, that one, asked again if it failed."""

        def work(session: Session) -> AnswerRow:
            existing = find_or_add(session, row)
            if existing.state in ("failed", "superseded"):
                existing.state, existing.created = row.state, row.created
                existing.problem, existing.strikes = None, 0
            return existing

        return await self._do(work)

    async def finish(self, row: AnswerRow, accepted: bool, seconds: float = 0.0) -> AnswerRow:
        """Keep an answer; one that is done already stays as it is.

        Args:
            accepted: whether its question is kept; LeaseLost where it has been deleted since.
            seconds: that the core took; they are used by whoever was first to ask.
        """
        values = {name: getattr(row, name) for name in (*ASKED, *ENDED)}

        def work(session: Session) -> AnswerRow:
            if accepted and session.scalar(LOCK, values) is None:
                raise LeaseLost
            end = _end(session.get_bind().dialect.name)
            if session.execute(end, values).first() is None:
                return session.scalars(ANSWER, values).one()
            _charge_first(session, row.id, seconds)
            return row

        return await self._do(work)

    async def fail(self, id: str, problem: dict[str, Any], seconds: float = 0.0) -> None:
        """Note why an accepted one failed, or failed again; nothing where it was never accepted."""
        change = update(AnswerRow).filter_by(id=id).where(AnswerRow.state.in_(UNANSWERED))
        change = change.values(state="failed", problem=problem, leased_by=None, leased_until=None)

        def work(session: Session) -> None:
            session.execute(change)
            _charge_first(session, id, seconds)

        await self._do(work)

    async def add_strike(self, id: str) -> int:
        """Note that an accepted one has killed a worker; how many by now, 0 if not accepted."""
        change = update(AnswerRow).filter_by(id=id, state="accepted")
        change = change.values(strikes=AnswerRow.strikes + 1)
        strikes = change.returning(AnswerRow.strikes)
        return await self._do(lambda session: session.scalar(strikes)) or 0

    async def supersede(self, id: str, current: str) -> None:
        """Drop the answer of an earlier engine; its row still leads from its id to its question.

        Those who hold it hold the ``current`` one to their question as well.
        """
        change = update(AnswerRow).filter_by(id=id, kind=self._kind)
        change = change.values(
            state="superseded", body=None, problem=None, leased_by=None, leased_until=None
        )

        def work(session: Session) -> None:
            session.execute(change)
            known = set(session.scalars(select(HoldingRow.owner).filter_by(id=current)))
            for each in session.scalars(select(HoldingRow).filter_by(id=id, kind=self._kind)):
                if each.owner not in known:
                    session.add(
                        HoldingRow(
                            owner=each.owner, id=current, kind=self._kind, created=each.created
                        )
                    )

        await self._do(work)

    async def remove(self, id: str) -> bool:
        """Delete an answer that nobody holds; whether there was one."""

        def work(session: Session) -> bool:
            self._lock(session, id)
            if session.scalar(select(HoldingRow.sequence).filter_by(id=id).limit(1)) is not None:
                return False
            gone = delete(AnswerRow).filter_by(id=id, kind=self._kind)
            return session.scalar(gone.returning(AnswerRow.sequence)) is not None

        return await self._do(work)

    async def page(
        self, before: int | None, size: int, status: str | None, owner: str
    ) -> Sequence[AnswerRow]:
        """An owner's answers from the newest on, those with a smaller sequence than ``before``."""
        query = HELD.where(AnswerRow.state != "superseded").options(*WITHOUT_BODY)
        if status is not None:
            query = query.where(AnswerRow.status == status)
        if before is not None:
            query = query.where(HoldingRow.sequence < before)
        query = query.order_by(HoldingRow.sequence.desc()).limit(size)

        def work(session: Session) -> Sequence[AnswerRow]:
            found = session.execute(query, {"owner": owner, "kind": self._kind}).all()
            rows = [_as_held(session, *each) for each in found]
            for row, (_, holding) in zip(rows, found, strict=True):
                row.sequence = holding.sequence  # in line as he has asked
            return rows

        return await self._do(work)

    async def counts(self) -> dict[str, int]:
        """How many there are by status, or by state where they have none."""
        named = func.coalesce(AnswerRow.status, AnswerRow.state)
        query = select(named, func.count()).filter_by(kind=self._kind).group_by(named)
        query = query.where(AnswerRow.state != "superseded")
        return await self._do(lambda session: dict(session.execute(query).all()))


def _as_held(session: Session, row: AnswerRow, holding: HoldingRow) -> AnswerRow:
    """An answer as its holder sees it: created when he has asked."""
    session.expunge(row)  # so that what is set here is not written
    created = in_utc(holding.created)
    assert created is not None
    row.created = created
    return row


@cache
def _hold(database: str) -> Any:
    """That an owner holds an answer from now on, unless he does."""
    new = _INSERTS[database](HoldingRow.__table__)
    return new.on_conflict_do_nothing(index_elements=["owner", "id"])


@cache
def _end(database: str) -> Any:
    """Add an answer, or end what there is of its question unless that is done; its number, if so.

    Not as the session writes a row: that takes four times as long.
    """
    table = AnswerRow.__table__
    columns = {name: bindparam(name, type_=table.c[name].type) for name in (*ASKED, *ENDED)}
    new = _INSERTS[database](table).values(columns)
    changed = {name: new.excluded[name] for name in ENDED}
    nobody = dict.fromkeys(("problem", "leased_by", "leased_until"), null())
    ended = new.on_conflict_do_update(
        index_elements=["id"], set_=changed | nobody, where=table.c.state != "done"
    )
    return ended.returning(table.c.sequence)


def charge(session: Session, owner: str, seconds: float) -> None:
    """Note time in the core [s] as used by an owner today."""
    _add_usage(session, False, seconds, owner)


def _charge_first(session: Session, id: str, seconds: float) -> None:
    """The same by whoever was first to ask of those who hold an answer."""
    _add_usage(session, True, seconds, id)


def _add_usage(session: Session, of_first: bool, seconds: float, who: str) -> None:
    day = datetime.now(UTC).date().isoformat()
    use = _use(session.get_bind().dialect.name, of_first)
    session.execute(use, {"who": who, "day": day, "seconds": seconds})


@cache
def _use(database: str, of_first: bool) -> Any:
    """Add to what an owner has used: ``who`` is he, or else an answer that he was first to ask."""
    who = bindparam("who", type_=String)
    used = (bindparam("day", type_=String), bindparam("seconds", type_=Float))
    # Without a condition SQLite would take "on conflict" for one of a join.
    rows = select(who, *used).where(true())
    if of_first:
        rows = select(HoldingRow.owner, *used).where(HoldingRow.id == who)
        rows = rows.order_by(HoldingRow.sequence).limit(1)
    new = _INSERTS[database](UsageRow.__table__).from_select(["owner", "day", "core_seconds"], rows)
    more = UsageRow.core_seconds + new.excluded.core_seconds
    return new.on_conflict_do_update(index_elements=["owner", "day"], set_={"core_seconds": more})
