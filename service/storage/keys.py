"""Keys to the service: made at random, shown once, kept as hashes.

A key has 256 random bits, so that nobody can go through all or likely ones. That is what slow
hashes with salt are for, which guard passwords that people choose; of a random key SHA-256 tells
as little, and costs a microsecond a request where those would cost a worker's time.
"""

from __future__ import annotations

import hashlib
import secrets
import time
from collections.abc import Sequence
from dataclasses import asdict
from datetime import UTC, datetime, timedelta
from typing import Any

from sqlalchemy import select, update
from sqlalchemy.orm import Session

from service.settings import Settings
from service.storage.store import Store
from service.storage.tables import ApiKeyRow, in_utc
from service.wire.access import Caller, KeyRefused, Quotas

PREFIX = "camwright_"  # by which people, and programs that look for secrets, know one
KEY_BYTES = 32  # random ones of a key: 256 bits
LONGEST = 100  # characters; keys have 53
REREAD_S = 1.0  # that a key read from the database is trusted: one revoked is refused after that


class ApiKeys:
    """The keys in a database."""

    def __init__(self, store: Store, settings: Settings) -> None:
        self._do = store.do
        self._defaults = Quotas(
            settings.quota_requests_per_minute, settings.quota_core_seconds_per_day,
            settings.quota_storage_mb, settings.quota_concurrent,
        )  # fmt: skip
        self._known: dict[str, tuple[float, Caller]] = {}  # until when, by hash

    async def create(
        self,
        name: str,
        owner: str,
        days: float | None = None,
        *,
        operator: bool = False,
        quotas: Quotas | None = None,
    ) -> tuple[ApiKeyRow, str]:
        """A new key of an owner, for so many days (None: without end), and its text."""
        own = {key: value for key, value in asdict(quotas or Quotas()).items() if value is not None}
        return await self._do(lambda s: _add(s, name, owner, _in(days), operator, own))

    async def rotate(
        self, id: str, overlap_days: float, days: float | None
    ) -> tuple[ApiKeyRow, str, datetime]:
        """A key in place of this one, its text, and when this one ends.

        That is after the overlap, or when it would have ended anyhow. LookupError where there is
        none, or it is not valid any more.
        """

        def work(session: Session) -> tuple[ApiKeyRow, str, datetime]:
            old = session.get(ApiKeyRow, id, with_for_update=True)
            if old is None or not is_valid(old):
                raise LookupError(id)
            ends = _in(overlap_days), in_utc(old.expires)
            old.expires = end = min(each for each in ends if each is not None)
            made = _add(session, old.name, old.owner, _in(days), old.operator, old.quotas)
            return *made, end

        return await self._do(work)

    async def revoke(self, id: str) -> bool:
        """Refuse a key from now on; whether there was one, not revoked before."""
        change = update(ApiKeyRow).filter_by(id=id, revoked=None).returning(ApiKeyRow.id)
        change = change.values(revoked=datetime.now(UTC))
        return await self._do(lambda session: session.scalar(change)) is not None

    async def all(self) -> Sequence[ApiKeyRow]:
        """Every key, those of an owner together, the oldest first."""
        query = select(ApiKeyRow).order_by(ApiKeyRow.owner, ApiKeyRow.created)
        return await self._do(lambda session: session.scalars(query).all())

    async def caller(self, text: str) -> Caller:
        """Who has this key; KeyRefused where it is unknown, expired or revoked."""
        if not text.startswith(PREFIX) or len(text) > LONGEST:  # not worth a look
            raise KeyRefused("is not one of this service's")
        hash, now = _hash(text), time.monotonic()
        until, caller = self._known.get(hash, (0.0, None))
        if caller is not None and now < until:
            return caller
        self._known.pop(hash, None)
        row = await self._do(lambda s: s.scalar(select(ApiKeyRow).filter_by(hash=hash)))
        if row is None:
            raise KeyRefused("is not one of this service's")
        if not is_valid(row):
            raise KeyRefused("has been revoked" if row.revoked else "has expired")
        caller = Caller(row.owner, row.id, row.operator, self._defaults.with_own(row.quotas))
        self._known[hash] = now + REREAD_S, caller
        return caller


def is_valid(row: ApiKeyRow) -> bool:
    """Whether a key opens anything now."""
    expires = in_utc(row.expires)
    return row.revoked is None and (expires is None or datetime.now(UTC) < expires)


def _add(
    session: Session,
    name: str,
    owner: str,
    expires: datetime | None,
    operator: bool,
    quotas: dict[str, Any],
) -> tuple[ApiKeyRow, str]:
    text = PREFIX + secrets.token_urlsafe(KEY_BYTES)
    row = ApiKeyRow(
        id=secrets.token_hex(4), hash=_hash(text), owner=owner, name=name,
        created=datetime.now(UTC), expires=expires, revoked=None, operator=operator, quotas=quotas,
    )  # fmt: skip
    session.add(row)
    return row, text


def _in(days: float | None) -> datetime | None:
    return None if days is None else datetime.now(UTC) + timedelta(days=days)


def _hash(text: str) -> str:
    return hashlib.sha256(text.encode("utf-8", "replace")).hexdigest()
