"""HTML for notebooks: a score as its staff, a motion as poses, hits with pictures.

The `_repr_html_` methods of these classes call it; nothing is loaded until one is shown. What is
shown is bounded, however long a score or a result is.
"""

from __future__ import annotations

from collections.abc import Iterable
from html import escape
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from lanindex.film.figure import Figure
    from lanindex.model import Hit, Motion, Score, Symbol

SYMBOLS = 400  # symbols of a staff that is shown

LARGE = 100_000_000  # bytes from which on a file is too large to be read for a picture


def of_score(score: Score) -> str:
    """Return the staff of a score as HTML, or its beginning if the score is long."""
    from lanindex.draw import draw, svg
    from lanindex.draw.plain import plain

    starts = sorted(start for it in score.tracks.values() for start in it.symbols["start"].tolist())
    title, stop = escape(repr(score)), None
    if not starts:
        return f"<p>{title}</p>"
    if len(starts) > SYMBOLS:
        stop = max(float((starts[SYMBOLS] + 1) / score.rate), 1.0)
        title += f": the first {min(stop, float(score.frames / score.rate)):.1f} s"
    return f"<p>{title}</p>{_scrollable(svg.write(draw(plain(score), stop=stop, bars=None)))}"


def of_motion(motion: Motion) -> str:
    """Return some poses of a motion as HTML."""
    from lanindex.errors import LanindexError
    from lanindex.film.figure import figure

    title = f"<p>{escape(repr(motion))}</p>"
    try:
        return title + _poses(figure(motion), 0, len(motion), ())
    except LanindexError as error:
        return f"{title}<p>{escape(str(error))}</p>"


def of_hit(hit: Hit) -> str:
    """Return a hit as HTML: some poses, if its file is unchanged, and the symbols that matched."""
    return f"<p>{escape(repr(hit)[1:-1])}</p>{_poses_or_reason(hit, {})}{_strip(hit)}"


def of_hits(table: str, hits: Iterable[Hit]) -> str:
    """Return an HTML table of hits with pictures of them."""
    figures: dict[str, Figure | str] = {}
    head, *rows = table.split("</tr>")
    for number, hit in enumerate(hits):
        rows[number] += f"<td>{_poses_or_reason(hit, figures)}</td>"
    return "</tr>".join([f"{head}<th>poses</th>", *rows])


def _poses_or_reason(hit: Hit, figures: dict[str, Figure | str]) -> str:
    """Return poses of a hit, or the reason why its file cannot be shown."""
    from lanindex.errors import LanindexError

    place = hit.capture.location
    if place not in figures:
        figures.clear()  # one capture at a time is held
        figures[place] = _figure(hit)
    figure = figures[place]
    if isinstance(figure, str):
        return f"<small>{escape(figure)}</small>"
    try:
        return _poses(figure, hit.start, hit.stop, dict.fromkeys(it.part for it in hit.symbols))
    except LanindexError as error:
        return f"<small>{escape(str(error))}</small>"


def _figure(hit: Hit) -> Figure | str:
    """Return the figure of a hit's capture, or the reason why it cannot be shown."""
    from lanindex import formats
    from lanindex.errors import LanindexError
    from lanindex.film.figure import figure
    from lanindex.model import Reading
    from lanindex.notation import NOTATIONS

    capture = hit.capture
    if capture.format in NOTATIONS:
        return "a score, without motion"
    try:
        file = formats.opened(capture.location)
        if len(file.content) > LARGE:
            return f"a file of {len(file.content) / 1e6:.0f} MB"
        if file.sha256() != capture.sha256:
            return "its file has changed since it was ingested"
        motion = formats.read_file(file, Reading(**capture.options), formats.Wanted(body_only=True))
        if len(motion) != capture.frames:
            return "its file reads otherwise than when it was ingested"
        return figure(motion)
    except LanindexError as error:
        return str(error)


def _poses(body: Figure, start: int, stop: int, parts: Iterable[str]) -> str:
    """Return poses of a stretch as they stand on sheets, and when each is."""
    from dataclasses import replace

    import numpy as np

    from lanindex.draw import svg
    from lanindex.draw.picture import Label
    from lanindex.film.figure import view
    from lanindex.film.hits import FRAMES, HEIGHT, WIDTH, different, kinds_of, poses

    tracks = list(parts)
    frames = np.linspace(start, max(stop - 1, start), FRAMES).round().astype(np.int64)
    if np.isnan(body.places[frames]).all():
        return "<small>no joint is known meanwhile</small>"
    eye, frames = view(body, tracks or None, start, stop), different(body, frames)
    drawn = poses(body, frames, kinds_of(body, tracks), eye, "a movement")
    times = [
        Label(WIDTH * at + WIDTH // 2, HEIGHT + 120, f"{float(frame / body.rate):.2f} s", 140)
        for at, frame in enumerate(frames.tolist())
    ]
    return svg.write(replace(drawn, height=HEIGHT + 160, marks=(*drawn.marks, *times)), scale=0.8)


def _strip(hit: Hit) -> str:
    """Return the symbols that matched as a staff."""
    import numpy as np

    from lanindex.draw import draw, svg
    from lanindex.model import Score, Span, Track
    from lanindex.model.symbol import FIELDS, blank

    if not hit.symbols:
        return ""
    by_part: dict[str, list[Symbol]] = {}
    for symbol in sorted(hit.symbols[:SYMBOLS], key=lambda one: one.start):
        by_part.setdefault(symbol.part, []).append(symbol)
    first = min(it.start for it in hit.symbols)
    last = max(hit.stop, first + 1, *(it.stop for it in hit.symbols))
    tracks = {}
    for part, symbols in by_part.items():
        rows = blank(len(symbols))
        for row, symbol in zip(rows, symbols, strict=True):
            for name in ("direction", "level"):
                if (word := getattr(symbol, name)) is not None:
                    row[name] = FIELDS[name].words.index(word)
            row["amount"] = -1 if symbol.amount is None else symbol.amount
            row["start"], row["stop"] = symbol.start - first, symbol.stop - first
            row["ticks"] = np.int32(symbol.stop > symbol.start)
        tracks[part] = Track(part, rows, (Span(0, last - first),))
    score = Score(hit.capture.rate, last - first, hit.capture.meter, tracks)
    return _scrollable(svg.write(draw(score, bars=None, seconds=True)))


def _scrollable(drawn: str) -> str:
    return f'<div style="overflow:auto;max-height:60em">{drawn}</div>'
