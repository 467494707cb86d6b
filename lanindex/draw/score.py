"""All symbols of a score on their staves."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from lanindex.alphabet import kind_of
from lanindex.draw import columns as places
from lanindex.draw import legend as meanings
from lanindex.draw import staff
from lanindex.draw.clock import Clock
from lanindex.draw.layout import BEAT, MARGIN, laid_out
from lanindex.draw.page import Page, keys_of, short
from lanindex.draw.picture import Picture
from lanindex.errors import UsageError
from lanindex.model import Score, Symbol
from lanindex.model.steps import STEP

BARS = 4
"""Bars of a staff."""


def draw(
    score: Score,
    *,
    title: str = "",
    parts: Sequence[str] | None = None,
    start: float = 0.0,
    stop: float | None = None,
    bars: int | None = BARS,
    seconds: bool = False,
    marked: Iterable[Symbol] = (),
    legend: bool = False,
    beat: int = BEAT,
) -> Picture:
    """Draw a score.

    Parameters
    ----------
    score : Score
        Any; what is only passed on the way is not drawn.
    title : str
        What the picture is called.
    parts : sequence of str, optional
        Only these tracks; else all but the finer ones of limbs that are there as a whole.
    start, stop : float
        Seconds from and to which it is drawn.
    bars : int, optional
        Bars of a staff; None: one long strip.
    seconds : bool
        Whether to count seconds, fives of them instead of bars, and not beats.
    marked : iterable of Symbol
        Symbols of the score over which a band lies.
    legend : bool
        Whether what the signs mean stands at the right.
    beat : int
        Height of a beat or second, in units of the picture.

    Raises
    ------
    UsageError
        Where the score is empty, or has no such part, or nothing lies between start and stop.

    Examples
    --------
    >>> import lanindex
    >>> from lanindex.draw import draw
    >>> picture = draw(lanindex.read_lnd("corpus/jumping_jacks.lnd"), title="jumping jacks")
    >>> picture.summary
    'Labanotation, time upwards: 12 s, 60 symbols of r_arm, l_arm, r_leg, l_leg'
    """
    end = float(score.frames / score.rate)
    last = end if stop is None else min(stop, end)
    if not 0 <= start < last:
        raise UsageError(
            f"nothing from {start:g} s to {last:g} s", wanted=f"a stretch of 0 to {end:g} s"
        )
    drawn, missing = chosen(score, parts)
    clock = Clock(score, seconds)
    edges = clock.at(start), clock.at(last)
    layout = laid_out(clock, *edges, bars, places.columns(drawn), beat)
    marked = list(marked)
    hidden = sorted({it.part for it in marked} - {*drawn, STEP})
    missing += tuple(
        f"{part} is marked and not drawn: ask for it among the parts" for part in hidden
    )
    symbols, more = Page(score, clock, layout, keys_of(score, marked)).marks(drawn)
    count = f"{len(symbols)} symbols" if len(symbols) != 1 else "1 symbol"
    summary = f"Labanotation, time upwards: {short(last - start)} s, {count}"
    named = f"{summary} of {', '.join(drawn)}"
    marks = (*more, *staff.staves(layout, clock), *staff.names(layout), *symbols)
    width, height = layout.size
    if legend:
        kinds = {kind_of(part) for part in drawn}
        rows, tall = meanings.legend(kinds, width, MARGIN, marked=bool(marked))
        marks, width, height = (
            (*marks, *rows),
            width + meanings.WIDTH,
            max(height, tall + 2 * MARGIN),
        )
    return Picture(width, height, title or "score", named, marks, missing, layout.staves)


def chosen(score: Score, parts: Sequence[str] | None) -> tuple[list[str], tuple[str, ...]]:
    """Return which tracks are drawn, and what is to say of others.

    Raises
    ------
    UsageError
        Where there is none of them, or no column for one that is asked for.

    Examples
    --------
    >>> import lanindex
    >>> from lanindex.draw.score import chosen
    >>> chosen(lanindex.read_lnd("corpus/conductor_three.lnd"), None)
    (['r_arm', 'l_arm'], ())
    """
    there = [part for part in score.tracks if len(score.tracks[part])]
    if not there:
        raise UsageError("an empty score", wanted="a symbol in it")
    if parts is None:
        odd = [part for part in there if part != STEP and not places.known(part)]
        drawn = [part for part in places.usual(there) if places.known(part)]
        if not drawn:
            raise UsageError(f"no column for {', '.join(there)}", wanted="a part that has one")
        return drawn, tuple(f"no column for {part}: it is not drawn" for part in odd)
    for part in parts:
        if part not in score.tracks:
            wanted = f"one of {' '.join(there)}"
            raise UsageError(f'there is no part "{part}"', wanted=wanted)
        if not places.known(part):
            raise UsageError(f"no column for {part}", wanted="a part that has one")
    return [part for part in score.tracks if part in parts], ()
