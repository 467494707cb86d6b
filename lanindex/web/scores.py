"""What the editor of scores asks for: a browser holds the score and sends it with each request.

It is JSON as in `lanindex.notation.edited`; nothing of it is kept here.
"""

from __future__ import annotations

import json
from base64 import b64encode
from dataclasses import replace
from functools import lru_cache
from itertools import product
from math import ceil, floor
from typing import Any
from urllib.parse import quote

import numpy as np
from starlette.responses import Response

from lanindex import records
from lanindex.alphabet import (
    DIRECTION_CODES,
    DIRECTIONS,
    KINDS,
    LEVELS,
    MIRRORED,
    TRACKS,
    Kind,
    amounts_of,
    kind_of,
)
from lanindex.compare import compare
from lanindex.draw import svg
from lanindex.draw.picture import PIXEL, SIGNS, C, Mark, Picture, sign
from lanindex.draw.staff import BEAT, BESIDE, MARGIN, NAMES, STANCES, has_column, usual_tracks
from lanindex.draw.strip import Staff
from lanindex.errors import UsageError
from lanindex.film import tiles
from lanindex.film.figure import figure
from lanindex.model import Score, Span, Track
from lanindex.model.derived import STEP
from lanindex.model.symbol import blank, listed
from lanindex.notation import NOTATIONS, WRITTEN, edited, left_out, lnd, read, write
from lanindex.notation.excerpt import excerpt
from lanindex.perform import perform
from lanindex.pipeline.files import safe_stem
from lanindex.pipeline.kept import Latest
from lanindex.search.example.stretch import pattern_of
from lanindex.web.routes import Call

MOST = 6000
"""Symbols of a capture that are edited at once: a request with more would be too long."""

RATE = 30
"""Frames a second in which an edited score is performed."""

_SHOWN = 500  # differences in an answer, at most
_EDGE = C // 10  # round the sign on a button


_SCORES = Latest[Score](4)


def _score(call: Call) -> Score:
    """Return the score of a request; staff, figure and what else is asked of it share it."""
    said = call.said("score", dict, {})
    return _SCORES.made(json.dumps(said), lambda: edited.score_of(said))


def _number(call: Call, name: str, default: float) -> float:
    """Return a number of the body that is there and finite, or its default."""
    value = call.body.get(name, default)
    if isinstance(value, bool) or not isinstance(value, int | float) or not 0 <= value < 1e9:
        raise UsageError(f"{value!r:.40}", place=name, wanted="a number, 0 or more")
    return value


def alphabet(call: Call) -> dict[str, Any]:
    """Return what can be written: the tracks, the words of their symbols, their signs."""
    return _alphabet()


@lru_cache(maxsize=1)
def _alphabet() -> dict[str, Any]:
    parts = [part for part in TRACKS if KINDS[kind_of(part)].keyword]
    return {
        "tracks": [_track(part) for part in parts],
        "mirrored": {name: DIRECTIONS[MIRRORED[code]] for name, code in DIRECTION_CODES.items()},
        "signs": {kind: _signs(KINDS[kind]) for kind in dict.fromkeys(map(kind_of, parts))},
        "notations": [
            {"name": it.name, "title": it.title, "suffix": it.suffix, "text": it.text}
            for it in NOTATIONS.values()
            if it.written
        ],
        "pictures": [it.suffix for it in NOTATIONS.values() if not it.written],
    }


def _track(part: str) -> dict[str, Any]:
    kind = KINDS[kind_of(part)]
    words = {"direction": kind.directions, "level": LEVELS, "amount": amounts_of(part)}
    return {
        "part": part,
        "kind": kind.name,
        "column": part not in BESIDE and part not in STANCES and has_column(part),
        "drawn": has_column(part),
        "lasts": kind.lasts or "level" in kind.fields,
        "fields": [
            {"name": name, "field": field, "words": list(words[field])}
            for name, field in zip(kind.names, kind.fields, strict=True)
        ],
    }


def _signs(kind: Kind) -> dict[str, str]:
    """Return the signs of a kind by their words; of degrees, only those of the directions."""
    if kind.name in ("gesture", "support"):
        return {
            f"{way} {level}": _button(sign(_EDGE, C + _EDGE, way, level, C))
            for way, level in product(DIRECTIONS, LEVELS)
        }
    draw = SIGNS.get(kind.name)
    if draw is None:
        ways = kind.directions if "direction" in kind.fields else ()
        return {way: _button(sign(_EDGE, C + _EDGE, way, None, C)) for way in ways}
    found = {}
    values = kind.directions if "direction" in kind.fields else kind.amounts
    for number, word in enumerate(values):
        row = blank(1)
        if "direction" in kind.fields:
            row["direction"], row["amount"] = DIRECTION_CODES[word], 0
        else:
            row["amount"] = number
        symbol = listed("other_support", row)[0]
        found[word] = _button(draw(symbol, C // 2 + _EDGE, C + _EDGE, C))
    return found


def _button(marks: list[Mark]) -> str:
    side = C + 2 * _EDGE
    return svg.write(Picture(side, side, "", "", tuple(marks)))


def of_capture(call: Call) -> dict[str, Any]:
    """Return the score of a capture, or of some seconds of it, for the editor.

    Without ``detail=full`` the finer tracks of limbs that are written as a whole are left out: the
    figure carries those out before the whole ones, so that a change of an arm would not be seen.
    """
    capture = call.site.library.capture(call.path["number"])
    score = call.site.library.score(capture.id)
    start, stop = call.number("from", 0), call.number("to", float(capture.frames / capture.rate))
    if start >= stop:
        raise UsageError(f"{start:g} to {stop:g} s", wanted="a stretch of it")
    score = _stretch(score, start, stop)
    left = [it for it in score.tracks if it not in usual_tracks(score.tracks) and it != STEP]
    if call.text("detail") == "full":
        left = []
    score = replace(score, tracks={it: own for it, own in score.tracks.items() if it not in left})
    data = edited.of_score(score)
    if len(data["symbols"]) > MOST:
        found = f"{len(data['symbols']):,} symbols in {capture.path}"
        remedy = "Open a stretch of it: from and to, in seconds."
        raise UsageError(found, wanted=f"{MOST:,} at most", remedy=remedy)
    return {"score": data, "title": capture.path, "left_out": left}


def _stretch(score: Score, start: float, stop: float) -> Score:
    """Return some seconds of a score, counted from their beginning."""
    rate = float(score.rate)
    return excerpt(score, Span(floor(start * rate), ceil(stop * rate)))


def of_file(call: Call) -> dict[str, Any]:
    """Return the score in the text of a file, in any notation."""
    name, text = call.said("name", str, "score.lnd"), call.said("text", str, "")
    return {"score": edited.of_score(read(name, text.encode())), "title": name}


def draw(call: Call) -> dict[str, Any]:
    """Return a window of a score's staff, from a beat to a beat, with the columns of some parts."""
    score, scale = _score(call), _number(call, "scale", 1)
    known = Span(0, score.frames)
    parts = [it for it in call.said("parts", list, []) if it in TRACKS and has_column(it)]
    empty = {part: Track(part, blank(0), (known,)) for part in parts}
    tracks = {**empty, **score.tracks}
    tracks = {part: tracks[part] for part in sorted(tracks, key=lnd.rank)}
    staff = Staff(replace(score, tracks=tracks), parts=parts, scale=scale)
    beat = BEAT / PIXEL * scale
    beats = score.meter.beats * ceil(staff.height / beat / score.meter.beats - 1e-6)
    start = max(floor(_number(call, "from", 0)), 0)
    stop = min(max(ceil(_number(call, "to", beats)), start + 1), beats)

    def seconds(count: float) -> float:
        return staff.seconds(staff.height - count * beat)

    picture = staff.picture(seconds(start), seconds(stop), foot=start == 0)
    foot = 0
    if start == 0:  # without the names of columns, which stay where they are when it is scrolled
        height = picture.height - NAMES - MARGIN
        foot, picture = height - round((stop - start) * BEAT), replace(picture, height=height)
    return {
        "svg": svg.write(picture, scale=scale),
        "from": start,
        "to": stop,
        "foot": foot / PIXEL * scale,
        "beat": beat,
        "beats": beats,
        "width": staff.width,
        "columns": {part: list(column) for part, column in staff.columns.items()},
        "seconds": [round(seconds(it), 4) for it in range(beats + 1)],
        "warnings": list(staff.warnings),
    }


def motion(call: Call) -> dict[str, Any]:
    """Return how the standard figure carries out a score, or some seconds of it."""
    score = _score(call)
    whole = float(score.frames / score.rate)
    start = _number(call, "from", 0)
    stop = min(_number(call, "to", whole), whole)
    performed = perform(_stretch(score, start, stop), rate=RATE)
    body = figure(performed)
    return {
        "start": floor(start * score.rate) / float(score.rate),
        "stop": stop,
        "seconds": whole,
        "warnings": list(performed.warnings),
        "figure": {
            "rate": RATE,
            "frames": len(body.places),
            "tile": len(body.places),
            "floor": float(np.nanpercentile(body.places[..., 1], 0.5)),
            **tiles.described(body),
        },
        "places": b64encode(tiles.packed(body.places)).decode(),
    }


def save(call: Call) -> Response:
    """Return a score as a file in a notation."""
    form = call.said("format", str, "lnd")
    if form not in WRITTEN:
        raise UsageError(f'"{form[:20]}"', place="format", wanted=f"one of {', '.join(WRITTEN)}")
    score = _score(call)
    name = safe_stem(call.said("name", str, "score")) + NOTATIONS[form].suffix
    missing = ", ".join(left_out(score, form)).encode("ascii", "replace").decode()
    headers = {
        "content-disposition": f"attachment; filename*=UTF-8''{quote(name)}",
        "lanindex-left-out": missing,
    }
    return Response(write(score, form), media_type="application/octet-stream", headers=headers)


def pattern(call: Call) -> dict[str, str]:
    """Return a score as a pattern, which finds what moves like it."""
    score = _score(call)
    parts = [part for part, track in score.tracks.items() if KINDS[track.kind].keyword]
    whole = float(score.frames / score.rate)
    return {"pattern": pattern_of(score, 0, whole, sorted(parts, key=lnd.rank))}


def store(call: Call) -> dict[str, Any]:
    """Put a score into the library, and return the capture that it is there."""
    score, name = _score(call), call.said("name", str, "score")
    path = call.site.uploads.keep(f"{name}.lnd", write(score, "lnd"))
    (outcome,) = call.site.library.ingest(path)
    failed = outcome.status == "failed"
    call.site.uploads.drop([path], () if failed else (str(path),))
    if failed:
        raise UsageError(outcome.error or "it cannot be read", place=name)
    capture = call.site.library.capture(outcome.path)
    if label := call.said("label", str, ""):
        call.site.library.label(capture.id, label)
    return records.of_capture(call.site.library.capture(capture.id))


def diff(call: Call) -> dict[str, Any]:
    """Return how a score differs from that of a capture, or of some seconds of it.

    Times of the capture are held to the same grid: what was opened and not changed is the same.
    """
    capture = call.site.library.capture(call.said("capture", int, 0))
    stored, whole = call.site.library.score(capture.id), float(capture.frames / capture.rate)
    stored = _stretch(stored, _number(call, "from", 0), _number(call, "to", whole))
    found = compare(lnd.read(lnd.write(stored)), _score(call))
    return {
        "capture": capture.path,
        "same": found.same,
        "count": len(found.differences),
        "only": [list(it) for it in found.only],
        "differences": [records.of_difference(it) for it in found.differences[:_SHOWN]],
    }
