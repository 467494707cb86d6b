"""A part of a score, as a score of its own."""

from dataclasses import replace
from fractions import Fraction
from itertools import takewhile
from math import floor
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lanindex.alphabet import KINDS
from lanindex.model import Meter, Score, Span, Track
from lanindex.model.derived import STEP, with_bends, with_steps
from lanindex.model.score import HEADING_RATE
from lanindex.model.symbol import joined
from lanindex.notation.beats import Beats, ticks_at
from lanindex.notation.lnd import UNIT

Rows = NDArray[Any]


def excerpt(score: Score, span: Span) -> Score:
    """Cut a stretch, frames, out of a score; frames and ticks count from its beginning."""
    start = min(max(span.start, 0), score.frames)
    span = Span(start, max(start, min(span.stop, score.frames)))
    if span == Span(0, score.frames):
        return score
    # symbols across an edge are cut there; of the lines not understood only the header's stay
    tracks = [cut for track in score.tracks.values() if (cut := _cut(track, span)).known]
    most = max((np.count_nonzero(cut.symbols["ticks"]) for cut in tracks), default=0)
    meter, beats = score.meter, Beats.of(score.other)
    while len(span) and _room(span, score, meter, beats)[1] < max(most, 1):
        meter = replace(meter, division=meter.division * 2)
    factor = meter.division // score.meter.division
    room = _room(span, score, meter, beats)
    step = HEADING_RATE / score.rate
    begin = floor(span.start * step + Fraction(1, 2))
    end = begin + floor((len(span) - 1) * step) + 1 if len(span) else begin
    based = {
        cut.part: replace(cut, symbols=_based(cut.symbols, span, factor, room)) for cut in tracks
    }
    based = with_bends(with_steps(based) if STEP in based else based)
    header = tuple(takewhile(lambda line: not UNIT.fullmatch(line), score.other))
    if beats is not None:
        gone = Fraction(room[0] * meter.beats, meter.division)
        mine = beats.since(float(span.start / score.rate), gone).line()
        header = tuple(mine if Beats.of([line]) else line for line in header)
    return Score(score.rate, len(span), meter, based, score.heading[begin:end], header)


def _room(span: Span, score: Score, meter: Meter, beats: Beats | None) -> tuple[int, int]:
    """Return the span's first tick, and how many it has."""
    edges = np.array([span.start, span.stop])
    begin, end = ticks_at(edges, meter, score.rate, beats).tolist()
    return begin, end - begin


def _cut(track: Track, span: Span) -> Track:
    """Return the rows that the span shows, still in frames of the whole, cut at its edges."""
    # by their places: whole rows are wide, and of a long capture many
    symbols, start, stop = track.symbols, track.symbols["start"], track.symbols["stop"]
    shown, rows, known = ~symbols["passing"], [symbols[:0]], []
    for one in track.known:
        if one.start >= span.stop or one.stop <= span.start:
            continue
        known.append(Span(max(one.start - span.start, 0), min(one.stop, span.stop) - span.start))
        here = np.flatnonzero(shown & (start >= one.start) & (start < one.stop))
        # what the part arrived at last is its starting position
        over = here[stop[here] <= span.start]
        # what does not last is nowhere any more
        in_force = symbols[over[-1:] if KINDS[track.kind].lasts else []]
        in_force["start"] = in_force["stop"] = span.start
        in_force["ticks"] = in_force["swings"] = 0
        rows += [in_force, symbols[here[(stop[here] > span.start) & (start[here] < span.stop)]]]
    return Track(track.part, joined(rows), tuple(known))


def _based(rows: Rows, span: Span, factor: int, edges: tuple[int, int]) -> Rows:
    """Count frames and ticks from the span's beginning; each symbol keeps a tick at least."""
    rows = rows.copy()
    begin, room = edges
    ticks = rows["tick"].astype(np.int64) * factor - begin
    stops = ticks + rows["ticks"].astype(np.int64) * factor
    ticks[rows["start"] <= span.start] = 0
    stops[rows["stop"] > span.stop] = room
    least = (rows["ticks"] > 0).astype(np.int64)
    free = 0
    for index in range(len(rows)):
        ticks[index] = max(ticks[index], free)
        free = stops[index] = max(stops[index], ticks[index] + least[index])
        if not least[index]:
            free = stops[index] = ticks[index]
    limit = room
    for index in reversed(range(len(rows))):
        stops[index] = limit = min(stops[index], limit)
        ticks[index] = limit = min(ticks[index], limit - least[index])
    rows["tick"], rows["ticks"] = ticks, stops - ticks
    for name in ("start", "stop"):
        rows[name] = np.clip(rows[name], span.start, span.stop) - span.start
    return rows
