"""The tables of a library, and the view in which a person reads its symbols.

One row a capture, one a part that was seen in it (``track``), one a symbol (``symbol_code``). A
symbol is a handful of whole numbers, for spelled-out words took four fifths of a library; the view
``symbol`` shows them in words and in the frames of the source, so that
``SELECT part, direction, level, start_frame, end_frame FROM symbol`` can be read by anyone.

What a search reads are columns: all symbols of a part in many captures, field by field, in segments
(``segment``, ``segment_column``) that are written once. Their columns may be files outside, for
many machines to read; files that no segment names any more stand in ``segment_old`` until they are
deleted. Segments are made of the rows and can always be made again; which captures they do not hold
yet, or no longer, stands in ``segment_pending`` and ``segment_dead``.

What was stored is told from what it became by checksums, each a CRC-32: a track's over its
symbols, a capture's over all that was encoded (with those of its tracks, its heading and its other
lines) and one over what the user said of it.
"""

import sqlalchemy as sa

from lanindex.library.rows import COLUMNS

Text = sa.Text().with_variant(sa.Text(collation="C"), "postgresql")
"""Text that sorts by its letters' numbers, in PostgreSQL as in SQLite and in Python."""

tables = sa.MetaData(
    naming_convention={
        "pk": "pk_%(table_name)s",
        "fk": "fk_%(table_name)s_%(referred_table_name)s",
        "uq": "uq_%(table_name)s_%(column_0_name)s",
        "ck": "ck_%(table_name)s_%(constraint_name)s",
        "ix": "ix_%(table_name)s_%(column_0_name)s",
    }
)
"""All tables but `version`."""

state = sa.Table(
    "state",
    tables,
    sa.Column("id", sa.Integer, primary_key=True),
    sa.Column("stamp", sa.Integer, nullable=False),  # raised by every change
    sa.Column("captures", sa.Integer, nullable=False),  # how many there are
    sa.Column("numbers", sa.BigInteger, nullable=False),  # the sum of theirs
    sa.Column("columns", sa.Integer, nullable=False),  # the stamp at which the segments are true
    sa.Column("segments", Text),  # folder or URL of their files; null: segment_column has all
    sa.CheckConstraint("id = 1", name="one"),
)
"""One row: what is true of the library as a whole."""

profile = sa.Table(
    "profile",
    tables,
    sa.Column("id", sa.Integer, primary_key=True),
    sa.Column("name", Text, nullable=False),
    sa.Column("digest", Text, nullable=False),  # sha256 of the profile's files
    sa.UniqueConstraint("digest", "name"),
)

capture = sa.Table(
    "capture",
    tables,
    sa.Column("id", sa.Integer, primary_key=True),  # never used twice
    sa.Column("path", Text, nullable=False),  # as ingested
    sa.Column("location", Text, nullable=False),  # absolute
    sa.Column("format", Text, nullable=False),
    sa.Column("sha256", Text, nullable=False),
    sa.Column("label", Text, nullable=False),
    sa.Column("fps", sa.Float, nullable=False),  # of rate, for people
    sa.Column("rate", Text, nullable=False),  # exact: 30, 30000/1001
    sa.Column("frames", sa.Integer, nullable=False),
    sa.Column("speed", Text, nullable=False),  # beats a minute, exact
    sa.Column("beats", sa.Integer, nullable=False),  # in a unit
    sa.Column("beat", sa.Integer, nullable=False),  # 4: a quarter
    sa.Column("division", sa.Integer, nullable=False),  # ticks in a unit
    sa.Column("profile_id", sa.ForeignKey(profile.c.id)),  # null: a score that came as one
    sa.Column("options", Text, nullable=False),  # JSON: how it was read, its file's version
    sa.Column("warnings", Text, nullable=False),  # JSON: what the reader found doubtful
    sa.Column("tracks", sa.Integer, nullable=False),  # checksum of the list of tracks
    sa.Column("content", sa.Integer, nullable=False),  # checksum of other and heading
    sa.Column("checksum", sa.Integer, nullable=False),  # of all else encoded, and these two
    sa.Column("said", sa.Integer, nullable=False),  # checksum of label and metadata
    sa.Column("other", Text, nullable=False),  # JSON: lines that were not understood
    sa.Column("heading", sa.LargeBinary, nullable=False),  # degrees at 60 Hz, see rows.pack_heading
    sa.UniqueConstraint("location"),
    sa.Index(None, "path"),
    sqlite_autoincrement=True,
)

metadata = sa.Table(
    "metadata",
    tables,
    sa.Column("capture_id", sa.ForeignKey(capture.c.id, ondelete="CASCADE"), primary_key=True),
    sa.Column("key", Text, primary_key=True),
    sa.Column("value", Text, nullable=False),
    sqlite_with_rowid=False,
)

track = sa.Table(
    "track",
    tables,
    sa.Column("capture_id", sa.ForeignKey(capture.c.id, ondelete="CASCADE"), primary_key=True),
    sa.Column("ordinal", sa.Integer, primary_key=True, autoincrement=False),
    sa.Column("part", Text, nullable=False),
    sa.Column("kind", sa.Integer, nullable=False),  # its place in alphabet.KINDS
    sa.Column("known", Text),  # JSON: [[start, end], …], frames in which it was seen; null: all
    sa.Column("symbols", sa.Integer, nullable=False),  # how many
    sa.Column("checksum", sa.Integer, nullable=False),  # of its symbols
    sqlite_with_rowid=False,
)

symbol_code = sa.Table(
    "symbol_code",
    tables,
    sa.Column("capture_id", sa.Integer, primary_key=True, autoincrement=False),
    sa.Column("track", sa.Integer, primary_key=True, autoincrement=False),  # its ordinal
    sa.Column("ordinal", sa.Integer, primary_key=True, autoincrement=False),
    *(sa.Column(name, sa.BigInteger, nullable=False) for name in COLUMNS),  # as model.symbol says
    sa.ForeignKeyConstraint(
        ["capture_id", "track"], ["track.capture_id", "track.ordinal"], ondelete="CASCADE"
    ),
    sqlite_with_rowid=False,
)

segment = sa.Table(
    "segment",
    tables,
    sa.Column("id", sa.Integer, primary_key=True),  # never used twice: the newest is the highest
    sa.Column("captures", sa.Integer, nullable=False),
    sa.Column("symbols", sa.BigInteger, nullable=False),
    sa.Column("listing", Text, nullable=False),  # JSON: its columns, see segments.Entry
    sa.Column("checksum", sa.Integer, nullable=False),  # of the three, and of file
    sa.Column("file", Text),  # the name of its file; null: segment_column has its columns
    sqlite_autoincrement=True,
)

segment_column = sa.Table(
    "segment_column",
    tables,
    sa.Column("id", sa.Integer, primary_key=True),
    sa.Column("segment_id", sa.Integer, nullable=False),
    sa.Column("part", Text, nullable=False),  # empty: of the captures
    sa.Column("name", Text, nullable=False),  # cell, start, …
    sa.Column("content", sa.LargeBinary, nullable=False),  # whole numbers, little-endian
    sa.UniqueConstraint("segment_id", "part", "name"),
)

segment_old = sa.Table(
    "segment_old",
    tables,
    sa.Column("place", Text, primary_key=True),  # folder or URL
    sa.Column("name", Text, primary_key=True),  # a file that no segment names any more
    sa.Column("since", sa.BigInteger, nullable=False),  # see segment_files.collect
    sqlite_with_rowid=False,
)

segment_pending = sa.Table(
    "segment_pending",
    tables,
    sa.Column("capture_id", sa.Integer, primary_key=True, autoincrement=False),  # in no segment yet
)

segment_dead = sa.Table(
    "segment_dead",
    tables,
    sa.Column("capture_id", sa.Integer, primary_key=True, autoincrement=False),
    sa.Column("segment_id", sa.Integer, nullable=False),  # not true in this segment and older ones
)

version = sa.Table(
    "alembic_version",
    sa.MetaData(),
    sa.Column("version_num", sa.String(32), nullable=False),
    sa.PrimaryKeyConstraint("version_num", name="alembic_version_pkc"),
)
"""One row, the revision: as Alembic makes it, which keeps it."""
