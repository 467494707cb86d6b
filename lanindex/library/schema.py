"""The tables of a library, and the view in which a person reads its symbols.

One row a capture, one a part that was seen in it (``track``), one a symbol (``symbol_code``). A
symbol is a handful of whole numbers, for spelled-out words took four fifths of a library; the view
``symbol`` shows them in words and in the frames of the source, so that
``SELECT part, direction, level, start_frame, end_frame FROM symbol`` can be read by anyone.

What a search reads are columns: all symbols of a part in many captures, field by field, in segments
(``segment``, ``segment_column``) that are written once. They are made of the rows and can always
be made again; which captures they do not hold yet, or no longer, stands in ``segment_pending`` and
``segment_dead``.

What was stored is told from what it became by checksums, each a CRC-32: a track's over its
symbols, a capture's over all that was encoded (with those of its tracks, its heading and its other
lines) and one over what the user said of it.
"""

from __future__ import annotations

from sqlalchemy import (
    DDL,
    BigInteger,
    CheckConstraint,
    Column,
    Float,
    ForeignKey,
    ForeignKeyConstraint,
    Index,
    Integer,
    LargeBinary,
    MetaData,
    PrimaryKeyConstraint,
    String,
    Table,
    Text,
    UniqueConstraint,
    event,
)

from lanindex.library.rows import COLUMNS, view_sql

tables = MetaData(
    naming_convention={
        "pk": "pk_%(table_name)s",
        "fk": "fk_%(table_name)s_%(referred_table_name)s",
        "uq": "uq_%(table_name)s_%(column_0_name)s",
        "ck": "ck_%(table_name)s_%(constraint_name)s",
        "ix": "ix_%(table_name)s_%(column_0_name)s",
    }
)
"""All tables but `version`."""

state = Table(
    "state",
    tables,
    Column("id", Integer, primary_key=True),
    Column("stamp", Integer, nullable=False),  # raised by every change
    Column("captures", Integer, nullable=False),  # how many there are
    Column("numbers", BigInteger, nullable=False),  # the sum of theirs
    Column("columns", Integer, nullable=False),  # the stamp at which the segments are true
    CheckConstraint("id = 1", name="one"),
)
"""One row: what is true of the library as a whole."""

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
    Column("id", Integer, primary_key=True),  # never used twice
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
    Column("warnings", Text, nullable=False),  # JSON: what the reader found doubtful
    Column("tracks", Integer, nullable=False),  # checksum of the list of tracks
    Column("content", Integer, nullable=False),  # checksum of other and heading
    Column("checksum", Integer, nullable=False),  # of all else that was encoded, and these two
    Column("said", Integer, nullable=False),  # checksum of label and metadata
    Column("other", Text, nullable=False),  # JSON: lines that were not understood
    Column("heading", LargeBinary, nullable=False),  # degrees at 60 Hz, see rows.pack_heading
    UniqueConstraint("location"),
    Index(None, "path"),
    sqlite_autoincrement=True,
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
    Column("ordinal", Integer, primary_key=True, autoincrement=False),
    Column("part", Text, nullable=False),
    Column("kind", Integer, nullable=False),  # its place in alphabet.KINDS
    Column("known", Text),  # JSON: [[start, end], …], frames in which it was seen; null: all
    Column("symbols", Integer, nullable=False),  # how many
    Column("checksum", Integer, nullable=False),  # of its symbols
    sqlite_with_rowid=False,
)

symbol_code = Table(
    "symbol_code",
    tables,
    Column("capture_id", Integer, primary_key=True, autoincrement=False),
    Column("track", Integer, primary_key=True, autoincrement=False),  # its ordinal
    Column("ordinal", Integer, primary_key=True, autoincrement=False),
    *(Column(name, BigInteger, nullable=False) for name in COLUMNS),  # as model.symbol says
    ForeignKeyConstraint(
        ["capture_id", "track"], ["track.capture_id", "track.ordinal"], ondelete="CASCADE"
    ),
    sqlite_with_rowid=False,
)

segment = Table(
    "segment",
    tables,
    Column("id", Integer, primary_key=True),  # never used twice: the newest is the highest
    Column("captures", Integer, nullable=False),
    Column("symbols", BigInteger, nullable=False),
    Column("listing", Text, nullable=False),  # JSON: its columns, see columns.Listing
    Column("checksum", Integer, nullable=False),  # of the three
    sqlite_autoincrement=True,
)

segment_column = Table(
    "segment_column",
    tables,
    Column("id", Integer, primary_key=True),
    Column("segment_id", Integer, nullable=False),
    Column("part", Text, nullable=False),  # empty: of the captures
    Column("name", Text, nullable=False),  # cell, start, …
    Column("content", LargeBinary, nullable=False),  # whole numbers, little-endian
    UniqueConstraint("segment_id", "part", "name"),
)

segment_pending = Table(
    "segment_pending",
    tables,
    Column("capture_id", Integer, primary_key=True, autoincrement=False),  # in no segment yet
)

segment_dead = Table(
    "segment_dead",
    tables,
    Column("capture_id", Integer, primary_key=True, autoincrement=False),
    Column("segment_id", Integer, nullable=False),  # not true in this segment and older ones
)

event.listen(tables, "after_create", DDL(view_sql()))  # type: ignore[no-untyped-call]

version = Table(
    "alembic_version",
    MetaData(),
    Column("version_num", String(32), nullable=False),
    PrimaryKeyConstraint("version_num", name="alembic_version_pkc"),
)
"""One row, the revision: as Alembic makes it, which keeps it."""
