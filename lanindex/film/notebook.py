"""HTML for notebooks: a score as its staff, a motion as poses, hits with pictures.

The `_repr_html_` methods of these classes call it; nothing is loaded until one is shown. What is
shown is bounded, however long a score or a result is.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from lanindex.film.figure import Figure
    from lanindex.film.hits import Playback
    from lanindex.model import Hit, Motion, Score

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
        return title + _poses([_played(figure(motion), 0, len(motion), ())])[0]
    except LanindexError as error:
        return f"{title}<p>{escape(str(error))}</p>"


def of_hit(hit: Hit) -> str:
    """Return a hit as HTML: some poses, if its file is unchanged, and the symbols that matched."""
    (drawn,) = _poses([_hit(hit, {})])
    return f"<p>{escape(repr(hit)[1:-1])}</p>{drawn}{_strip(hit)}"


def of_hits(table: str, hits: Iterable[Hit]) -> str:
    """Return an HTML table of hits with pictures of them, all seen from one side."""
    figures: dict[str, Figure | str] = {}
    head, *rows = table.split("</tr>")
    for number, drawn in enumerate(_poses([_hit(hit, figures) for hit in hits])):
        rows[number] += f"<td>{drawn}</td>"
    return "</tr>".join([f"{head}<th>poses</th>", *rows])


def _hit(hit: Hit, figures: dict[str, Figure | str]) -> Playback | str:
    """Return what moves in a hit, or the reason why its file cannot be shown."""
    place = hit.capture.location
    if place not in figures:
        figures.clear()  # one capture at a time is held
        figures[place] = _figure(hit)
    if isinstance(body := figures[place], str):
        return body
    return _played(body, hit.start, hit.stop, (it.part for it in hit.symbols))


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


def _played(body: Figure, start: int, stop: int, parts: Iterable[str]) -> Playback | str:
    """Return a stretch of a body as sheets show it, or why it cannot be shown."""
    from lanindex.film.hits import playback

    seconds = float(start / body.rate), float(max(stop, start + 1) / body.rate)
    return playback(body, parts, seconds, seconds) or "no joint is known meanwhile"


def _poses(stretches: Sequence[Playback | str]) -> list[str]:
    """Return poses of stretches as they stand on sheets, and when each is, all from one side."""
    from dataclasses import replace

    from lanindex.draw import svg
    from lanindex.draw.picture import Label
    from lanindex.film.hits import HEIGHT, WIDTH, legend, poses, seen_from

    eye, drawn = seen_from(it for it in stretches if not isinstance(it, str)), []
    for played in stretches:
        if isinstance(played, str):
            drawn.append(f"<small>{escape(played)}</small>")
            continue
        picture = poses(played, eye, "a movement")
        times = (played.start + played.poses / len(played.body) * played.seconds).tolist()
        labels = [
            Label(WIDTH * at + WIDTH // 2, HEIGHT + 120, f"{time:.2f} s", 140)
            for at, time in enumerate(times)
        ]
        picture = replace(picture, height=HEIGHT + 160, marks=(*picture.marks, *labels))
        drawn.append(f"{svg.write(picture, scale=0.8)}<br><small>{legend('span')}</small>")
    return drawn


def _strip(hit: Hit) -> str:
    """Return the symbols that matched as a staff."""
    from lanindex import records
    from lanindex.draw import draw, svg
    from lanindex.notation.tables import score_of

    if not (symbols := dict.fromkeys(hit.symbols[:SYMBOLS])):
        return ""
    score = score_of((("", records.of_row(hit.capture, it)) for it in symbols), hit.path)
    first, last = min(it.start for it in symbols), max(hit.stop, *(it.stop for it in symbols))
    start, stop = (float(it / score.rate) for it in (first, max(last, first + 1)))
    return _scrollable(svg.write(draw(score, start=start, stop=stop, bars=None, seconds=True)))


def _scrollable(drawn: str) -> str:
    return f'<div style="overflow:auto;max-height:60em">{drawn}</div>'
