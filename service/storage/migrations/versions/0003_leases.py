"""Which process works on a sweep and until when, and which items have taken workers with them."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0003"
down_revision = "0002"


def upgrade() -> None:
    """Add the columns and the table."""
    op.add_column("sweeps", sa.Column("owner", sa.String(64)))
    op.add_column("sweeps", sa.Column("leased_until", sa.Float))
    op.create_table(
        "sweep_strikes",
        sa.Column("sweep", sa.BigInteger, primary_key=True, autoincrement=False),
        sa.Column("number", sa.Integer, primary_key=True, autoincrement=False),
        sa.Column("strikes", sa.Integer, nullable=False),
    )
