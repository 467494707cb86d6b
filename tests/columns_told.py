"""What the columns of a library are, what they should be, and damage to bytes."""

from dataclasses import replace

from lanindex.library.segments import read_spine
from lanindex.library.stats import count
from lanindex.library.store import Store
from lanindex.model.columns import EXTRA, columns_of, roster_of

PARTS = ("r_arm", "l_arm", "head", "tail")
NAMES = ("bounds", "cell", "runner", "margin", "start", "stop", "seen", *EXTRA)
CALLED = ("path", "location", "format", "label", "metadata")
ROSTER = ("number", "frames", "rate", "speed")


def told(roster, columns, called):
    parts = {part: [getattr(one, name).tolist() for name in NAMES] for part, one in columns.items()}
    return [getattr(roster, name).tolist() for name in ROSTER], parts, called


def by_rows(path):
    """Return what the columns should be."""
    with Store.open(path, readonly=True) as library:
        held = list(library.tracks())
        with library.session.reading() as connection:
            counts = count(connection, read_spine(connection, trusted=False), 0)
    captures = [capture for capture, _ in held]
    columns = {
        part: columns_of(part, captures, [tracks.get(part) for _, tracks in held]) for part in PARTS
    }
    called = {name: {one.id: getattr(one, name) for one in captures} for name in CALLED}
    return told(roster_of(captures), columns, {**called, "counts": counts})


def given(library):
    """Return what the columns are."""
    called = {name: library.texts(name) for name in CALLED}
    called["counts"] = replace(library.stats(), size=0)
    return told(*library.columns(PARTS, more=EXTRA), called)


def found(path, **how):
    """Return what the columns are, and what is said of them."""
    with Store.open(path, **({"readonly": True} | how)) as library:
        return given(library), library.session.notes


def flip(content, choice):
    """Turn a bit over."""
    changed = bytearray(content)
    changed[choice.randrange(len(changed))] ^= 1 << choice.randrange(8)
    return bytes(changed)


def cut(content, choice):
    """Keep the beginning, the end, or all with more behind it."""
    place = choice.randrange(len(content))
    return choice.choice([content[:place], content[place + 1 :], content + content[: place + 1]])
