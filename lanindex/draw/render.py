"""SVG as PNG and PDF, by the extra ``pictures``.

PNG is made by ``resvg-py``: resvg in one wheel of 3 MB that needs no library of the system, unlike
CairoSVG. PDF is made by ``svglib`` on ``reportlab``, in Python alone, its lines kept as lines. The
font that comes with reportlab is used for PNG, too, so that a machine without any shows numbers.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from io import BytesIO
from pathlib import Path
from typing import Any

from lanindex.draw import svg
from lanindex.draw.pages import pages
from lanindex.draw.picture import PIXEL, Picture
from lanindex.errors import ExportError

FORMS = ("svg", "png", "pdf")
"""What a picture can be written as."""

INK, PAPER = "#000", "#fff"
"""Colours where no page gives them."""

_FONT = "Bitstream Vera Sans"
MOST = 100_000_000
"""Pixels of an image, at most: it takes four bytes each, more than once."""


def rendered(picture: Picture, form: str, scale: float = 1.0) -> bytes:
    """Return a picture as a file."""
    if form == "svg":
        return svg.write(picture, scale=scale).encode()
    if form == "png":
        pixels = picture.width * picture.height * (scale / PIXEL) ** 2
        if pixels > MOST:
            remedy = "Take --from and --to, or a smaller --scale; SVG has no such limit."
            found = f"a picture of {pixels / 1e6:,.0f} million pixels"
            raise ExportError(found, wanted=f"{MOST / 1e6:,.0f} at most", remedy=remedy)
        return image(svg.write(picture, scale=scale, ink=INK))
    with _installed(form):
        return _pdf(svg.write(page, scale=scale, ink=INK) for page in pages(picture))


def image(text: str) -> bytes:
    """Return SVG as PNG."""
    with _installed("png"):
        return _png(text)


@contextmanager
def _installed(form: str) -> Iterator[None]:
    """Say what is missing, and how to come by it."""
    try:
        yield
    except ImportError as error:
        remedy = "It comes with: pip install 'lanindex[pictures]'."
        raise ExportError(f"{error.name} is not installed", place=form, remedy=remedy) from error


def _png(text: str) -> bytes:
    import reportlab
    import resvg_py

    font = Path(reportlab.__file__).parent / "fonts" / "Vera.ttf"
    return bytes(
        resvg_py.svg_to_bytes(
            svg_string=text, background=PAPER, font_files=[str(font)], sans_serif_family=_FONT
        )
    )


def _pdf(texts: Iterable[str]) -> bytes:
    from reportlab.graphics import renderPDF
    from reportlab.pdfgen.canvas import Canvas
    from svglib.svglib import svg2rlg

    content = BytesIO()
    canvas = Canvas(content)
    for text in texts:
        drawing: Any = svg2rlg(BytesIO(text.encode()))
        canvas.setPageSize((drawing.width, drawing.height))
        renderPDF.draw(drawing, canvas, 0, 0)
        canvas.showPage()
    canvas.save()
    return content.getvalue()
