"""Limbs of a capture written down anew with other numbers, and what differs from what is stored.

How the limbs go is worked out once and kept (`lanindex.pipeline.kept`); it depends on no number of
a profile but ``rate`` and ``smoothing``. From it a part is written down in milliseconds.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lanindex import formats
from lanindex.alphabet import PARTS
from lanindex.encoding.joints import Body, known_parts
from lanindex.encoding.limbs import Limbs, heading, limbs
from lanindex.encoding.profile import Profile
from lanindex.encoding.timing import Tempo, estimated, quantise
from lanindex.encoding.written import together, written
from lanindex.errors import UsageError
from lanindex.library.store import Store
from lanindex.model import Capture, Meter, Reading, Score, Span, Track
from lanindex.model.derived import with_derived
from lanindex.notation import NOTATIONS
from lanindex.notation.beats import Beats
from lanindex.pipeline.export import stored_motion
from lanindex.pipeline.kept import CACHE, Cache, Made
from lanindex.pipeline.motion import SOURCES


def curves(
    store: Store, capture: Capture, part: str, profile: Profile, cache: Cache = CACHE
) -> list[Limbs]:
    """Return how a part of a capture goes, a stretch after the other; none where it is unknown."""
    check_moves(capture)
    source, width = SOURCES.of(store, capture), profile.smoothing
    key = "limbs", *source.key, profile.rate, width
    job = {
        "path": capture.location,
        "options": source.options,
        "rate": str(profile.rate),
        "smoothing": width,
    }
    kept = cache.get(key, measured, job, aside=source.large is not None)
    found, row = list[Limbs](), 0
    for start, stop, begin, count, length in kept.about.get(part, ()):
        curve = kept.window(part, row, row + count)
        row += count
        span = Span(start, stop)
        own = np.array([length])
        found.append(Limbs((part,), span, capture.rate, begin, curve[None], own))
    return found


def check_moves(capture: Capture) -> None:
    """Refuse a score, of which no limb can be followed."""
    if capture.format in NOTATIONS:
        remedy = "Choose a capture of a movement."
        raise UsageError("a score, which has no movement", place=capture.path, remedy=remedy)


def known_curves(
    store: Store, capture: Capture, part: str, profile: Profile, cache: Cache = CACHE
) -> list[Limbs]:
    """Return how a part goes, as `curves` does; an error says where it is unknown."""
    groups = curves(store, capture, part, profile, cache)
    if not groups:
        known_ones = ", ".join(known(store, capture, profile))
        raise UsageError(f'no part "{part}" is known', wanted=f"one of {known_ones}")
    return groups


def measured(path: str, options: Mapping[str, str], rate: str, smoothing: float) -> Made:
    """Return the curves of all parts of a file as they are kept."""
    from lanindex.encoding.profile import load

    motion = formats.read_file(formats.opened(path), Reading(**options), formats.Wanted(True))
    profile = replace(load("default"), rate=Fraction(rate), smoothing=smoothing)
    body = Body(motion, profile)
    about: dict[str, list[Any]] = {}
    arrays: dict[str, list[NDArray[np.float64]]] = {}
    for group in limbs(body, heading(motion, profile.rate, body), known_parts(motion)):
        lengths = group.lengths.tolist()
        for part, curve, length in zip(group.parts, group.curve, lengths, strict=True):
            span = group.known.start, group.known.stop
            about.setdefault(part, []).append([*span, group.begin, len(curve), length])
            arrays.setdefault(part, []).append(curve)
    return about, {part: np.concatenate(those) for part, those in arrays.items()}


def known(store: Store, capture: Capture, profile: Profile) -> list[str]:
    """Return the parts of a capture that are written down as limbs."""
    return [part for part in PARTS if curves(store, capture, part, profile)]


def encoded(
    store: Store, capture: Capture, parts: Sequence[str], profile: Profile, *, own_tempo: bool
) -> Score:
    """Return the stored score of a capture with some limbs written down anew.

    With `own_tempo` beats are counted as they were when the capture was ingested with a tempo.
    """
    stored = store.score(capture.id)
    asked = store.encoding(capture.id).options.get("tempo") if own_tempo else None
    meter, beats, other = profile.meter, None, stored.other
    if asked:
        own = stored.meter
        meter, beats = replace(meter, speed=own.speed, beats=own.beats), Beats.of(other)
    else:
        other = ()
    tracks = {part: track for part, track in stored.tracks.items() if part not in parts}
    for part in parts:
        groups = known_curves(store, capture, part, profile)
        those = [one for group in groups for one in written(group, profile)]
        tracks |= {it: Track(it, *found) for it, found in together(those).items()}
    return _counted(stored, tracks, meter, beats, other)


def _counted(
    stored: Score,
    tracks: Mapping[str, Track],
    meter: Meter,
    beats: Beats | None,
    other: tuple[str, ...],
) -> Score:
    """Return a score whose symbols have the ticks of a meter."""
    rows = {part: track.symbols.copy() for part, track in tracks.items() if part != "step"}
    meter = quantise(rows.values(), stored.frames, stored.rate, meter, beats)
    timed = {part: Track(part, rows[part], tracks[part].known) for part in rows}
    return replace(stored, meter=meter, tracks=with_derived(timed), other=other)


def tempo(store: Store, capture: Capture, profile: Profile) -> Tempo | None:
    """Return the tempo of a capture's movement; None where nothing recurs."""
    if capture.format in NOTATIONS:
        raise UsageError("a score, which has no movement", place=capture.path)
    rows = {part: track.symbols for part, track in store.score(capture.id).tracks.items()}
    return estimated(stored_motion(store, capture, capture.rate), profile, rows)
