"""What of a printed score is not known or doubtful, as a page that shows where it stands."""

from __future__ import annotations

from base64 import b64encode
from html import escape
from itertools import groupby
from operator import itemgetter
from pathlib import Path
from string import Template
from typing import TYPE_CHECKING

import cv2

from lanindex.errors import counted
from lanindex.reader.boxes import around

if TYPE_CHECKING:
    from lanindex.reader.printed import Printed
    from lanindex.reader.score import Record


def written(printed: Printed) -> str:
    """Return the page as HTML, with its pictures in it."""
    unsure = list(printed.unsure())
    numbered = [(page, no, sign, told) for no, (page, sign, told) in enumerate(unsure, 1)]
    unknown = sum(not sign.kind for _, sign, _ in unsure)
    template = Template(Path(__file__).with_suffix(".html").read_text("utf-8"))
    return template.substitute(
        title=escape(Path(printed.path).name),
        summary=f"{counted(unknown, 'sign')} not known, {len(unsure) - unknown} doubtful",
        notes="".join(f"<li>{escape(it)}</li>" for it in printed.about_pages()),
        pages="\n".join(
            _section(printed, page, [it[1:] for it in signs])
            for page, signs in groupby(numbered, key=itemgetter(0))
        ),
    )


def _section(printed: Printed, page: int, signs: list[tuple[int, Record, str]]) -> str:
    """Return a page with boxes round its signs, and each of these by itself."""
    image = printed.images[page - 1]
    height, width = image.shape
    jpeg = b64encode(cv2.imencode(".jpg", image)[1].tobytes()).decode()
    marks = [f'<image width="{width}" height="{height}" href="data:image/jpeg;base64,{jpeg}"/>']
    cards = []
    for number, sign, told in signs:
        left, top, right, bottom = sign.box
        kind = "doubtful" if sign.kind else "unknown"
        marks.append(
            f'<g class="{kind}"><rect class="{kind}" x="{left}" y="{top}" width="{right - left}"'
            f' height="{bottom - top}"/><text x="{right + 3}" y="{bottom}">{number}</text></g>'
        )
        x, y, beyond, below = around(image, sign.box)
        shown = f"{x} {y} {beyond - x} {below - y}"
        cards.append(
            f'<li><svg viewBox="{shown}"><use href="#page-{page}"/></svg><span><b>{number}</b>'
            f"page {page}, {escape(sign.place)}: {escape(told)}</span></li>"
        )
    return (
        f'<section><svg class="page" viewBox="0 0 {width} {height}"><g id="page-{page}"'
        f' font-size="{max(height, width) // 50}">'
        f"{''.join(marks)}</g></svg><ol>{''.join(cards)}</ol></section>"
    )
