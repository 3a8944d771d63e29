"""Sweeps and their items. An item has a row once it is finished, and only one."""

from __future__ import annotations

import sqlalchemy as sa
from alembic import op

revision = "0002"
down_revision = "0001"


def upgrade() -> None:
    """Make both tables."""
    number = sa.BigInteger().with_variant(sa.Integer, "sqlite")
    op.create_table(
        "sweeps",
        sa.Column("sequence", number, primary_key=True),
        sa.Column("id", sa.String(64), nullable=False, unique=True),
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
    )
    op.create_index("ix_sweeps_state", "sweeps", ["state"])
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
