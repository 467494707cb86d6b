"""A stretch of an MVNX file, byte for byte."""

from __future__ import annotations

import io
from collections.abc import Callable, Iterator

from lanindex.formats.file import PIECE, File
from lanindex.formats.mvnx.walk import LARGEST_TAG, Subject, chosen, walk
from lanindex.model import Reading, Span


def subjects(file: File) -> tuple[str, ...]:
    """Return the names of the people in a file."""
    return tuple(subject.name for subject in walk(file, False))


def cutter(file: File, told: Reading | None = None) -> Callable[[Span], bytes]:
    """Return what cuts clips out of an MVNX file, which is looked through once.

    What is kept is the source's, byte for byte: frames keep their numbers and times, which tell
    when they were; poses of the calibration stay in front. Of several people only the one is kept
    that is read.
    """
    people = walk(file, False)
    meant = chosen(people, file)

    def cut(span: Span) -> bytes:
        clip = io.BytesIO()
        at = 0
        for start, stop in (*_left_out(people, meant, file, span), (len(file.content), 0)):
            for piece in range(at, start, PIECE):
                clip.write(file.content[piece : min(piece + PIECE, start)])
            at = stop
        return clip.getvalue()

    return cut


def _left_out(
    people: list[Subject], meant: Subject, file: File, span: Span
) -> Iterator[tuple[int, int]]:
    """Yield the bytes that are no part of a clip, in their order."""
    for subject in people:
        if subject is meant:
            frames = subject.frames
            yield frames[0][0], frames[span.start][0]
            yield frames[span.stop - 1][1], frames[-1][1]  # from one closing tag to the last
        else:
            closing = file.content[subject.stop : subject.stop + LARGEST_TAG]
            yield subject.start, subject.stop + closing.find(b">") + 1
