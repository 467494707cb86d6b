"""An index of the captures' paths: one is found by its path however many there are."""

from alembic import op

revision = "0004"
down_revision = "0003"


def upgrade() -> None:
    op.create_index("ix_capture_path", "capture", ["path"])
