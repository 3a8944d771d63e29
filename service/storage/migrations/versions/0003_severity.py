"""Items of sweeps have the severity of their design's worst warning."""

from alembic import op
from sqlalchemy import Column, String

revision = "0003"
down_revision = "0002"


def upgrade() -> None:
    """Earlier designs had no warnings."""
    column = Column("severity", String(8), nullable=False, server_default="none")
    op.add_column("sweep_items", column)


def downgrade() -> None:
    """Leave it out again."""
    with op.batch_alter_table("sweep_items") as items:
        items.drop_column("severity")
