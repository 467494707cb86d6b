"""A library with fixed contents."""

import os
import sqlite3
from contextlib import closing, contextmanager
from fractions import Fraction

import numpy as np

from lanindex.library import connect
from lanindex.library.rows import Encoding
from lanindex.library.store import Store
from lanindex.model import Meter, Score, Span, Track
from lanindex.model.symbol import blank

ENCODING = Encoding("default", "d" * 64, {"up": "z"})


def name_of(path) -> str:
    """Return what opens the library of a path in another process, too."""
    return os.fspath(connect.target(path).name)


@contextmanager
def sql(path):
    """Let plain SQL be spoken to a library: kept at the end, and closed."""
    where = connect.target(path)
    if where.url:
        link = connect.connected(where, create=False, readonly=False, timeout=5)
        link.autocommit = False
    else:
        link = sqlite3.connect(path)
    with closing(link) as connection, connection:
        yield connection


def sample_score(seed: int = 0, parts=("r_arm", "l_arm", "head"), length: int = 6) -> Score:
    """Return a score of 10 frames a symbol; other seeds give other directions."""
    rows = blank(length)
    order = np.arange(length)
    rows["direction"], rows["level"] = (order + seed) % 9, (order + seed) % 3
    rows["start"], rows["stop"] = np.maximum(order * 10 - 9, 0), order * 10
    rows["tick"], rows["ticks"] = rows["start"], rows["stop"] - rows["start"]
    rows["margin"] = np.linspace(0.1, 0.9, length).round(3)
    rows["runner_direction"], rows["runner_level"] = (order + 1) % 9, -1
    tracks = {part: Track(part, rows, (Span(0, length * 10),)) for part in parts}
    return Score(Fraction(30000, 1001), length * 10, Meter(), tracks, other=("// kept",))


def fill(path, captures: int) -> None:
    """Make a library of captures named 0.bvh, 1.bvh …."""
    with Store.open(path, create=True) as library:
        for number in range(captures):
            add_sample(library, number)


def add_sample(library, number: int, **extra) -> int:
    """Store one sample under its number."""
    said = {"format": "bvh", "sha256": f"{number:064}", "encoding": ENCODING} | extra
    return library.add(f"{number}.bvh", sample_score(number), **said)
