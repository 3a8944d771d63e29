"""Questions have leases as sweeps have, and count the workers that they have killed."""

from alembic import op
from sqlalchemy import Column, Float, Integer, String

revision = "0005"
down_revision = "0004"


def upgrade() -> None:
    """Nobody works on those of earlier releases: whoever starts first adopts them."""
    op.alter_column("sweeps", "owner", new_column_name="leased_by")  # owners are people by now
    op.add_column("answers", Column("leased_by", String(64)))
    op.add_column("answers", Column("leased_until", Float))
    op.add_column("answers", Column("strikes", Integer, nullable=False, server_default="0"))


def downgrade() -> None:
    """Leave them out again."""
    with op.batch_alter_table("answers") as answers:
        for name in ("leased_by", "leased_until", "strikes"):
            answers.drop_column(name)
    op.alter_column("sweeps", "leased_by", new_column_name="owner")
