"""The tables of the database: questions, who has asked them, sweeps with their items, keys."""

from __future__ import annotations

from datetime import UTC, datetime
from typing import Any

from sqlalchemy import (
    JSON,
    BigInteger,
    Boolean,
    DateTime,
    Float,
    Index,
    Integer,
    LargeBinary,
    String,
)
from sqlalchemy.orm import DeclarativeBase, Mapped, mapped_column

# SQLite numbers rows by itself only where the type is called INTEGER.
ROW_NUMBER = BigInteger().with_variant(Integer, "sqlite")
TIME = DateTime(timezone=True)
LOCAL = "local"  # the owner of what is asked without a key
NAME = String(64)  # of an owner


class Base(DeclarativeBase):
    """The tables."""


class StoredRow(Base):
    """What is kept by id; ``sequence`` is the order in which it came."""

    __abstract__ = True

    sequence: Mapped[int] = mapped_column(ROW_NUMBER, primary_key=True)
    id: Mapped[str] = mapped_column(String(64), unique=True)
    engine: Mapped[int] = mapped_column(Integer)
    name: Mapped[str] = mapped_column(String(200))
    created: Mapped[datetime] = mapped_column(TIME)
    spec: Mapped[bytes] = mapped_column(LargeBinary)


class LeasedRow(StoredRow):
    """What a process works on: ``leased_by`` is that process, ``leased_until`` [s since 1970] how
    long it may.
    """

    __abstract__ = True

    state: Mapped[str] = mapped_column(String(16), index=True)
    leased_by: Mapped[str | None] = mapped_column(String(64))
    leased_until: Mapped[float | None] = mapped_column(Float)


class AnswerRow(LeasedRow):
    """One question with its answer.

    Attributes:
        kind: of question: the path of its collection. engine: number of the engine that answered.
        state: accepted, done or failed; superseded: of an earlier engine, its answer dropped since
            this one has accepted the question.
        status: what came out; None until it is done. spec: the question. body: the answer.
        summary: what lists show of it. problem: the problem document, where it failed.
        strikes: workers that it has killed.
    """

    __tablename__ = "answers"
    __table_args__ = (Index("ix_answers_kind", "kind", "sequence"),)

    kind: Mapped[str] = mapped_column(String(64))
    status: Mapped[str | None] = mapped_column(String(16))
    body: Mapped[bytes | None] = mapped_column(LargeBinary)
    etag: Mapped[str | None] = mapped_column(String(64))
    summary: Mapped[dict[str, Any]] = mapped_column(JSON, default=dict)
    problem: Mapped[dict[str, Any] | None] = mapped_column(JSON)
    strikes: Mapped[int] = mapped_column(Integer, default=0, server_default="0")


class HoldingRow(Base):
    """That an owner has asked a question: only those who have may read, list and delete its answer.

    Several owners may hold one answer. ``created`` and ``sequence`` are when this one asked, so
    that he sees nothing of the others. ``kind`` is that of the answer; a holding may be there
    before its answer.
    """

    __tablename__ = "holdings"
    __table_args__ = (
        Index("ix_holdings_owner", "owner", "id", unique=True),
        Index("ix_holdings_kind", "owner", "kind", "sequence"),
    )

    sequence: Mapped[int] = mapped_column(ROW_NUMBER, primary_key=True)
    owner: Mapped[str] = mapped_column(NAME)
    id: Mapped[str] = mapped_column(String(64), index=True)
    kind: Mapped[str] = mapped_column(String(64))
    created: Mapped[datetime] = mapped_column(TIME)


class ApiKeyRow(Base):
    """A key to the service; of the key itself only the hash is kept.

    Attributes:
        id: public, in lists and logs. expires, revoked: from when on it is refused; None: never.
        operator: whether it may read /metrics, which counts the work of all owners.
        quotas: fields of ``Quotas`` that differ from the settings.
    """

    __tablename__ = "api_keys"

    id: Mapped[str] = mapped_column(String(16), primary_key=True)
    hash: Mapped[str] = mapped_column(String(64), unique=True)
    owner: Mapped[str] = mapped_column(NAME, index=True)
    name: Mapped[str] = mapped_column(String(200))
    created: Mapped[datetime] = mapped_column(TIME)
    expires: Mapped[datetime | None] = mapped_column(TIME)
    revoked: Mapped[datetime | None] = mapped_column(TIME)
    operator: Mapped[bool] = mapped_column(Boolean)
    quotas: Mapped[dict[str, Any]] = mapped_column(JSON)


class UsageRow(Base):
    """Time in the core that an owner has used on a day, by UTC."""

    __tablename__ = "usage"

    owner: Mapped[str] = mapped_column(NAME, primary_key=True)
    day: Mapped[str] = mapped_column(String(10), primary_key=True)
    core_seconds: Mapped[float] = mapped_column(Float)


class KeyRow(Base):
    """An Idempotency-Key of an owner, and which body it came with."""

    __tablename__ = "idempotency_keys"

    owner: Mapped[str] = mapped_column(NAME, primary_key=True)
    key: Mapped[str] = mapped_column(String(255), primary_key=True)
    body_hash: Mapped[str] = mapped_column(String(64))
    created: Mapped[datetime] = mapped_column(TIME, index=True)


class SweepRow(LeasedRow):
    """One sweep, with how many of its items came out how; ``belongs_to``: who has asked for it."""

    __tablename__ = "sweeps"

    started: Mapped[datetime | None] = mapped_column(TIME)
    finished: Mapped[datetime | None] = mapped_column(TIME)
    size: Mapped[int] = mapped_column(Integer)
    axes: Mapped[list[str]] = mapped_column(JSON)
    quantities: Mapped[list[str]] = mapped_column(JSON)
    optimal: Mapped[int] = mapped_column(Integer, default=0)
    feasible: Mapped[int] = mapped_column(Integer, default=0)
    unsolved: Mapped[int] = mapped_column(Integer, default=0)
    infeasible: Mapped[int] = mapped_column(Integer, default=0)
    failed: Mapped[int] = mapped_column(Integer, default=0)
    belongs_to: Mapped[str] = mapped_column(NAME, index=True, server_default=LOCAL)

    @property
    def done(self) -> int:
        """Items that are finished, whatever came out."""
        return self.optimal + self.feasible + self.unsolved + self.infeasible + self.failed


class ItemRow(Base):
    """One finished item; ``sequence`` is the order in which they were finished."""

    __tablename__ = "sweep_items"
    __table_args__ = (
        Index("ix_sweep_items_number", "sweep", "number", unique=True),
        Index("ix_sweep_items_sequence", "sweep", "sequence"),
        Index("ix_sweep_items_status", "sweep", "status", "sequence"),
    )

    sequence: Mapped[int] = mapped_column(ROW_NUMBER, primary_key=True)
    sweep: Mapped[int] = mapped_column(BigInteger)
    number: Mapped[int] = mapped_column(Integer)
    status: Mapped[str] = mapped_column(String(16))
    severity: Mapped[str] = mapped_column(String(8), server_default="none")
    axis_values: Mapped[list[Any]] = mapped_column(JSON)
    quantities: Mapped[dict[str, float]] = mapped_column(JSON)
    gap: Mapped[float | None] = mapped_column(Float)
    seconds: Mapped[float] = mapped_column(Float)
    design_id: Mapped[str | None] = mapped_column(String(64), index=True)
    design: Mapped[bytes | None] = mapped_column(LargeBinary)
    problem: Mapped[dict[str, Any] | None] = mapped_column(JSON)


class StrikeRow(Base):
    """How many workers an item has killed."""

    __tablename__ = "sweep_strikes"

    sweep: Mapped[int] = mapped_column(BigInteger, primary_key=True, autoincrement=False)
    number: Mapped[int] = mapped_column(Integer, primary_key=True, autoincrement=False)
    strikes: Mapped[int] = mapped_column(Integer)


def in_utc(moment: datetime | None) -> datetime | None:
    """A time from the store; SQLite keeps none with a zone."""
    return moment.replace(tzinfo=UTC) if moment and moment.tzinfo is None else moment
