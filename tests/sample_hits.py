"""Hits for tests of previews."""

from fractions import Fraction

from motions import motion_of, swung

import lanindex
from lanindex.film.figure import figure
from lanindex.film.hits import preview_of
from lanindex.model import Capture, Hit, Score, Span

BODY = swung(1, 240, Fraction(60), 0.0)
SCORE = lanindex.encode(motion_of(BODY, Fraction(60)))


def hit_of(score: Score, span: Span, *parts: str, path: str = "swing.bvh") -> Hit:
    """Return a hit of the symbols of some parts that lie in a span, wholly or not."""
    capture = Capture(1, path, "bvh", "0" * 64, "swing", score.rate, score.frames)
    symbols = tuple(
        it
        for part in parts
        for it in score.symbols(part)
        if it.start < span.stop and span.start < it.stop and not it.passing
    )
    return Hit(capture, span, 1.0, (symbols,))


def shot_of(hit: Hit, body=BODY, score: Score = SCORE, rate: int = 60):
    return preview_of(score, hit, figure(motion_of(body, Fraction(rate))))
