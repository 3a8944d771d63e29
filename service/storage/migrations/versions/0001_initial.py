"""The tables of the first release."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0001"
down_revision = None


def upgrade() -> None:
    """Create all tables."""
    number = sa.BigInteger().with_variant(sa.Integer, "sqlite")
    op.create_table(
        "answers",
        sa.Column("sequence", number, primary_key=True),
        sa.Column("id", sa.String(64), nullable=False, unique=True),
        sa.Column("kind", sa.String(64), nullable=False),
        sa.Column("engine", sa.Integer, nullable=False),
        sa.Column("name", sa.String(200), nullable=False),
        sa.Column("created", sa.DateTime(timezone=True), nullable=False),
        sa.Column("state", sa.String(16), nullable=False),
        sa.Column("status", sa.String(16)),
        sa.Column("spec", sa.LargeBinary, nullable=False),
        sa.Column("body", sa.LargeBinary),
        sa.Column("etag", sa.String(64)),
        sa.Column("summary", sa.JSON, nullable=False),
        sa.Column("problem", sa.JSON),
    )
    op.create_index("ix_answers_kind", "answers", ["kind", "sequence"])
    op.create_index("ix_answers_state", "answers", ["state"])
    op.create_table(
        "idempotency_keys",
        sa.Column("key", sa.String(255), primary_key=True),
        sa.Column("body_hash", sa.String(64), nullable=False),
        sa.Column("created", sa.DateTime(timezone=True), nullable=False),
    )
    op.create_index("ix_idempotency_keys_created", "idempotency_keys", ["created"])
    op.create_table(
        "sweeps",
        sa.Column("sequence", number, primary_key=True),
        sa.Column("id", sa.String(64), nullable=False, unique=True),
        sa.Column("engine", sa.Integer, nullable=False),
        sa.Column("name", sa.String(200), nullable=False),
        sa.Column("created", sa.DateTime(timezone=True), nullable=False),
        sa.Column("started", sa.DateTime(timezone=True)),
        sa.Column("finished", sa.DateTime(timezone=True)),
        sa.Column("state", sa.String(16), nullable=False),
        sa.Column("spec", sa.LargeBinary, nullable=False),
        sa.Column("size", sa.Integer, nullable=False),
        sa.Column("axes", sa.JSON, nullable=False),
        sa.Column("quantities", sa.JSON, nullable=False),
        *(
            sa.Column(name, sa.Integer, nullable=False)
            for name in ("optimal", "feasible", "infeasible", "failed")
        ),
        # Which process works on it, and until when it has said so.
        sa.Column("owner", sa.String(64)),
        sa.Column("leased_until", sa.Float),
    )
    op.create_index("ix_sweeps_state", "sweeps", ["state"])
    # An item has a row once it is finished, and only one.
    op.create_table(
        "sweep_items",
        sa.Column("sequence", number, primary_key=True),
        sa.Column("sweep", sa.BigInteger, nullable=False),
        sa.Column("number", sa.Integer, nullable=False),
        sa.Column("status", sa.String(16), nullable=False),
        sa.Column("axis_values", sa.JSON, nullable=False),
        sa.Column("quantities", sa.JSON, nullable=False),
        sa.Column("gap", sa.Float),
        sa.Column("seconds", sa.Float, nullable=False),
        sa.Column("design_id", sa.String(64)),
        sa.Column("design", sa.LargeBinary),
        sa.Column("problem", sa.JSON),
    )
    op.create_index("ix_sweep_items_number", "sweep_items", ["sweep", "number"], unique=True)
    op.create_index("ix_sweep_items_sequence", "sweep_items", ["sweep", "sequence"])
    op.create_index("ix_sweep_items_status", "sweep_items", ["sweep", "status", "sequence"])
    op.create_index("ix_sweep_items_design_id", "sweep_items", ["design_id"])
    # Items whose worker died.
    op.create_table(
        "sweep_strikes",
        sa.Column("sweep", sa.BigInteger, primary_key=True, autoincrement=False),
        sa.Column("number", sa.Integer, primary_key=True, autoincrement=False),
        sa.Column("strikes", sa.Integer, nullable=False),
    )
