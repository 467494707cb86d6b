"""Who is meant of several people in a file, and which of several takes."""

import unicodedata
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, TypeVar

from numpy.typing import NDArray

from lanindex.errors import BodyError, CaptureError, quoted
from lanindex.formats.file import File

T = TypeVar("T")

_SHOWN = 10

_LONGEST = 100
"""Letters of a name at most: file systems take names of 255 bytes, the file's among them."""


def person(file: File, names: Sequence[str]) -> tuple[str, tuple[str, ...]]:
    """Return the name of who is meant, and a doubt where others are there and nobody is named."""
    name = file.subject or names[0]
    if name not in names:
        raise CaptureError(
            f"has nobody called {quoted(name)}", place=file.name, wanted=" or ".join(names)
        )
    if file.subject or len(names) < 2:
        return name, ()
    return name, (f"{name} is read; it holds also {others(names, name)}",)


def subject_points(
    file: File, subjects: Mapping[str, T], all_points: T
) -> tuple[T, tuple[str, ...]]:
    """Return the points of the subject that is meant, or of all, and a doubt about others."""
    if file.subject:
        if file.subject not in subjects:
            raise CaptureError(
                f"has no subject {quoted(file.subject)} that makes a body",
                place=file.name,
                wanted=" or ".join(filter(None, subjects)) or "none: its subjects have no names",
            )
        return subjects[file.subject], ()
    if not subjects:
        return all_points, ()
    first, *rest = subjects
    doubt = f"{first or 'the first subject'} is read; it holds also {', '.join(rest)}"
    return subjects[first], (doubt,) if rest else ()


def is_human(names: tuple[str, ...], parents: tuple[int, ...], poses: NDArray[Any]) -> bool:
    """Return whether joints in some poses (S, J, 3) make a body."""
    from lanindex.body.recognition import Rig, find_body

    try:
        find_body(Rig(names, parents, poses))
    except BodyError:
        return False
    return True


def take_doubt(names: Sequence[str], read: str, take: str | None) -> tuple[str, ...]:
    """Return a doubt where there are other takes than the one that is read, and none is named."""
    if take is not None or len(names) < 2:
        return ()
    return (f"the take {read} is read; it holds also {others(names, read)}",)


def others(names: Iterable[str], but: str = "") -> str:
    """Return names but one, not too many."""
    left = [name for name in names if name != but]
    more = f" and {len(left) - _SHOWN} more" if len(left) > _SHOWN else ""
    return ", ".join(left[:_SHOWN]) + more


def distinct(names: Sequence[str], numbers: Sequence[int]) -> tuple[str, ...]:
    """Return names that are each its own: what has none, or one that was there, has its number."""
    taken = dict[str, None]()
    for name, number in zip(names, numbers, strict=True):
        called = name or f"node {number}"
        called = called if called not in taken else f"{called} {number}"
        while called in taken:
            called += "'"
        taken[called] = None
    return tuple(taken)


def plain(name: str) -> str:
    """Return a name as it can stand in a path behind ``#``: NFC, printable, 100 letters at most."""
    letters = unicodedata.normalize("NFC", name.strip())
    kept = (it if it.isprintable() and it not in "/\\#" else "_" for it in letters)
    return "".join(kept)[:_LONGEST].strip()


def named(by_name: Mapping[str, T]) -> dict[str, T]:
    """Return people by names that are `plain`: a name that another has gets a number."""
    people = dict[str, T]()
    for number, (name, one) in enumerate(by_name.items(), 1):
        called = plain(name)
        if called in people or bool(name) > bool(called):
            called = f"{called} {number}".strip()
        while called in people:
            called += "'"
        people[called] = one
    return people
