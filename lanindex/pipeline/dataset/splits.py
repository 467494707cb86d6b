"""Which clips are for training, which for validation, which for testing.

No performer is in two splits; where none is told, no capture is. The same content under two paths
is one, and so are people of one recording who are not told apart.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from fractions import Fraction
from hashlib import sha256

from lanindex.errors import UsageError, shown
from lanindex.formats.file import SUBJECT
from lanindex.model import Capture

SPLITS = ("train", "val", "test")

PERFORMERS = ("performer", "subject", "actor", "dancer", "participant", "signer", "person")
"""Columns of the user's that tell who moves, the first that any capture has."""


def performers(captures: Sequence[Capture], column: str | None = None) -> str:
    """Return the column that tells who moves; empty where none does."""
    columns = {name for one in captures for name, value in one.metadata.items() if value}
    if column is None:
        return next((name for name in PERFORMERS if name in columns), "")
    if column not in columns:
        wanted = (
            f"one of {', '.join(sorted(columns))}"
            if columns
            else "captures with columns (--labels)"
        )
        raise UsageError(f'no column "{shown(column)}"', place="--split-by", wanted=wanted)
    return column


def units(captures: Iterable[Capture], column: str) -> dict[int, str]:
    """Return by number of capture what must stay in one split with it, as a name."""
    above: dict[str, str] = {}

    def top(key: str) -> str:
        while (over := above.setdefault(key, key)) != key:
            above[key] = above[over]
            key = over
        return key

    own: dict[int, str] = {}
    for one in captures:
        who = one.metadata.get(column, "") if column else ""
        person = one.path.partition(SUBJECT)[2] if who else ""
        content = f"content {one.sha256} {person}"
        own[one.id] = content
        if who:
            first, last = sorted((top(content), top(f"performer {who}")))
            above[first] = last  # a performer's name stays on top: it sorts behind contents
    return {number: top(key) for number, key in own.items()}


def read_shares(text: str) -> tuple[Fraction, ...]:
    """Return the shares of training, validation and testing: ``80/10/10``."""
    try:
        shares = tuple(Fraction(one) / 100 for one in text.split("/"))
    except (ValueError, ZeroDivisionError):
        shares = ()
    if len(shares) != len(SPLITS) or sum(shares) != 1 or min(shares) < 0:
        wanted = "training/validation/testing in per cent, such as 80/10/10"
        raise UsageError(f'"{shown(text)}"', place="--split", wanted=wanted)
    return shares


def split(weights: Mapping[str, int], shares: Sequence[Fraction], seed: int = 0) -> dict[str, str]:
    """Return the split of each unit."""
    total = sum(weights.values())
    lacking = {name: share * total for name, share in zip(SPLITS, shares, strict=True) if share}
    order = sorted(weights, key=lambda unit: sha256(f"{seed} {unit}".encode()).digest())
    found: dict[str, str] = {}
    given: Counter[str] = Counter()
    for left, unit in zip(range(len(order), 0, -1), order, strict=True):
        empty = [name for name in lacking if not given[name]]
        choice = empty if left <= len(empty) else list(lacking)
        name = max(choice, key=lambda one: lacking[one])
        lacking[name] -= weights[unit]
        given[name] += 1
        found[unit] = name
    return found
