"""Designs, cam sets, analyses and idempotency keys.

Databases from before there were migrations hold some of these tables:
what is there is left as it is.
"""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0001"
down_revision = None


def upgrade() -> None:
    """Make the tables that are not there yet."""
    known = set(sa.inspect(op.get_bind()).get_table_names())
    for name in {"designs", "cam_sets", "analyses", "profile_analyses"} - known:
        _answers(name)
    if "idempotency_keys" not in known:
        op.create_table(
            "idempotency_keys",
            sa.Column("key", sa.String(255), primary_key=True),
            sa.Column("body_hash", sa.String(64), nullable=False),
            sa.Column("design_id", sa.String(64), nullable=False),
            sa.Column("created", sa.DateTime(timezone=True), nullable=False),
        )
        op.create_index("ix_idempotency_keys_created", "idempotency_keys", ["created"])


def _answers(name: str) -> None:
    number = sa.BigInteger().with_variant(sa.Integer, "sqlite")
    op.create_table(
        name,
        sa.Column("sequence", number, primary_key=True),
        sa.Column("id", sa.String(64), nullable=False, unique=True),
        sa.Column("name", sa.String(200), nullable=False),
        sa.Column("created", sa.DateTime(timezone=True), nullable=False),
        sa.Column("state", sa.String(16), nullable=False),
        sa.Column("status", sa.String(16)),
        sa.Column("spec", sa.LargeBinary, nullable=False),
        sa.Column("design", sa.LargeBinary),
        sa.Column("etag", sa.String(64)),
        sa.Column("summary", sa.JSON, nullable=False),
        sa.Column("problem", sa.JSON),
    )
    op.create_index(f"ix_{name}_state", name, ["state"])
