"""Follower trains on their cams."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0006"
down_revision = "0005"


def upgrade() -> None:
    """Make their table."""
    number = sa.BigInteger().with_variant(sa.Integer, "sqlite")
    op.create_table(
        "train_responses",
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
    op.create_index("ix_train_responses_state", "train_responses", ["state"])
