"""The tables of the first release, as they are in `service.storage.tables`: nothing to change."""

revision = "0001"
down_revision = None


def upgrade() -> None:
    """Nothing: a new database gets its tables from the models."""
