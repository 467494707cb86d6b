"""Captures, the profiles they were written down with, tracks and symbols."""

import sqlalchemy as sa
from alembic import op

revision = "0001"
down_revision = None


def upgrade() -> None:
    op.create_table(
        "profile",
        sa.Column("id", sa.Integer(), nullable=False),
        sa.Column("name", sa.Text(), nullable=False),
        sa.Column("digest", sa.Text(), nullable=False),
        sa.PrimaryKeyConstraint("id", name="pk_profile"),
        sa.UniqueConstraint("digest", "name", name="uq_profile_digest"),
    )
    _create_capture()
    op.create_table(
        "metadata",
        sa.Column("capture_id", sa.Integer(), nullable=False),
        sa.Column("key", sa.Text(), nullable=False),
        sa.Column("value", sa.Text(), nullable=False),
        sa.PrimaryKeyConstraint("capture_id", "key", name="pk_metadata"),
        sa.ForeignKeyConstraint(
            ["capture_id"], ["capture.id"], name="fk_metadata_capture", ondelete="CASCADE"
        ),
        sqlite_with_rowid=False,
    )
    op.create_table(
        "track",
        sa.Column("capture_id", sa.Integer(), nullable=False),
        sa.Column("part", sa.Text(), nullable=False),
        sa.Column("ordinal", sa.Integer(), nullable=False),
        sa.Column("known", sa.Text(), nullable=False),
        sa.PrimaryKeyConstraint("capture_id", "part", name="pk_track"),
        sa.ForeignKeyConstraint(
            ["capture_id"], ["capture.id"], name="fk_track_capture", ondelete="CASCADE"
        ),
        sqlite_with_rowid=False,
    )
    _create_symbol()


def _create_capture() -> None:
    op.create_table(
        "capture",
        sa.Column("id", sa.Integer(), nullable=False),
        sa.Column("path", sa.Text(), nullable=False),
        sa.Column("location", sa.Text(), nullable=False),
        sa.Column("format", sa.Text(), nullable=False),
        sa.Column("sha256", sa.Text(), nullable=False),
        sa.Column("label", sa.Text(), nullable=False),
        sa.Column("fps", sa.Float(), nullable=False),
        sa.Column("rate", sa.Text(), nullable=False),
        sa.Column("frames", sa.Integer(), nullable=False),
        sa.Column("speed", sa.Text(), nullable=False),
        sa.Column("beats", sa.Integer(), nullable=False),
        sa.Column("beat", sa.Integer(), nullable=False),
        sa.Column("division", sa.Integer(), nullable=False),
        sa.Column("profile_id", sa.Integer()),
        sa.Column("options", sa.Text(), nullable=False),
        sa.Column("other", sa.Text(), nullable=False),
        sa.Column("heading", sa.LargeBinary(), nullable=False),
        sa.PrimaryKeyConstraint("id", name="pk_capture"),
        sa.UniqueConstraint("location", name="uq_capture_location"),
        sa.ForeignKeyConstraint(["profile_id"], ["profile.id"], name="fk_capture_profile"),
    )


def _create_symbol() -> None:
    op.create_table(
        "symbol",
        sa.Column("capture_id", sa.Integer(), nullable=False),
        sa.Column("part", sa.Text(), nullable=False),
        sa.Column("ordinal", sa.Integer(), nullable=False),
        sa.Column("direction", sa.Text(), nullable=False),
        sa.Column("level", sa.Text(), nullable=False),
        sa.Column("start_frame", sa.Integer(), nullable=False),
        sa.Column("end_frame", sa.Integer(), nullable=False),
        sa.Column("tick", sa.Integer(), nullable=False),
        sa.Column("ticks", sa.Integer(), nullable=False),
        sa.Column("passing", sa.Boolean(), nullable=False),
        sa.Column("rule", sa.Integer(), nullable=False),
        sa.Column("swings", sa.Integer(), nullable=False),
        sa.Column("margin", sa.Float()),
        sa.Column("runner_direction", sa.Text()),
        sa.Column("runner_level", sa.Text()),
        sa.PrimaryKeyConstraint("capture_id", "part", "ordinal", name="pk_symbol"),
        sa.ForeignKeyConstraint(
            ["capture_id", "part"],
            ["track.capture_id", "track.part"],
            name="fk_symbol_track",
            ondelete="CASCADE",
        ),
        sa.CheckConstraint(
            "start_frame >= 0 AND end_frame >= start_frame", name=op.f("ck_symbol_span")
        ),
        sqlite_with_rowid=False,
    )
