"""The tables of a library, for people and programs alike.

Everything is a plain relation: one row a capture, one a part that was seen in it (track), one a
symbol. Words are stored as words and frames as the source counts them, so that
``SELECT part, direction, level, start_frame, end_frame FROM symbol`` can be read by anyone. Words
cost 19 bytes a row and a fifth of the speed against small codes; that buys a library which
needs no key to be read.
"""

from __future__ import annotations

from sqlalchemy import (
    Boolean,
    CheckConstraint,
    Column,
    Float,
    ForeignKey,
    ForeignKeyConstraint,
    Integer,
    LargeBinary,
    MetaData,
    PrimaryKeyConstraint,
    String,
    Table,
    Text,
    UniqueConstraint,
)

REVISION = "0001"
"""The revision of ``migrations/`` that these tables are; revisions sort by age as text."""

tables = MetaData(
    naming_convention={
        "pk": "pk_%(table_name)s",
        "fk": "fk_%(table_name)s_%(referred_table_name)s",
        "uq": "uq_%(table_name)s_%(column_0_name)s",
        "ck": "ck_%(table_name)s_%(constraint_name)s",
    }
)
"""All tables but `stamp`."""

profile = Table(
    "profile",
    tables,
    Column("id", Integer, primary_key=True),
    Column("name", Text, nullable=False),
    Column("digest", Text, nullable=False),  # sha256 of the profile's files
    UniqueConstraint("digest", "name"),
)

capture = Table(
    "capture",
    tables,
    Column("id", Integer, primary_key=True),
    Column("path", Text, nullable=False),  # as ingested
    Column("location", Text, nullable=False),  # absolute
    Column("format", Text, nullable=False),
    Column("sha256", Text, nullable=False),
    Column("label", Text, nullable=False),
    Column("fps", Float, nullable=False),  # of rate, for people
    Column("rate", Text, nullable=False),  # exact: 30, 30000/1001
    Column("frames", Integer, nullable=False),
    Column("speed", Text, nullable=False),  # beats a minute, exact
    Column("beats", Integer, nullable=False),  # in a unit
    Column("beat", Integer, nullable=False),  # 4: a quarter
    Column("division", Integer, nullable=False),  # ticks in a unit
    Column("profile_id", ForeignKey(profile.c.id)),  # null: a score that came as one
    Column("options", Text, nullable=False),  # JSON: how the reader was overridden
    Column("other", Text, nullable=False),  # JSON: lines that were not understood
    Column("heading", LargeBinary, nullable=False),  # degrees at 60 Hz, little-endian float32
    UniqueConstraint("location"),
)

metadata = Table(
    "metadata",
    tables,
    Column("capture_id", ForeignKey(capture.c.id, ondelete="CASCADE"), primary_key=True),
    Column("key", Text, primary_key=True),
    Column("value", Text, nullable=False),
    sqlite_with_rowid=False,
)

track = Table(
    "track",
    tables,
    Column("capture_id", ForeignKey(capture.c.id, ondelete="CASCADE"), primary_key=True),
    Column("part", Text, primary_key=True),
    Column("ordinal", Integer, nullable=False),
    Column("known", Text, nullable=False),  # JSON: [[start, end], …], frames in which it was seen
    sqlite_with_rowid=False,
)

symbol = Table(
    "symbol",
    tables,
    Column("capture_id", Integer, primary_key=True),
    Column("part", Text, primary_key=True),
    Column("ordinal", Integer, primary_key=True),
    Column("direction", Text, nullable=False),
    Column("level", Text, nullable=False),
    Column("start_frame", Integer, nullable=False),  # of the source, half-open
    Column("end_frame", Integer, nullable=False),  # equal to start_frame: a starting position
    Column("tick", Integer, nullable=False),
    Column("ticks", Integer, nullable=False),
    Column("passing", Boolean, nullable=False),
    Column("rule", Integer, nullable=False),
    Column("swings", Integer, nullable=False),
    Column("margin", Float),  # null: unknown
    Column("runner_direction", Text),
    Column("runner_level", Text),
    ForeignKeyConstraint(
        ["capture_id", "part"], ["track.capture_id", "track.part"], ondelete="CASCADE"
    ),
    CheckConstraint("start_frame >= 0 AND end_frame >= start_frame", name="span"),
    sqlite_with_rowid=False,
)

stamp = Table(
    "alembic_version",
    MetaData(),
    Column("version_num", String(32), nullable=False),
    PrimaryKeyConstraint("version_num", name="alembic_version_pkc"),
)
"""One row, the revision: as Alembic makes it, which keeps it."""
