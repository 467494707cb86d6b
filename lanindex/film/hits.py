"""Previews of hits, as a page in HTML that plays them, or as a sheet of pictures."""

import warnings
from base64 import b64encode
from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import ceil, sqrt
from pathlib import Path
from string import Template

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import JOINT_CODES, TRACKS
from lanindex.draw import Picture, draw, svg
from lanindex.draw.picture import PIXEL, Circle, Label, Mark, Polyline, line
from lanindex.draw.staff import BEAT, MARGIN, NAMES, START, keys_of
from lanindex.draw.svg import INK
from lanindex.errors import UsageError
from lanindex.film.figure import Figure, View, view
from lanindex.model import Hit, Score
from lanindex.model.capture import in_words

POSES = 5  # poses of a hit, from its first frame to its last
WIDTH, HEIGHT = 800, 1420  # of a pose, units
STAFF = 1000  # height of a hit's staff, units, its starting position apart
LEAST = 1.0  # seconds that are played and written of a hit, at least
# Frames a second that can be played, at most, and frames of a hit: of a longer one fewer a second
RATE, FRAMES = 30, 300
# How bones are drawn: those on the left are paler, those of what matched in colour
KINDS = ("far", "bone", "litfar", "litbone")
UNKNOWN = -32768  # stands for a place that is not known, among whole millimetres

_TOP = JOINT_CODES["Head"]
_BELOW = 2 * MARGIN + START
_FLOOR = 60  # units below the feet
_HEAD = 95.0  # mm, radius
_WIDEST = 200.0  # mm that are shown, at least
_STILL = 100.0  # mm: as much as poses differ by that, the first differs from the last by its time


@dataclass(frozen=True, slots=True, eq=False)
class Playback:
    """The movement of a hit, as the page plays it."""

    # (F, K, 3) int16, mm from where the pelvis stands first, on the floor; `UNKNOWN` as it says
    places: NDArray[np.int16]
    # The two joints of each bone, and how it is drawn: one of `KINDS`
    bones: tuple[tuple[int, int, str], ...]
    head: int  # Which joint is the head; -1: none
    start: float  # Seconds into the capture
    seconds: float  # How long it lasts
    hit: tuple[float, float]  # Start and end of the hit within these seconds
    turn: float  # Of the view, degrees


@dataclass(frozen=True, slots=True, eq=False)
class HitPreview:
    """A hit with its poses, its staff and its movement."""

    path: str  # Of the capture
    label: str
    when: str  # Its seconds
    words: str  # Its symbols
    staff: Picture | None = None  # Its symbols on a staff
    base: int = 0  # Where the staff begins, units from above
    beat: int = BEAT  # Units of a second
    poses: Picture | None = None
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
    frames = _frames(body, start, stop)
    if np.isnan(body.places[frames]).all():
        return replace(shot, trouble="no joint is known meanwhile")
    parts = [part for part in dict.fromkeys(it.part for it in hit.symbols) if part in TRACKS]
    kinds = kinds_of(body, parts)
    eye = view(body, parts or None, int(frames[0]), int(frames[-1]) + 1)
    own = np.unique(body.bones)
    numbers = {joint: number for number, joint in enumerate(own.tolist())}
    bones = tuple(
        (numbers[inner], numbers[outer], kind)
        for (inner, outer), kind in zip(body.bones.tolist(), kinds, strict=True)
    )
    places = body.places[_frames(body, begin, end)]
    upon = _upon(places)
    origin = upon[np.flatnonzero(~np.isnan(upon[:, 0]))[0]].copy()
    origin[1] = np.nanmin(places[..., 1])
    moved = (places[:, own] - origin).clip(UNKNOWN + 1, -UNKNOWN - 1)
    joints = np.where(np.isnan(moved), UNKNOWN, moved.round()).astype(np.int16)
    played = Playback(
        joints,
        bones,
        numbers.get(_TOP, -1),
        begin,
        end - begin,
        (start - begin, stop - begin),
        eye.turn,
    )
    drawn = poses(body, different(body, frames), kinds, eye, hit.path)
    return replace(shot, poses=drawn, played=played)


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


def _upon(places: NDArray[np.float32]) -> NDArray[np.float32]:
    """Return the point of the floor below the pelvis, or the body's middle, (F, 3)."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # a frame of which nothing is known
        middle = np.nanmean(places, axis=1)
    pelvis = places[:, JOINT_CODES["Pelvis"]]
    upon = np.where(np.isnan(pelvis), middle, pelvis)
    upon[:, 1] = 0
    return upon


def kinds_of(body: Figure, parts: Sequence[str]) -> list[str]:
    """Return how each bone is drawn where parts are lit."""
    return [
        ("lit" if lit else "") + ("far" if part.startswith("l_") else "bone")
        for lit, part in zip(body.shown(parts).tolist(), body.parts, strict=True)
    ]


def different(body: Figure, frames: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return frames whose poses differ most, the first and the last among them, in order."""
    places = body.places[frames] - _upon(body.places[frames])[:, None]
    apart = np.nan_to_num(places).reshape(len(frames), -1) / sqrt(places.shape[1])
    apart = np.column_stack([apart, np.linspace(0, _STILL, len(frames))])
    taken = [0, len(frames) - 1]
    while len(taken) < POSES:
        gaps = [np.linalg.norm(apart - apart[at], axis=1) for at in taken]
        taken.append(int(np.min(gaps, axis=0).argmax()))
    return frames[sorted(taken)]


def poses(
    body: Figure, frames: NDArray[np.int64], kinds: Sequence[str], eye: View, path: str
) -> Picture:
    """Return poses of some frames side by side, on one floor and at one scale."""
    places = body.places[frames]
    seen = eye.project(places - _upon(places)[:, None])
    low, high = (float(edge(seen[..., 1])) for edge in (np.nanmin, np.nanmax))
    left, right = (float(edge(seen[..., 0])) for edge in (np.nanmin, np.nanmax))
    wide = max((right - left) / 2, _WIDEST)
    tall = max(high - low + 2 * _HEAD, _WIDEST)
    scale = min(WIDTH / 2 / (wide + _HEAD), (HEIGHT - 2 * _FLOOR) / tall)
    marks: list[Mark] = [line(0, HEIGHT - _FLOOR, POSES * WIDTH, HEIGHT - _FLOOR, "light")]
    for number in range(len(seen)):
        x, y = WIDTH * number + WIDTH // 2, HEIGHT - _FLOOR
        at = (seen[number] - ((left + right) / 2, low)) * (scale, -scale)
        known: NDArray[np.bool_] = np.isfinite(at.sum(axis=1))
        points = np.where(known[:, None], at, 0).round().astype(np.int64).tolist()
        for kind in KINDS:
            bones = [
                (tuple(points[inner]), tuple(points[outer]))
                for (inner, outer), own in zip(body.bones.tolist(), kinds, strict=True)
                if own == kind and known[inner] and known[outer]
            ]
            if bones:
                marks.append(Polyline(x, y, tuple(bones), style=kind))
        if known[_TOP]:
            style = dict(zip(body.bones[:, 1].tolist(), kinds, strict=True)).get(_TOP, "bone")
            across, up = points[_TOP]
            marks.append(Circle(x + across, y + up, round(_HEAD * scale), style))
    title = f"{POSES} poses of {path}"
    return Picture(POSES * WIDTH, HEIGHT, title, title, tuple(marks))


PAGE_HITS = 1000  # default number of hits of a page


def page(shots: Sequence[HitPreview], title: str) -> str:
    """Return hits as a page: items, and buttons of those that can be played."""
    cards = []
    for shot in shots:
        find = svg.text_of(f"{shot.path} {shot.label}".lower())
        tag, attributes = "div", ""
        if played := shot.played:
            tag = "button"
            data = {  # what the page's script reads
                "joints": b64encode(played.places.astype("<i2").tobytes()).decode(),
                "count": played.places.shape[1],
                "bones": " ".join(f"{inner},{outer},{kind}" for inner, outer, kind in played.bones),
                "head": played.head,
                "seconds": f"{played.seconds:g}",
                "start": f"{played.start:g}",
                "from": f"{played.hit[0]:g}",
                "to": f"{played.hit[1]:g}",
                "turn": f"{played.turn:g}",
                "base": shot.base,
                "beat": shot.beat,
            }
            attributes = ' type="button"'
            attributes += "".join(f' data-{name}="{it}"' for name, it in data.items())
        trouble = svg.text_of(shot.trouble)
        trouble = f'<span class="trouble">{trouble}</span>' if trouble else ""
        pictures = "".join(
            f'<span class="{name}">{svg.write(picture)}</span>'
            for name, picture in (("poses", shot.poses), ("staff", shot.staff))
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
    return template.substitute(title=svg.text_of(title), count=count, cards="".join(cards))


SHEET_HITS = 200  # hits of a sheet, at most
_SCALE = 0.8  # of a staff
_STAVES = 124  # pixels of width for a staff
_CARD = (POSES * WIDTH // PIXEL + _STAVES, HEIGHT // PIXEL + 40)
_GAP, _SHEET_TOP = 18, 46
_LETTERS = 80
_COLUMNS = 5


def sheet(shots: Sequence[HitPreview], title: str) -> str:
    """Return hits as a picture, SVG."""
    across = min(max(ceil(sqrt(len(shots) / 3)), 1), _COLUMNS)
    down = max(ceil(len(shots) / across), 1)
    width = across * (_CARD[0] + _GAP) + _GAP
    height = _SHEET_TOP + down * (_CARD[1] + _GAP)
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}"'
        f' viewBox="0 0 {width} {height}" font-family="sans-serif" font-size="11">\n',
        _text(_GAP, 28, title, ' font-size="16"', across * _LETTERS * 2 // 3),
    ]
    for number, shot in enumerate(shots):
        x = _GAP + number % across * (_CARD[0] + _GAP)
        y = _SHEET_TOP + number // across * (_CARD[1] + _GAP)
        low = y + 32  # below capture and time: poses and staff
        frame = f"M{x} {y}h{_CARD[0]}v{_CARD[1]}h{-_CARD[0]}z"
        parts.append(f'<path d="{frame}" fill="none" stroke="#ccc"/>\n')
        parts.append(_text(x + 6, y + 14, shot.path, ' font-weight="bold"', _LETTERS - 12))
        parts.append(_text(x + 6, y + 28, shot.caption, "", _LETTERS))
        if shot.poses:
            parts.append(svg.placed(shot.poses, x, low, ink=INK))
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
