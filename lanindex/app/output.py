"""What reaches standard output and standard error, for people and for pipes.

Whatever comes from files, tables, names or arguments is escaped here, so that no character of it
can steer the terminal.
"""

from __future__ import annotations

import os
import shutil
import sys
import unicodedata
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cache
from time import monotonic
from typing import TYPE_CHECKING, Annotated, Any, TextIO

from typer import Option

from lanindex.errors import PatternError, UsageError

if TYPE_CHECKING:
    from rich.progress import Progress, Task

    from lanindex.draw.text import TextStaff
    from lanindex.model import Capture, Hit, Track
    from lanindex.pipeline.library import Library

_UNSEEN = (0x061C, 0x200E, 0x200F, *range(0x2028, 0x202F), *range(0x2066, 0x206A))
ESCAPED = {
    **{code: f"\\x{code:02x}" for code in (*range(0x20), *range(0x7F, 0xA0))},
    **{code: f"\\u{code:04x}" for code in _UNSEEN},
    **{0xDC00 + byte: f"\\x{byte:02x}" for byte in range(0x80, 0x100)},
}
"""Characters that would steer a terminal (C0, DEL, C1) or invisibly turn and break its lines
(bidirectional marks, line and paragraph separators), and bytes of a file's name that are not UTF-8,
each with what is shown instead."""

_IN_JSON = {code: f"\\u{code:04x}" for code in ESCAPED if code >= 0x7F}

STYLES = {"path": "35", "place": "32", "match": "1;31", "dim": "2", "warn": "33"}
"""Terminal styles by meaning (ECMA-48)."""

PATIENCE = 0.5  # seconds before a job's progress is shown
LEAST = 12  # least cells of a column of words, however narrow the terminal is
NARROW = 24  # least cells for the symbols of a hit to be wrapped below each other


class Painted(str):
    """Text already escaped, with the program's own colours."""

    __slots__ = ()


def escaped(text: str) -> str:
    """Return text that is safe to print: what would steer a terminal is escaped."""
    return text if isinstance(text, Painted) or text.isprintable() else text.translate(ESCAPED)


@dataclass(frozen=True)
class Output:
    """What the user asked to see, by options of every verb."""

    json: Annotated[bool, Option("--json", help="Print JSON lines.")] = False
    quiet: Annotated[bool, Option("-q", "--quiet", help="Print results and errors only.")] = False
    verbose: Annotated[bool, Option("-v", "--verbose", help="Print more on standard error.")] = (
        False
    )
    color: Annotated[str, Option(metavar="auto|always|never", help="When to use colour.")] = "auto"

    def __post_init__(self) -> None:
        choice("--color", self.color, ("auto", "always", "never"))

    @property
    def terminal(self) -> bool:
        """Whether standard output is a terminal and not JSON."""
        return sys.stdout.isatty() and not self.json

    @property
    def unicode(self) -> bool:
        """Whether standard output can print every character."""
        return (sys.stdout.encoding or "").lower().startswith("utf")

    def paint(self, text: str, style: str) -> str:
        """Return text in a style, if colours are on."""
        wanted = self.color == "always" or (
            self.color == "auto" and self.terminal and not os.environ.get("NO_COLOR")
        )
        return Painted(f"\x1b[{STYLES[style]}m{escaped(text)}\x1b[0m") if wanted else text

    def line(self, *pieces: str) -> None:
        """Print a line of results, made of plain and painted pieces."""
        _say("".join(map(escaped, pieces)), sys.stdout)

    def text(self, text: str) -> None:
        """Print lines of results."""
        for line in text.split("\n"):
            self.line(line)

    def folder(self, paths: Iterable[str]) -> str:
        """Print on a terminal the folders that several paths have in common, and return them."""
        from lanindex.model.capture import common_folder

        common = common_folder(paths) if self.terminal else ""
        if common.strip("./"):
            self.line(self.paint(common, "dim"))
        return common

    def content(self, text: str) -> None:
        """Print a file: unchanged to a pipe, escaped to a terminal."""
        text = text.removesuffix("\n")
        self.text(text) if self.terminal else _say(text, sys.stdout)

    def record(self, values: dict[str, Any]) -> None:
        """Print a result as a JSON line."""
        line = _encode(ascii=not self.unicode)(values)
        if "\x7f" in line or not (line.isascii() or line.isprintable()):
            line = line.translate(_IN_JSON)  # JSON escapes all before the space
        _say(line, sys.stdout)

    def records(self, values: Iterable[dict[str, Any]]) -> None:
        """Print results as JSON lines."""
        for value in values:
            self.record(value)

    def row(self, values: Iterable[Any], record: dict[str, Any] | None = None) -> None:
        """Print a result as tab-separated fields, or its `record` as JSON."""
        if self.json and record is not None:
            return self.record(record)
        texts = list(map(str, values))
        if not "".join(texts).isprintable():
            texts = list(map(escaped, texts))
        _say("\t".join(texts), sys.stdout)

    def note(self, line: str) -> None:
        """Print a note on standard error, unless --quiet."""
        if not self.quiet:
            _say(escaped(line), sys.stderr)

    def notes(self, lines: Iterable[str], about: object = "") -> None:
        """Print notes, each behind what it is about."""
        for line in lines:
            self.note(f"{about}: {line}" if about else line)

    def detail(self, line: str) -> None:
        """Print a note on standard error if --verbose."""
        if self.verbose:
            _say(escaped(line), sys.stderr)

    def table(
        self,
        head: Sequence[str],
        rows: Iterable[Sequence[Any]],
        records: Iterable[dict[str, Any]] = (),
    ) -> None:
        """Print rows as columns that fit the terminal or tab-separated, or `records` as JSON."""
        if self.json:
            self.records(records)
        elif not self.terminal:
            for row in (head, *rows):
                self.row(row)
        else:
            lines = [[escaped(str(cell)) for cell in row] for row in (head, *rows)]
            for index, text in enumerate(aligned(lines)):
                self.line(self.paint(text, "dim") if index == 0 else text)

    def watch(self, noun: str, done: int, total: int) -> None:
        """Note how far a job is; if it takes a while, a bar shows it until a line is printed."""
        is_new, now = (noun, total) != (_job.noun, _job.total), monotonic()
        _job.noun, _job.done, _job.total = noun, done, total
        _job.begun = now if _job.begun is None else _job.begun
        hidden = self.quiet or not sys.stderr.isatty() or os.environ.get("TERM") == "dumb"
        over = done >= total and _job.bar is None
        if hidden or over or now - _job.begun < PATIENCE:
            return
        if _job.bar is None or is_new:
            _remove_bar()
            _job.bar = self._bar(noun, done, total)
        # the end of a job is drawn at once
        _job.bar.update(_job.bar.task_ids[0], completed=done, refresh=done >= total)

    def progress(self, items: Iterator[Any], total: int, noun: str) -> Iterator[Any]:
        """Yield items, and note how many are done."""
        for done, item in enumerate(items):
            self.watch(noun, done, total)
            yield item
        self.watch(noun, total, total)

    def _bar(self, noun: str, done: int, total: int) -> Progress:
        """Draw a bar: things done of a number, their rate and the time that is left."""
        from rich import progress  # takes long to import
        from rich.console import Console
        from rich.text import Text

        class Rate(progress.ProgressColumn):
            def render(self, task: Task) -> Text:
                rate = task.finished_speed or task.speed
                return Text(f"{rate:.3g}/s" if rate else "")

        bar = progress.Progress(
            progress.BarColumn(bar_width=20),
            progress.MofNCompleteColumn(),
            progress.TextColumn(noun),
            Rate(),
            progress.TimeRemainingColumn(),
            console=Console(stderr=True, no_color=True if self.color == "never" else None),
            transient=True,
            redirect_stdout=False,  # other lines step aside by themselves
            redirect_stderr=False,
        )
        bar.add_task(noun, total=total, completed=done)
        bar.start()
        return bar


@dataclass
class _Job:
    """How far the running job is, and the bar that shows it."""

    noun: str = ""
    done: int = 0
    total: int = 0
    begun: float | None = None
    bar: Progress | None = None


_job = _Job()


def how_far() -> str:
    """Return how far the running job is: `` after 12 of 300 captures``; empty if there is none."""
    return f" after {_job.done:,} of {_job.total:,} {_job.noun}" if _job.total > 1 else ""


def say_error(error: Exception | str) -> None:
    """Print an error on standard error: one line, or a pattern with a caret below the word."""
    text, drawing = str(error), error if isinstance(error, PatternError) else None
    if isinstance(error, Exception) and isinstance(error.__cause__, PatternError):
        drawing, text = error.__cause__, text.removesuffix(f"\n{error.__cause__}")
    if drawing is not error:
        _say(f"lanindex: {escaped(text)}", sys.stderr)
    if drawing is not None:
        line, start, stop = drawing.line()
        before, meant = escaped(line[:start]), escaped(line[start:stop])
        if drawing.place:
            _say(f"{escaped(drawing.place)}:", sys.stderr)
        _say(f"{before}{meant}{escaped(line[stop:])}", sys.stderr)
        _say(" " * width(before) + "^" * max(1, width(meant)), sys.stderr)
        _say(escaped(drawing.found), sys.stderr)


def duration(seconds: float) -> str:
    """Return a readable time: 3.2 s, 4:05 min, 2:10 h."""
    if seconds < 60:
        return f"{seconds:.1f} s"
    whole = round(seconds)
    if whole < 3600:
        return f"{whole // 60}:{whole % 60:02d} min"
    return f"{whole // 3600}:{whole % 3600 // 60:02d} h"


def cut_note(shown: int, total: int) -> str:
    """Return the end of a summary that says how many results are shown, if not all."""
    verb = "is" if shown == 1 else "are"
    return f"; {shown} {verb} shown, --limit shows more" if shown < total else ""


def end_progress() -> None:
    """Remove the bar from the terminal and forget the job."""
    global _job
    _remove_bar()
    _job = _Job()


def _remove_bar() -> None:
    if _job.bar is not None:
        _job.bar.stop()


def choice(name: str, value: str, choices: Sequence[str]) -> None:
    """Refuse a value that is none of the choices."""
    if value not in choices:
        raise UsageError(f'"{value}"', place=name, wanted=" or ".join(choices))


def _say(line: str, stream: TextIO) -> None:
    """Print a line; the bar of the running job is removed before it."""
    if _job.noun:
        end_progress()
    print(line, file=stream, flush=stream is sys.stderr)


@cache
def _encode(*, ascii: bool) -> Callable[[Any], str]:
    """Return a JSON encoder; `json.dumps` would make one for each value."""
    from json import JSONEncoder

    return JSONEncoder(ensure_ascii=ascii, check_circular=False).encode


def width(text: str) -> int:
    """Return how many cells of a terminal a text takes: wide characters take two."""
    return len(text) if text.isascii() else sum(map(_cells, text))


def _cells(character: str) -> int:
    if unicodedata.category(character) in ("Mn", "Me", "Cf"):
        return 0
    return 2 if unicodedata.east_asian_width(character) in "WF" else 1


def cut(text: str, most: int) -> str:
    """Return a text of at most `most` cells, with ``…`` for its middle if it is longer."""
    if width(text) <= most:
        return text
    room = most - 1
    tail = _prefix(text[::-1], room // 2)[::-1]
    while tail and not _cells(tail[0]):  # a mark on a character that is cut
        tail = tail[1:]
    return f"{_prefix(text, room - room // 2)}…{tail}"


def _prefix(text: str, most: int) -> str:
    taken = 0
    for index, character in enumerate(text):
        taken += _cells(character)
        if taken > most:
            return text[:index]
    return text


def wrapped(pieces: Iterable[str], most: int) -> list[str]:
    """Return pieces joined by commas, on lines of at most `most` cells if possible."""
    lines = [""]
    for piece in pieces:
        longer = f"{lines[-1]}, {piece}" if lines[-1] else piece
        if lines[-1] and width(longer) >= most:  # a comma may follow
            lines[-1] += ","
            lines.append(piece)
        else:
            lines[-1] = longer
    return lines


def aligned(lines: Sequence[Sequence[str]]) -> Iterator[str]:
    """Yield lines of cells, the head first, as columns that fit the terminal.

    Numbers are aligned to the right and never cut. The widest columns of words shrink first, none
    below `LEAST`; if that is not enough, the gaps between columns do.
    """
    widths = _column_widths(list(zip(*lines, strict=True)))
    gap = "  " if sum(widths) + 2 * (len(widths) - 1) <= room() else " "
    for line in lines:
        cells = (_pad(cell, most) for cell, most in zip(line, widths, strict=True))
        yield gap.join(cells).rstrip()


def _column_widths(columns: Sequence[Sequence[str]]) -> list[int]:
    widths = [max(map(width, column)) for column in columns]
    words = [at for at, column in enumerate(columns) if any(map(str.isalpha, "".join(column[1:])))]
    over = sum(widths) + 2 * (len(widths) - 1) - room()
    while over > 0 and (wide := [at for at in words if widths[at] > LEAST]):
        widths[max(wide, key=widths.__getitem__)] -= 1
        over -= 1
    return widths


def room() -> int:
    """Return how many cells a line of the terminal has."""
    return shutil.get_terminal_size().columns


def _pad(cell: str, most: int) -> str:
    cell = cut(cell, most)
    space = " " * (most - width(cell))
    numeric = cell.replace(".", "", 1).lstrip("-").isdigit()
    return space + cell if numeric else cell + space


def print_hits(out: Output, hits: Sequence[Hit], pattern: str) -> None:
    """Print hits: grouped by capture on a terminal, else a line each."""
    from lanindex import records
    from lanindex.model.capture import in_words

    if out.json:
        out.records(records.of_hit(hit, pattern) for hit in hits)
        return
    terminal, last = out.terminal, None
    folder = out.folder(hit.path for hit in hits) if terminal else ""
    for hit in hits:
        capture, symbols = hit.capture, in_words(hit.symbols)
        begin, end = (records.seconds(capture, frame) for frame in (hit.start, hit.stop))
        if not terminal:
            times = hit.start, hit.stop, begin, end
            out.row([capture.path, *times, round(hit.fit, 3), ", ".join(symbols)])
            continue
        if capture.id != last:
            if last is not None:
                out.line()
            label = ("  ", out.paint(capture.label, "dim")) if capture.label else ()
            out.line(out.paint(capture.path.removeprefix(folder), "path"), *label)
            last = capture.id
        time, frames = f"{begin:8.2f}-{end:.2f} s", f"[{hit.start}, {hit.stop})"
        fit = f"  fit {hit.fit:.2f}  "
        indent = " " * len(f"{time}  {frames}{fit}")
        left = room() - len(indent)
        first, *others = wrapped(symbols, left if left >= NARROW else sys.maxsize)
        out.line(out.paint(time, "place"), "  ", out.paint(frames, "dim"), fit, first)
        for other in others:
            out.line(indent, other)


def print_staff(
    out: Output, capture: Capture, tracks: dict[str, Track], parts: Sequence[str] | None
) -> None:
    """Print the staff of a capture: of some parts, or of those that move."""
    staff = _staff_of(out, capture, tracks)
    out.line(out.paint(capture.path, "path"))
    _print_lines(out, staff, parts=parts)
    out.note(staff.signs.legend)


def print_hits_with_staves(out: Output, library: Library, shown: Iterable[Hit], pad: str) -> None:
    """Print hits, each with the staff of the symbols around it."""
    from lanindex.pipeline.export import pad_frames, padded

    number, staff = -1, None
    for hit in shown:
        capture = hit.capture
        if staff is None or capture.id != number:
            ((_, tracks),) = library.tracks([capture.id])
            number, staff = capture.id, _staff_of(out, capture, tracks)
        print_hits(out, [hit], "")
        span = padded(hit.span, pad_frames(pad, capture.rate), capture.frames)
        _print_lines(out, staff, start=span.start, stop=span.stop, marked=hit.symbols)
        out.line()
    if staff is not None:
        out.note(staff.signs.legend)


def _staff_of(out: Output, capture: Capture, tracks: dict[str, Track]) -> TextStaff:
    """Return a capture's staff, in characters that standard output can print."""
    from lanindex.draw.text import ASCII, UNICODE, TextStaff
    from lanindex.model import Score

    score = Score(capture.rate, capture.frames, capture.meter, tracks)
    return TextStaff(score, UNICODE if out.unicode else ASCII)


def _print_lines(out: Output, staff: TextStaff, **stretch: Any) -> None:
    """Print some lines of a staff: `stretch` are the options of its `lines`."""
    for line in staff.lines(**stretch, width=room() if out.terminal else None):
        out.line(*(out.paint(text, style) if style else text for text, style in line))
