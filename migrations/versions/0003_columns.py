"""Columns of symbols in segments, for searches; none yet: all captures are to be put into some."""

import sqlalchemy as sa
from alembic import op

revision = "0003"
down_revision = "0002"


def upgrade() -> None:
    _widen_state()
    op.create_table(
        "segment",
        sa.Column("id", sa.Integer(), nullable=False),
        sa.Column("captures", sa.Integer(), nullable=False),
        sa.Column("symbols", sa.BigInteger(), nullable=False),
        sa.Column("listing", sa.Text(), nullable=False),
        sa.Column("checksum", sa.Integer(), nullable=False),
        sa.PrimaryKeyConstraint("id", name="pk_segment"),
        sqlite_autoincrement=True,
    )
    op.create_table(
        "segment_column",
        sa.Column("id", sa.Integer(), nullable=False),
        sa.Column("segment_id", sa.Integer(), nullable=False),
        sa.Column("part", sa.Text(), nullable=False),
        sa.Column("name", sa.Text(), nullable=False),
        sa.Column("content", sa.LargeBinary(), nullable=False),
        sa.PrimaryKeyConstraint("id", name="pk_segment_column"),
        sa.UniqueConstraint("segment_id", "part", "name", name="uq_segment_column_segment_id"),
    )
    op.create_table(
        "segment_pending",
        sa.Column("capture_id", sa.Integer(), autoincrement=False, nullable=False),
        sa.PrimaryKeyConstraint("capture_id", name="pk_segment_pending"),
    )
    op.create_table(
        "segment_dead",
        sa.Column("capture_id", sa.Integer(), autoincrement=False, nullable=False),
        sa.Column("segment_id", sa.Integer(), nullable=False),
        sa.PrimaryKeyConstraint("capture_id", name="pk_segment_dead"),
    )
    op.execute("INSERT INTO segment_pending SELECT id FROM capture ORDER BY id")


def _widen_state() -> None:
    op.rename_table("state", "old_state")
    op.create_table(
        "state",
        sa.Column("id", sa.Integer(), nullable=False),
        sa.Column("stamp", sa.Integer(), nullable=False),
        sa.Column("captures", sa.Integer(), nullable=False),
        sa.Column("numbers", sa.BigInteger(), nullable=False),
        sa.Column("columns", sa.Integer(), nullable=False),
        sa.PrimaryKeyConstraint("id", name="pk_state"),
        sa.CheckConstraint("id = 1", name=op.f("ck_state_one")),
    )
    op.execute("INSERT INTO state SELECT id, stamp, captures, numbers, stamp FROM old_state")
    op.drop_table("old_state")
