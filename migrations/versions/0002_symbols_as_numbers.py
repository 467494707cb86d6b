"""Symbols as whole numbers, checksums, a change stamp, warnings.

Everything that it takes to tell the new rows from the old ones stands here, as it was when this
revision was made: the library's own code goes on.
"""

import json
import zlib

import numpy as np
import sqlalchemy as sa
from alembic import op

from lanindex.errors import LibraryError

revision = "0002"
down_revision = "0001"

_OLD = ("capture", "metadata", "track", "symbol")

_DIRECTIONS = {
    "right": 1,
    "r_forward": 2,
    "forward": 3,
    "l_forward": 4,
    "left": 5,
    "l_back": 6,
    "back": 7,
    "r_back": 8,
    "place": 9,
}
_LEVELS = {"low": 1, "mid": 2, "high": 3}


def upgrade() -> None:
    connection = op.get_bind()
    for name in _OLD:
        op.rename_table(name, f"old_{name}")
    _create_state()
    _create_capture()
    _create_metadata()
    _create_track()
    _create_symbol()
    numbers = connection.execute(sa.text("SELECT id FROM old_capture ORDER BY id")).scalars().all()
    for number in numbers:
        _copy(connection, number)
    op.execute(f"INSERT INTO state VALUES (1, 0, {len(numbers)}, {sum(numbers)})")
    _check_copied(connection)
    for name in reversed(_OLD):
        op.drop_table(f"old_{name}")


def _create_state() -> None:
    op.create_table(
        "state",
        sa.Column("id", sa.Integer(), nullable=False),
        sa.Column("stamp", sa.Integer(), nullable=False),
        sa.Column("captures", sa.Integer(), nullable=False),
        sa.Column("numbers", sa.BigInteger(), nullable=False),
        sa.PrimaryKeyConstraint("id", name="pk_state"),
        sa.CheckConstraint("id = 1", name=op.f("ck_state_one")),
    )


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
        sa.Column("warnings", sa.Text(), nullable=False),
        sa.Column("tracks", sa.Integer(), nullable=False),
        sa.Column("content", sa.Integer(), nullable=False),
        sa.Column("checksum", sa.Integer(), nullable=False),
        sa.Column("said", sa.Integer(), nullable=False),
        sa.Column("other", sa.Text(), nullable=False),
        sa.Column("heading", sa.LargeBinary(), nullable=False),
        sa.PrimaryKeyConstraint("id", name="pk_capture"),
        sa.UniqueConstraint("location", name="uq_capture_location"),
        sa.ForeignKeyConstraint(["profile_id"], ["profile.id"], name="fk_capture_profile"),
        sqlite_autoincrement=True,
    )


def _create_metadata() -> None:
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


def _create_track() -> None:
    op.create_table(
        "track",
        sa.Column("capture_id", sa.Integer(), nullable=False),
        sa.Column("ordinal", sa.Integer(), nullable=False),
        sa.Column("part", sa.Text(), nullable=False),
        sa.Column("kind", sa.Integer(), nullable=False),
        sa.Column("known", sa.Text()),
        sa.Column("symbols", sa.Integer(), nullable=False),
        sa.Column("checksum", sa.Integer(), nullable=False),
        sa.PrimaryKeyConstraint("capture_id", "ordinal", name="pk_track"),
        sa.ForeignKeyConstraint(
            ["capture_id"], ["capture.id"], name="fk_track_capture", ondelete="CASCADE"
        ),
        sqlite_with_rowid=False,
    )


def _create_symbol() -> None:
    op.create_table(
        "symbol_code",
        sa.Column("capture_id", sa.Integer(), nullable=False),
        sa.Column("track", sa.Integer(), nullable=False),
        sa.Column("ordinal", sa.Integer(), nullable=False),
        *(
            sa.Column(name, sa.BigInteger(), nullable=False)
            for name in ("sign", "start", "length", "tick", "ticks", "notes")
        ),
        sa.PrimaryKeyConstraint("capture_id", "track", "ordinal", name="pk_symbol_code"),
        sa.ForeignKeyConstraint(
            ["capture_id", "track"],
            ["track.capture_id", "track.ordinal"],
            name="fk_symbol_code_track",
            ondelete="CASCADE",
        ),
        sqlite_with_rowid=False,
    )


def _copy(connection: sa.Connection, number: int) -> None:
    """Write one capture and all that hangs on it into the new tables."""
    (old,) = _rows(connection, "old_capture", "id", number)
    try:
        tracks, symbols = _tracks(connection, number, old["frames"])
        capture, metadata = _capture(connection, old, tracks)
    except (KeyError, ValueError, TypeError, AttributeError) as error:
        raise LibraryError(
            f"capture {number} is damaged in the library: {error!r}",
            place=str(old["location"]),
            remedy="Nothing was changed. Ingest the captures into a new library: all in it comes "
            "from them.",
        ) from error
    _insert(connection, "capture", [tuple(capture.values())], tuple(capture))
    _insert(connection, "metadata", [(number, *pair) for pair in metadata.items()])
    _insert(connection, "track", [(number, *track) for track in tracks])
    _insert(connection, "symbol_code", [(number, *symbol) for symbol in symbols])


def _check_copied(connection: sa.Connection) -> None:
    """Refuse to drop rows that hang on nothing, and so were not copied."""
    for name in _OLD:
        new = "symbol_code" if name == "symbol" else name
        asked = sa.text(f"SELECT (SELECT count(*) FROM old_{name}) - (SELECT count(*) FROM {new})")
        left = connection.execute(asked).scalar()
        if left:
            raise LibraryError(
                f"{left} rows of the table {name} hang on nothing",
                remedy="Nothing was changed. Ingest the captures into a new library: all in it "
                "comes from them.",
            )


def _rows(connection: sa.Connection, table: str, key: str, number: int, then: str = "") -> list:
    order = f" ORDER BY {then}" if then else ""
    asked = sa.text(f"SELECT * FROM {table} WHERE {key} = :number{order}")
    return [dict(row) for row in connection.execute(asked, {"number": number}).mappings()]


def _insert(connection: sa.Connection, table: str, rows: list, names: tuple = ()) -> None:
    if rows:
        into = f"{table} ({', '.join(names)})" if names else table
        marks = ", ".join("?" * len(rows[0]))
        connection.exec_driver_sql(f"INSERT INTO {into} VALUES ({marks})", rows)


def _checksum(*values: object) -> int:
    return _signed(zlib.crc32(ascii(values).encode()))


def _signed(checksum: int) -> int:
    return checksum - ((checksum >> 31) << 32)


def _capture(connection: sa.Connection, old: dict, tracks: list) -> tuple[dict, dict]:
    """Return the columns of a capture, and what the user said of it."""
    number, heading = old["id"], _heading(old["heading"])
    found = _rows(connection, "profile", "id", old["profile_id"])
    name, digest = (found[0]["name"], found[0]["digest"]) if found else (None, None)
    metadata = {
        row["key"]: row["value"] for row in _rows(connection, "old_metadata", "capture_id", number)
    }
    new = {
        **old,
        "warnings": "[]",
        "tracks": _checksum(*tracks),
        "content": _signed(zlib.crc32(old["other"].encode(), zlib.crc32(heading))),
        "said": _checksum(number, old["label"], *sorted(metadata.items(), key=ascii)),
        "heading": heading,
    }
    facts = "path location format sha256 fps rate frames speed beats beat division options"
    encoded = [new[fact] for fact in (*facts.split(), "warnings", "tracks", "content")]
    new["checksum"] = _checksum(*encoded, name, digest)
    return new, metadata


def _heading(blob: bytes) -> bytes:
    """Return a heading in tenths of a degree (1), or as it is where it cannot be so (0)."""
    degrees = np.frombuffer(blob, "<f4").astype(np.float64)
    if not (np.abs(degrees) < 1e6).all():
        return b"\0" + blob
    changes = np.diff(np.rint(degrees * 10).astype(np.int64), n=2, prepend=[0, 0])
    folded = (changes << 1) ^ (changes >> 63)
    if (folded >= 1 << 16).any():
        return b"\0" + blob
    bytes_of_each = folded.astype("<u2").view(np.uint8).reshape(-1, 2)
    return b"\1" + zlib.compress(bytes_of_each.T.tobytes())


def _tracks(connection: sa.Connection, number: int, frames: int) -> tuple[list, list]:
    """Return the rows of ``track`` and ``symbol_code`` without the capture's number."""
    tracks, symbols = [], []
    for old in _rows(connection, "old_track", "capture_id", number, "ordinal"):
        part, ordinal = old["part"], len(tracks)
        asked = sa.text(
            "SELECT * FROM old_symbol WHERE capture_id = :number AND part = :part ORDER BY ordinal"
        )
        found = connection.execute(asked, {"number": number, "part": part}).mappings().all()
        rows = [(ordinal, row, *_numbers(one)) for row, one in enumerate(found)]
        known = None if json.loads(old["known"]) == [[0, frames]] else old["known"]
        kind = int(part in ("support", "r_support", "l_support"))
        checksum = _signed(zlib.crc32(np.array(rows, "<i8").tobytes()))
        tracks.append((ordinal, part, kind, known, len(rows), checksum))
        symbols += rows
    return tracks, symbols


def _numbers(old: sa.RowMapping) -> tuple[int, ...]:
    """Return a symbol's sign, start, length, tick, ticks and notes."""
    fields = (
        (_DIRECTIONS[old["direction"]], 4),
        (_LEVELS[old["level"]], 2),
        (_DIRECTIONS[old["runner_direction"]] if old["runner_direction"] is not None else 0, 4),
        (_LEVELS[old["runner_level"]] if old["runner_level"] is not None else 0, 2),
        (int(old["passing"]), 1),
        (round(1000 * (old["margin"] or 0)), 10),
    )
    length = old["end_frame"] - old["start_frame"]
    notes = _packed((old["swings"], 24), (old["rule"], 16))
    spans = [_packed((one, 31)) for one in (old["start_frame"], length, old["tick"], old["ticks"])]
    return _packed(*fields), *spans, notes


def _packed(*fields: tuple[int, int]) -> int:
    """Return numbers in one, each with its bits, from the lowest."""
    packed, shift = 0, 0
    for value, bits in fields:
        if not 0 <= value < 1 << bits:
            raise ValueError(f"{value} has no room in {bits} bits")
        packed |= value << shift
        shift += bits
    return packed
