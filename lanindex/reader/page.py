"""Pages of a picture or a PDF, as grey images."""

from __future__ import annotations

from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from lanindex.errors import CaptureError, counted, extra
from lanindex.formats.sniff import beginning

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence

    import numpy as np
    from numpy.typing import NDArray

DPI = 200  # at which PDF is rendered
MOST = 100_000_000  # pixels of a page, at most
PAGES = 200  # of a PDF, at most
_IMAGES = "PNG, JPEG, TIFF, BMP, WebP"
_PNG, _JPEG = b"\x89PNG\r\n\x1a\n", b"\xff\xd8\xff"
_BEGIN = {_PNG: "PNG", _JPEG: "JPEG", b"II*\0": "TIFF", b"MM\0*": "TIFF", b"BM": "BMP"}
_UNREAD = {FileNotFoundError: "there is no such file", IsADirectoryError: "a folder"}


def pages(path: str, content: bytes | None = None) -> list[NDArray[np.uint8]]:
    """Return the pages of a picture or a PDF.

    Parameters
    ----------
    path : str
        A file: PNG, JPEG, TIFF, BMP, WebP or PDF. Of a TIFF all its pages are read.
    content : bytes, optional
        What is in it, where it is at hand.

    Returns
    -------
    list of NDArray
        Grey images (H, W): 255 is paper.

    Raises
    ------
    CaptureError
        If the file cannot be read, or is too large.
    """
    try:
        content = Path(path).read_bytes() if content is None else content
    except OSError as error:
        found = _UNREAD.get(type(error)) or error.strerror or str(error)
        raise CaptureError(found, place=path, wanted="a file that can be read") from error
    if not content:
        raise CaptureError("an empty file", place=path, wanted=f"{_IMAGES} or PDF")
    with extra("reader", path, CaptureError):
        if b"%PDF-" in content[:1024]:
            return _pdf(content, path)
        return _image(content, path)


def _image(content: bytes, path: str) -> list[NDArray[np.uint8]]:
    import cv2
    import numpy as np

    if size := _size(content):
        _bounded(*size, path)
    decoded: Sequence[NDArray[Any]] = ()
    # of a phone's JPEG the camera may have been turned; what is unchanged stays so
    flags = cv2.IMREAD_GRAYSCALE if content.startswith(_JPEG) else cv2.IMREAD_UNCHANGED
    if not content.startswith(_PNG) or b"IEND" in content:  # of a part libpng would tell itself
        with _quiet():
            _, decoded = cv2.imdecodemulti(np.frombuffer(content, np.uint8), flags)
    if not decoded:
        remedy = "Save it anew from a program that shows it, or scan the page again."
        kind = next((it for begin, it in _BEGIN.items() if content.startswith(begin)), "")
        found = f"a {kind} that is damaged or cut off" if kind else beginning(content[:80])
        found = found if kind else f"not a picture that can be read: {found}"
        raise CaptureError(found, place=path, wanted=f"{_IMAGES} or PDF", remedy=remedy)
    found_pages = []
    for image in decoded:
        _bounded(image.shape[1], image.shape[0], path)
        found_pages.append(_grey(image))
    return found_pages


def _grey(image: NDArray[Any]) -> NDArray[np.uint8]:
    """Return an image, (H, W) or (H, W, channels), as grey on white paper, (H, W)."""
    import cv2
    import numpy as np

    if image.dtype == np.uint16:
        image = (image >> 8).astype(np.uint8)
    elif image.dtype != np.uint8:
        peak = float(np.nanmax(image)) or 1.0
        image = (np.nan_to_num(image) * (255 / peak)).clip(0, 255).astype(np.uint8)
    if image.ndim == 3 and image.shape[2] == 4:  # what is transparent shows the paper
        alpha = image[..., 3].astype(np.float32) / 255
        grey = cv2.cvtColor(image[..., :3], cv2.COLOR_BGR2GRAY)
        return np.asarray(grey * alpha + 255 * (1 - alpha) + 0.5, np.uint8)
    if image.ndim == 3 and image.shape[2] == 3:
        return np.asarray(cv2.cvtColor(image, cv2.COLOR_BGR2GRAY), np.uint8)
    return np.ascontiguousarray(image[..., 0] if image.ndim == 3 else image, np.uint8)


@contextmanager
def _quiet() -> Iterator[None]:
    """Keep OpenCV from writing to standard error what the error here tells."""
    import cv2

    before = cv2.utils.logging.getLogLevel()
    cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_SILENT)
    try:
        yield
    except cv2.error:
        pass
    finally:
        cv2.utils.logging.setLogLevel(before)


def _bounded(width: int, height: int, path: str) -> None:
    """Refuse a page that is too large."""
    if width * height > MOST:
        found = f"a picture of {width:,} x {height:,} pixels"
        remedy = "Make it smaller, or scan it at 300 dots an inch."
        wanted = f"{MOST / 1e6:,.0f} million pixels at most"
        raise CaptureError(found, place=path, wanted=wanted, remedy=remedy)


def _size(content: bytes) -> tuple[int, int] | None:
    """Return width and height as the header of PNG, JPEG, BMP or WebP tells; else None."""
    number = int.from_bytes
    if content.startswith(_PNG):
        return number(content[16:20], "big"), number(content[20:24], "big")
    if content.startswith(b"BM") and len(content) >= 26:
        height = number(content[22:26], "little", signed=True)
        return number(content[18:22], "little"), abs(height)
    if content[:4] == b"RIFF" and content[8:12] == b"WEBP":
        if content[12:16] == b"VP8X":
            return 1 + number(content[24:27], "little"), 1 + number(content[27:30], "little")
        if content[12:16] == b"VP8L":
            both = number(content[21:25], "little")
            return 1 + (both & 0x3FFF), 1 + (both >> 14 & 0x3FFF)
        both = number(content[26:30], "little")
        return both & 0x3FFF, both >> 16 & 0x3FFF
    if content.startswith(b"\xff\xd8"):
        at = 2
        while at + 9 < len(content) and content[at] == 0xFF:
            kind = content[at + 1]
            if 0xC0 <= kind <= 0xCF and kind not in (0xC4, 0xC8, 0xCC):
                height = number(content[at + 5 : at + 7], "big")
                return number(content[at + 7 : at + 9], "big"), height
            at += 2 + number(content[at + 2 : at + 4], "big")
    return None


def _pdf(content: bytes, path: str) -> list[NDArray[np.uint8]]:
    import numpy as np
    import pypdfium2

    try:
        document = pypdfium2.PdfDocument(content)
    except pypdfium2.PdfiumError as error:
        if "password" in str(error).lower():
            found, remedy = "a PDF with a password", "Save a copy without a password."
        else:
            found, remedy = "a damaged PDF", "Print it to a new PDF from a program that shows it."
        raise CaptureError(found, place=path, remedy=remedy) from error
    try:
        number = len(document)
        if not number:
            raise CaptureError("a PDF without pages", place=path, wanted="a page of a score")
        if number > PAGES:
            remedy = "Save those with the score as a PDF of their own."
            found = f"a PDF of {counted(number, 'page')}"
            raise CaptureError(found, place=path, wanted=f"{PAGES} at most", remedy=remedy)
        scale, found_pages = DPI / 72, []
        for index in range(number):
            try:
                page = document[index]
                width, height = page.get_size()
                _bounded(round(width * scale), round(height * scale), path)
                bitmap = page.render(scale=scale, grayscale=True)
            except pypdfium2.PdfiumError as error:
                remedy = "Print it to a new PDF from a program that shows it."
                found = f"a damaged PDF: page {index + 1} cannot be read"
                raise CaptureError(found, place=path, remedy=remedy) from error
            image = np.asarray(bitmap.to_numpy(), np.uint8)
            found_pages.append(np.array(image[..., 0] if image.ndim == 3 else image))
        return found_pages
    finally:
        document.close()
