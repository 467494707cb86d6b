"""Previews of hits, as a page in HTML that plays them, or as a sheet of pictures."""

import json
from base64 import b64encode
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import groupby
from math import ceil, sqrt
from operator import itemgetter
from pathlib import Path
from string import Template

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import TRACKS
from lanindex.draw import Picture, draw, svg
from lanindex.draw.picture import PIXEL, Label, Mark, Polyline, line
from lanindex.draw.staff import BEAT, MARGIN, NAMES, START, keys_of
from lanindex.draw.svg import BODY, INK
from lanindex.errors import UsageError
from lanindex.film.figure import BAND, HEAD, LEGEND, Figure, Strokes, View, faced, stood, view
from lanindex.film.tiles import UNKNOWN
from lanindex.model import Hit, Score
from lanindex.model.capture import in_words

POSES = 5  # poses of a hit, from its first frame to its last
WIDTH, HEIGHT = 800, 1420  # of a pose, units
STAFF = 1000  # height of a hit's staff, units, its starting position apart
LEAST = 1.0  # seconds that are played and written of a hit, at least
# Frames a second that can be played, at most, and frames of a hit: of a longer one fewer a second
RATE, FRAMES = 30, 300

_BELOW = 2 * MARGIN + START
_FLOOR = 60  # units below the feet
_THIN = 30  # units that strokes are thick, at least
_ROUND = HEAD + BAND / 2  # mm that strokes reach beyond joints
_WIDEST = 200.0  # mm that are shown, at least
_TIME = 0.1  # of how far poses differ at most: as much the first differs from the last by its time


@dataclass(frozen=True, slots=True, eq=False)
class Playback:
    """The movement of a hit, as the page plays it."""

    body: Figure  # What is played, seen from the front
    poses: NDArray[np.int64]  # (P) frames of it that differ most
    parts: tuple[str, ...]  # Tracks that matched
    start: float  # Seconds into the capture
    seconds: float  # How long it lasts
    hit: tuple[float, float]  # Start and end of the hit within these seconds


@dataclass(frozen=True, slots=True, eq=False)
class HitPreview:
    """A hit with its staff and its movement."""

    path: str  # Of the capture
    label: str
    when: str  # Its seconds
    words: str  # Its symbols
    staff: Picture | None = None  # Its symbols on a staff
    base: int = 0  # Where the staff begins, units from above
    beat: int = BEAT  # Units of a second
    played: Playback | None = None
    trouble: str = ""  # Why there is nothing to play

    @property
    def caption(self) -> str:
        """When it is, its label and its symbols."""
        return " \u00b7 ".join(filter(None, (self.when, self.label, self.words)))


def preview_of(score: Score, hit: Hit, body: Figure | None, trouble: str = "") -> HitPreview:
    """Return the preview of a hit: of its capture's score, and of its body if there is one."""
    rate = hit.capture.rate
    start, stop, whole = (float(it / rate) for it in (hit.start, hit.stop, hit.capture.frames))
    begin = min(start - (LEAST - (stop - start)) / 2, start, whole - LEAST)  # at least a second
    begin = max(begin, 0.0)
    end = max(stop, min(begin + LEAST, whole))
    beat = max(round(STAFF / max(end - begin, LEAST)), 1)
    staff = _staff(score, hit, begin, end, beat)
    shot = HitPreview(
        hit.path,
        hit.capture.label,
        f"{start:.2f}-{stop:.2f} s",
        ", ".join(in_words(hit.symbols)),
        staff,
        staff.height - _BELOW if staff else 0,
        beat,
        trouble=trouble,
    )
    if body is None:
        return shot
    played = playback(body, (it.part for it in hit.symbols), (start, stop), (begin, end))
    return replace(shot, played=played, trouble="" if played else "no joint is known meanwhile")


def playback(
    body: Figure, parts: Iterable[str], hit: tuple[float, float], shown: tuple[float, float]
) -> Playback | None:
    """Return a hit as it is played, its parts, seconds and those around; None: nothing is known."""
    (begin, end), own = shown, _frames(body, *hit)
    if np.isnan(body.places[own]).all():
        return None
    frames = _frames(body, begin, end)
    moving, tracks = faced(body, frames, own), dict.fromkeys(it for it in parts if it in TRACKS)
    within = np.unique(frames.searchsorted(own).clip(max=len(frames) - 1))
    chosen = within[different(moving.places[within])]
    edges = hit[0] - begin, hit[1] - begin
    return Playback(moving, chosen, (*tracks,), begin, end - begin, edges)


def seen_from(played: Iterable[Playback | None]) -> View:
    """Return the one view from which all hits of a search are seen."""
    return view((it.body, it.parts) for it in played if it)


def _staff(score: Score, hit: Hit, begin: float, end: float, beat: int) -> Picture | None:
    """Return the staff of the matched symbols; None where they have no column."""
    meant = {part for part, *_ in keys_of(score, hit.symbols)}
    try:
        picture = draw(
            score,
            title=hit.path,
            parts=[part for part in score.tracks if part in meant] or [*meant],
            start=begin,
            stop=end,
            bars=None,
            seconds=True,
            marked=hit.symbols,
            beat=beat,
        )
    except UsageError:
        return None
    # what each column is for is said beside it
    marks = tuple(it for it in picture.marks if not isinstance(it, Label) or not it.turned)
    return replace(picture, height=picture.height - NAMES, marks=marks)


def _frames(body: Figure, begin: float, end: float) -> NDArray[np.int64]:
    """Return the frames of a stretch that are played."""
    end = max(min(end, len(body) / float(body.rate)), begin)
    most = min(RATE, float(body.rate), FRAMES / max(end - begin, 1e-9))
    count = max(round((end - begin) * most), 1)
    times = begin + np.arange(count) * (end - begin) / count
    found = np.floor(times * float(body.rate) + 1e-6).astype(np.int64)
    return np.minimum(found, len(body) - 1)


def different(places: NDArray[np.float32]) -> NDArray[np.int64]:
    """Return which of some poses, (F, 21, 3), differ most, the first among them, in order."""
    about = places - stood(places)[:, None]
    apart = np.nan_to_num(about).reshape(len(places), -1) / sqrt(places.shape[1])
    most = max(float(np.linalg.norm(apart - apart[0], axis=1).max()), 1.0)
    apart = np.column_stack([apart, np.linspace(0, _TIME * most, len(places))])
    taken = [0]
    while len(taken) < POSES:
        gaps = [np.linalg.norm(apart - apart[at], axis=1) for at in taken]
        taken.append(int(np.min(gaps, axis=0).argmax()))
    return np.sort(np.array(taken))


def fitted(played: Playback, eye: View) -> tuple[NDArray[np.float64], NDArray[np.float64], float]:
    """Return poses as they are seen, (P, 21, 3) mm, the foot of all, (2,), and units in a mm."""
    body, axes = played.body, eye.axes().astype(np.float32)
    places = (body.places - stood(body.places)[:, None])[played.poses] @ axes.T
    seen = places[..., :2]
    (left, low), (right, high) = (edge(seen, axis=(0, 1)) for edge in (np.nanmin, np.nanmax))
    wide = max((right - left) / 2, _WIDEST) + _ROUND
    tall = max(high - low + 2 * _ROUND, _WIDEST)
    scale = min(WIDTH / 2 / wide, (HEIGHT - 2 * _FLOOR) / tall)
    return places, np.array(((left + right) / 2, low)), float(scale)


def poses(played: Playback, eye: View, path: str) -> Picture:
    """Return poses side by side, on one floor and at one scale."""
    body, (places, foot, scale) = played.body, fitted(played, eye)
    seen = places[..., :2]
    strokes, lit = Strokes(body), body.shown(played.parts).tolist()
    count = len(played.poses)
    marks: list[Mark] = [line(0, HEIGHT - _FLOOR, count * WIDTH, HEIGHT - _FLOOR, "light")]
    onto = np.array((scale, -scale))
    for number, pose in enumerate((seen - foot) * onto):
        x, y = WIDTH * number + WIDTH // 2, HEIGHT - _FLOOR
        own = strokes.of(pose, places[number, :, 2], lit)
        for (width, color), some in groupby(own, itemgetter(2, 3)):
            ways = tuple(
                ((round(a), round(b)), (round(c), round(d))) for (a, b), (c, d), *_ in some
            )
            least = 2 * _THIN if color == "lit" else _THIN  # it must show below the other
            thick = max(round(width * scale), least)
            marks.append(Polyline(x, y, ways, style=color, width=thick))
    title = f"{count} poses of {path}" if count > 1 else f"a pose of {path}"
    return Picture(count * WIDTH, HEIGHT, title, title, tuple(marks))


def legend(tag: str) -> str:
    """Return what the colours of a body mean, in elements of a page or a picture."""
    paint = "fill" if tag == "tspan" else "color"
    return "\u2002".join(
        f'<{tag} style="{paint}:{BODY[color]}">\u2014</{tag}> {word}'
        for word, color in LEGEND.items()
    )


PAGE_HITS = 1000  # default number of hits of a page


def page(shots: Sequence[HitPreview], title: str, eye: View) -> str:
    """Return hits as a page: items, and buttons of those that can be played."""
    cards = []
    for shot in shots:
        find = svg.text_of(f"{shot.path} {shot.label}".lower())
        tag, attributes = "div", ""
        if played := shot.played:
            tag = "button"
            places = played.body.places.clip(UNKNOWN + 1, -UNKNOWN - 1).round()
            data = {  # what the page's script reads
                "joints": b64encode(np.nan_to_num(places, nan=UNKNOWN).astype("<i2")).decode(),
                "strokes": _rows(played),
                "seconds": f"{played.seconds:g}",
                "start": f"{played.start:g}",
                "from": f"{played.hit[0]:g}",
                "to": f"{played.hit[1]:g}",
                "base": shot.base,
                "beat": shot.beat,
            }
            attributes = ' type="button"'
            attributes += "".join(f' data-{name}="{it}"' for name, it in data.items())
        drawn = played and poses(played, eye, shot.path)
        trouble = svg.text_of(shot.trouble)
        trouble = f'<span class="trouble">{trouble}</span>' if trouble else ""
        pictures = "".join(
            f'<span class="{name}">{svg.write(picture)}</span>'
            for name, picture in (("poses", drawn), ("staff", shot.staff))
            if picture
        )
        cards.append(
            f'<li data-find="{find}"><{tag} class="hit"{attributes}>'
            f'<span class="path">{svg.text_of(shot.path)}</span>'
            f'<span class="said">{svg.text_of(shot.caption)}</span>'
            f'{trouble}<span class="seen">{pictures}</span></{tag}></li>\n'
        )
    template = Template(Path(__file__).with_name("page.html").read_text("utf-8"))
    count = f"{len(shots)} hit{'s' * (len(shots) != 1)}"
    return template.substitute(
        title=svg.text_of(title),
        count=count,
        cards="".join(cards),
        legend=legend("span"),
        colors=json.dumps(BODY),
        turn=f"{eye.turn:g}",
    )


def _rows(played: Playback) -> str:
    """Return the strokes of a body: joints, the share left out, width, colour, lit or not."""
    strokes, lit = Strokes(played.body), played.body.shown(played.parts)
    return " ".join(
        f"{inner},{outer},{share:.3g},{width:g},{color},{lit[bone]:d}"
        for inner, outer, (bone, share, width, color) in zip(
            strokes.inner.tolist(), strokes.outer.tolist(), strokes.table, strict=True
        )
    )


SHEET_HITS = 200  # hits of a sheet, at most
_SCALE = 0.8  # of a staff
_STAVES = 124  # pixels of width for a staff
_CARD = (POSES * WIDTH // PIXEL + _STAVES, HEIGHT // PIXEL + 40)
_GAP, _SHEET_TOP = 18, 54
_LETTERS = 80
_COLUMNS = 5


def sheet(shots: Sequence[HitPreview], title: str, eye: View) -> str:
    """Return hits as a picture, SVG."""
    across = min(max(ceil(sqrt(len(shots) / 3)), 1), _COLUMNS)
    down = max(ceil(len(shots) / across), 1)
    width = across * (_CARD[0] + _GAP) + _GAP
    height = _SHEET_TOP + down * (_CARD[1] + _GAP)
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}"'
        f' viewBox="0 0 {width} {height}" font-family="sans-serif" font-size="11">\n',
        _text(_GAP, 22, title, ' font-size="16"', across * _LETTERS * 2 // 3),
        f'<text x="{_GAP}" y="40">{legend("tspan")}</text>\n',
    ]
    for number, shot in enumerate(shots):
        x = _GAP + number % across * (_CARD[0] + _GAP)
        y = _SHEET_TOP + number // across * (_CARD[1] + _GAP)
        low = y + 32  # below capture and time: poses and staff
        frame = f"M{x} {y}h{_CARD[0]}v{_CARD[1]}h{-_CARD[0]}z"
        parts.append(f'<path d="{frame}" fill="none" stroke="#ccc"/>\n')
        parts.append(_text(x + 6, y + 14, shot.path, ' font-weight="bold"', _LETTERS - 12))
        parts.append(_text(x + 6, y + 28, shot.caption, "", _LETTERS))
        if shot.played:
            parts.append(svg.placed(poses(shot.played, eye, shot.path), x, low, ink=INK))
        else:
            parts.append(_text(x + 6, low + 40, shot.trouble, ' fill="#b00020"', _LETTERS - 25))
        if shot.staff:
            wide, tall = shot.staff.width / PIXEL, shot.staff.height / PIXEL
            scale = min(_SCALE, _STAVES / wide, (_CARD[1] - 36) / tall)
            right = x + _CARD[0] - round(wide * scale)
            parts.append(svg.placed(shot.staff, right, low, scale=scale, ink=INK))
    return "".join([*parts, "</svg>\n"])


def _text(x: int, y: int, text: str, style: str, most: int) -> str:
    if len(text) > most:  # the middle gives way
        text = f"{text[: most // 2]}\u2026{text[-(most - most // 2 - 1) :]}"
    return f'<text x="{x}" y="{y}"{style}>{svg.text_of(text)}</text>\n'
