"""A contact sheet: all hits of a search on one picture, a filmstrip and a staff each."""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil, sqrt

from lanindex.draw import svg
from lanindex.draw.picture import PIXEL
from lanindex.draw.render import INK
from lanindex.film.shot import HEIGHT, POSES, WIDTH, Shot

HITS = 200
"""Hits of a sheet, at most."""

_SCALE = 0.8  # of a staff
_STAVES = 124  # pixels of width for a staff
_CARD = (POSES * WIDTH // PIXEL + _STAVES, HEIGHT // PIXEL + 40)
_GAP, _TOP = 18, 46
_LETTERS = 80
_COLUMNS = 5


def sheet(shots: Sequence[Shot], title: str) -> str:
    """Return hits as a picture, SVG."""
    across = min(max(ceil(sqrt(len(shots) / 3)), 1), _COLUMNS)
    down = max(ceil(len(shots) / across), 1)
    width = across * (_CARD[0] + _GAP) + _GAP
    height = _TOP + down * (_CARD[1] + _GAP)
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}"'
        f' viewBox="0 0 {width} {height}" font-family="sans-serif" font-size="11">\n',
        _text(_GAP, 28, title, ' font-size="16"', across * _LETTERS * 2 // 3),
    ]
    for number, shot in enumerate(shots):
        x = _GAP + number % across * (_CARD[0] + _GAP)
        y = _TOP + number // across * (_CARD[1] + _GAP)
        parts += _card(shot, x, y)
    return "".join([*parts, "</svg>\n"])


def _card(shot: Shot, x: int, y: int) -> list[str]:
    """Return a hit: whose it is and when, and below that what is seen of it."""
    low = y + 32
    parts = [
        f'<path d="M{x} {y}h{_CARD[0]}v{_CARD[1]}h{-_CARD[0]}z" fill="none" stroke="#ccc"/>\n',
        _text(x + 6, y + 14, shot.path, ' font-weight="bold"', _LETTERS - 12),
        _text(
            x + 6,
            y + 28,
            " \u00b7 ".join(filter(None, (shot.when, shot.label, shot.words))),
            "",
            _LETTERS,
        ),
    ]
    if shot.poses:
        parts.append(svg.placed(shot.poses, x, low, ink=INK))
    else:
        parts.append(_text(x + 6, low + 40, shot.trouble, ' fill="#b00020"', _LETTERS - 25))
    if shot.staff:
        room = (_STAVES, _CARD[1] - 36)
        size = shot.staff.width / PIXEL, shot.staff.height / PIXEL
        scale = min(_SCALE, *(most / own for most, own in zip(room, size, strict=True)))
        right = x + _CARD[0] - round(size[0] * scale)
        parts.append(svg.placed(shot.staff, right, low, scale=scale, ink=INK))
    return parts


def _text(x: int, y: int, text: str, style: str, most: int) -> str:
    if len(text) > most:  # the middle gives way
        text = f"{text[: most // 2]}\u2026{text[-(most - most // 2 - 1) :]}"
    return f'<text x="{x}" y="{y}"{style}>{svg.text_of(text)}</text>\n'
