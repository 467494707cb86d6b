"""A picture as SVG, as pages of it, and as PNG or PDF."""

import re
from dataclasses import replace
from functools import lru_cache
from html import escape
from io import BytesIO
from itertools import pairwise
from math import inf
from pathlib import Path
from typing import Any

from lanindex.data import shipped
from lanindex.draw.picture import PIXEL, Circle, Label, Mark, MarkGroup, Picture, Points, Polyline
from lanindex.draw.staff import BARS, MARGIN
from lanindex.errors import ExportError, extra

_INK = "currentColor"  # the colour of ink: that of the text around, so that dark pages work

_SIGNS = shipped("draw/signs.toml")
BODY: dict[str, str] = _SIGNS["body"]
"""Colours of a body: of what has no side that of ink; ``lit`` is laid below what matched."""

_ROUND = ' fill="none" stroke-linecap="round"'
STYLES: dict[str, str] = _SIGNS["styles"] | {
    kind: _ROUND + f' stroke="{color}"' * bool(color) for kind, color in BODY.items()
}
"""Attributes by style; all else comes from the picture's root."""

A4, EDGE = (595, 842), 42  # a sheet and its margin, points
_ROOT = (
    ' fill="{ink}" stroke="{ink}" stroke-width="7" stroke-linejoin="miter"'
    ' font-family="sans-serif" text-anchor="middle"'
)

_NOT_XML = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


def write(picture: Picture, *, scale: float = 1.0, ink: str = _INK) -> str:
    """Return a picture as SVG."""
    width, height = (f"{it / PIXEL * scale:g}" for it in (picture.width, picture.height))
    head = (
        f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}"'
        f' viewBox="{picture.left} 0 {picture.width} {picture.height}" role="img"'
        f"{_ROOT.format(ink=ink)}>\n"
        f"<title>{text_of(picture.title)}</title>\n<desc>{text_of(picture.summary)}</desc>\n"
    )
    return f"{head}{_elements(picture)}</svg>\n"


def placed(picture: Picture, x: float, y: float, *, scale: float = 1.0, ink: str = _INK) -> str:
    """Return a picture as a group of a larger one in SVG, its upper left corner at a point."""
    left = x - picture.left * scale / PIXEL
    where = f'transform="translate({left:g} {y:g}) scale({scale / PIXEL:g})"'
    return f"<g {where}{_ROOT.format(ink=ink)}>\n{_elements(picture)}</g>\n"


def _elements(picture: Picture) -> str:
    return "".join(f"{_element(mark)}\n" for mark in picture.marks)


def text_of(text: str) -> str:
    """Return a text escaped for XML, with U+FFFD for what XML cannot hold."""
    return escape(_NOT_XML.sub("\ufffd", text))


def _element(mark: Mark) -> str:
    match mark:
        case Polyline():
            (x, y), commands = mark.lines[0][0], _commands(mark.lines, mark.closed)
            hollow = "" if mark.style or max(map(len, mark.lines)) < 3 else ' fill="none"'
            start, thick = _point(mark.x + x, mark.y + y), f' stroke-width="{mark.width}"'
            style = STYLES[mark.style] + thick * (mark.width > 0)
            return f'<path d="M{start}{commands}"{hollow}{style}/>'
        case Circle(x, y, radius):
            style = STYLES[mark.style] if mark.style else ' fill="none"'
            return f'<circle cx="{x}" cy="{y}" r="{radius}"{style}/>'
        case Label():
            turned = f' transform="rotate(-90 {mark.x} {mark.y})"' if mark.turned else ""
            return (
                f'<text x="{mark.x}" y="{mark.y}" font-size="{mark.size}" stroke="none"'
                f"{STYLES[mark.style]}{turned}>{text_of(mark.text)}</text>"
            )
        case MarkGroup():
            data = "".join(f' data-{name}="{text_of(it)}"' for name, it in mark.data.items())
            title = f"<title>{text_of(mark.title)}</title>" if mark.title else ""
            return f"<g{data}>{title}{''.join(map(_element, mark.marks))}</g>"


@lru_cache(maxsize=4096)
def _commands(lines: tuple[Points, ...], closed: bool) -> str:
    """Return lines as commands that go on from the first point."""
    parts = list[str]()
    x, y = lines[0][0]
    for points in lines:
        first = points[0]
        if points is not lines[0]:
            parts.append(f"m{_point(first[0] - x, first[1] - y)}")
        x, y = first
        for to_x, to_y in points[1:]:
            right, down = to_x - x, to_y - y
            if right and down:
                parts.append(f"l{_point(right, down)}")
            else:
                parts.append(f"h{right}" if right else f"v{down}")
            x, y = to_x, to_y
        if closed and len(points) > 2:
            parts.append("z")
            x, y = first
    return "".join(parts)


def _point(x: int, y: int) -> str:
    return f"{x}{y}" if y < 0 else f"{x} {y}"


def pages(picture: Picture) -> list[Picture]:
    """Return a picture cut between staves into what fits an upright sheet."""
    staves = picture.staves
    if len(staves) < 2:
        return [picture]
    room = (A4[0] - 2 * EDGE) * PIXEL / _fitting(picture.height) - MARGIN
    each = max(int(room // (staves[1] - staves[0])), 1)
    firsts, sheets = staves[::each], list[Picture]()
    for number, (first, end) in enumerate(pairwise([*firsts, picture.width])):
        low, high = first if number else -inf, end if number + 1 < len(firsts) else inf
        marks = tuple(cut for mark in picture.marks if (cut := _piece(mark, low, high)))
        width, own = end - first + MARGIN, staves[number * each : (number + 1) * each]
        left = first - MARGIN
        sheets.append(replace(picture, left=left, width=width, marks=marks, staves=own))
    return sheets


def _fitting(height: float, width: float = 1.0) -> float:
    """Return the scale, 1 at most, at which a picture fits a sheet."""
    across, up = (PIXEL * (side - 2 * EDGE) for side in A4)
    return min(1.0, up / height, across / width)


def _piece(mark: Mark, low: float, high: float) -> Mark | None:
    """Return what begins of a mark between two places: a symbol may stand on two pages."""
    if isinstance(mark, MarkGroup):
        marks = tuple(cut for it in mark.marks if (cut := _piece(it, low, high)))
        return replace(mark, marks=marks) if marks else None
    x = mark.x + (mark.lines[0][0][0] if isinstance(mark, Polyline) else 0)
    return mark if low <= x < high else None


# What a picture can be written as, and of what size: bars of a staff, which fit a page, and scale
FORMS = {"svg": (BARS, 1.5), "png": (BARS, 1.5), "pdf": (2, 1.0)}
INK, PAPER = "#000", "#fff"  # colours of images
MOST = 100_000_000  # pixels of an image, at most: it takes four bytes each, more than once


def rendered(picture: Picture, form: str, scale: float = 1.0) -> bytes:
    """Return a picture as a file."""
    if form == "svg":
        return write(picture, scale=scale).encode()
    if form == "png":
        pixels = picture.width * picture.height * (scale / PIXEL) ** 2
        if pixels > MOST:
            remedy = "Take --from and --to, or a smaller --scale; SVG has no such limit."
            found = f"a picture of {pixels / 1e6:,.0f} million pixels"
            raise ExportError(found, wanted=f"{MOST / 1e6:,.0f} at most", remedy=remedy)
        return image(write(picture, scale=scale, ink=INK))
    with extra("pictures", form):
        from reportlab.graphics import renderPDF
        from reportlab.pdfgen.canvas import Canvas
        from svglib.svglib import svg2rlg

        content = BytesIO()
        canvas, sheets = Canvas(content, pagesize=A4), pages(picture)
        for number, page in enumerate(sheets, 1):
            own = min(scale, _fitting(page.height, page.width))
            drawing: Any = svg2rlg(BytesIO(write(page, scale=own, ink=INK).encode()))
            renderPDF.draw(drawing, canvas, EDGE, A4[1] - EDGE - drawing.height)
            canvas.drawCentredString(A4[0] / 2, EDGE / 2, f"{number} / {len(sheets)}")
            canvas.showPage()
        canvas.save()
    return content.getvalue()


def font() -> str:
    """Return the file of the font of images."""
    import reportlab

    return str(Path(reportlab.__file__).parent / "fonts" / "Vera.ttf")


def image(text: str) -> bytes:
    """Return SVG as PNG."""
    with extra("pictures", "png"):
        import resvg_py

        files, family = [font()], "Bitstream Vera Sans"
        return bytes(
            resvg_py.svg_to_bytes(
                svg_string=text, background=PAPER, font_files=files, sans_serif_family=family
            )
        )
