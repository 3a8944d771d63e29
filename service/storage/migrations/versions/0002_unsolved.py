"""Sweeps count items that are unsolved: no cam found, and none excluded."""

from alembic import op
from sqlalchemy import Column, Integer

revision = "0002"
down_revision = "0001"


def upgrade() -> None:
    """Earlier sweeps have none: their items were all called infeasible."""
    op.add_column("sweeps", Column("unsolved", Integer, nullable=False, server_default="0"))


def downgrade() -> None:
    """Count them among the infeasible again."""
    op.execute("update sweeps set infeasible = infeasible + unsolved")
    op.execute("update sweep_items set status = 'infeasible' where status = 'unsolved'")
    with op.batch_alter_table("sweeps") as sweeps:
        sweeps.drop_column("unsolved")
