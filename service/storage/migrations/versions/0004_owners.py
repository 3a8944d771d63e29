"""Everything has an owner: what there was belongs to the local one. Keys, and what owners use."""

import sqlalchemy as sa
from alembic import op

revision = "0004"
down_revision = "0003"
NUMBER = sa.BigInteger().with_variant(sa.Integer, "sqlite")
TIME = sa.DateTime(timezone=True)


def _idempotency_keys(*owner: "sa.Column[str]") -> None:
    op.create_table(
        "idempotency_keys",
        *owner,
        sa.Column("key", sa.String(255), primary_key=True),
        sa.Column("body_hash", sa.String(64), nullable=False),
        sa.Column("created", TIME, nullable=False),
    )
    op.create_index("ix_idempotency_keys_created", "idempotency_keys", ["created"])


def upgrade() -> None:
    """Answers and sweeps go to the local owner; Idempotency-Keys of the last day are forgotten."""
    op.create_table(
        "holdings",
        sa.Column("sequence", NUMBER, primary_key=True),
        sa.Column("owner", sa.String(64), nullable=False),
        sa.Column("id", sa.String(64), nullable=False),
        sa.Column("kind", sa.String(64), nullable=False),
        sa.Column("created", TIME, nullable=False),
    )
    op.create_index("ix_holdings_owner", "holdings", ["owner", "id"], unique=True)
    op.create_index("ix_holdings_kind", "holdings", ["owner", "kind", "sequence"])
    op.create_index("ix_holdings_id", "holdings", ["id"])
    op.execute(
        "insert into holdings (owner, id, kind, created) "
        "select 'local', id, kind, created from answers order by sequence"
    )
    op.create_table(
        "api_keys",
        sa.Column("id", sa.String(16), primary_key=True),
        sa.Column("hash", sa.String(64), nullable=False, unique=True),
        sa.Column("owner", sa.String(64), nullable=False),
        sa.Column("name", sa.String(200), nullable=False),
        sa.Column("created", TIME, nullable=False),
        sa.Column("expires", TIME),
        sa.Column("revoked", TIME),
        sa.Column("operator", sa.Boolean, nullable=False),
        sa.Column("quotas", sa.JSON, nullable=False),
    )
    op.create_index("ix_api_keys_owner", "api_keys", ["owner"])
    op.create_table(
        "usage",
        sa.Column("owner", sa.String(64), primary_key=True),
        sa.Column("day", sa.String(10), primary_key=True),
        sa.Column("core_seconds", sa.Float, nullable=False),
    )
    belongs_to = sa.Column("belongs_to", sa.String(64), nullable=False, server_default="local")
    op.add_column("sweeps", belongs_to)
    op.create_index("ix_sweeps_belongs_to", "sweeps", ["belongs_to"])
    op.drop_table("idempotency_keys")
    _idempotency_keys(sa.Column("owner", sa.String(64), primary_key=True))


def downgrade() -> None:
    """Leave out whose it is: an earlier release shows everything to anyone."""
    op.drop_table("idempotency_keys")
    _idempotency_keys()
    op.drop_index("ix_sweeps_belongs_to", "sweeps")
    with op.batch_alter_table("sweeps") as sweeps:
        sweeps.drop_column("belongs_to")
    for table in ("usage", "api_keys", "holdings"):
        op.drop_table(table)
