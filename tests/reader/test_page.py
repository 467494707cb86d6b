"""Pages of pictures and PDF."""

from pathlib import Path

import command
import numpy as np
import pytest

from lanindex.errors import CaptureError
from lanindex.reader import page as reader
from lanindex.reader.page import pages

cv2 = pytest.importorskip("cv2")
pypdfium2 = pytest.importorskip("pypdfium2")


def shaded() -> np.ndarray:
    return np.tile(np.arange(60, 200, dtype=np.uint8), (90, 1))


@pytest.mark.parametrize("ending", ["png", "jpg", "tif", "bmp", "webp"])
def test_a_picture_is_one_grey_page(tmp_path: Path, ending: str) -> None:
    path = tmp_path / f"page.{ending}"
    cv2.imwrite(str(path), cv2.cvtColor(shaded(), cv2.COLOR_GRAY2BGR))
    (found,) = pages(str(path))
    assert found.dtype == np.uint8
    assert np.abs(found.astype(int) - shaded()).max() < 12


def test_what_is_transparent_is_paper(tmp_path: Path) -> None:
    ink = np.zeros((20, 20, 4), np.uint8)
    ink[5:10, :, 3] = 255
    cv2.imwrite(str(tmp_path / "page.png"), ink)
    (found,) = pages(str(tmp_path / "page.png"))
    assert (found[5:10] == 0).all()
    assert (found[10:] == 255).all()


def test_each_page_of_a_tiff_is_read(tmp_path: Path) -> None:
    cv2.imwritemulti(str(tmp_path / "two.tif"), [shaded(), 255 - shaded()])
    assert [it[0, 0] for it in pages(str(tmp_path / "two.tif"))] == [60, 195]


def pdf(path: Path, number: int) -> str:
    document = pypdfium2.PdfDocument.new()
    for _ in range(number):
        document.new_page(72, 144)
    document.save(str(path))
    return str(path)


def test_pages_of_a_pdf_have_200_dots_an_inch(tmp_path: Path) -> None:
    found = pages(pdf(tmp_path / "score.pdf", 2))
    assert [it.shape for it in found] == [(400, 200)] * 2
    assert found[0].min() == 255


def test_too_many_pages_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(reader, "PAGES", 2)
    with pytest.raises(CaptureError, match="3 pages, wanted 2 at most"):
        pages(pdf(tmp_path / "score.pdf", 3))


def test_a_pdf_with_a_password_is_refused(tmp_path: Path) -> None:
    pdfencrypt = pytest.importorskip("reportlab.lib.pdfencrypt")
    canvas = pytest.importorskip("reportlab.pdfgen.canvas")
    path = str(tmp_path / "secret.pdf")
    drawn = canvas.Canvas(path, encrypt=pdfencrypt.StandardEncryption("secret"))
    drawn.drawString(10, 10, "score")
    drawn.save()
    with pytest.raises(CaptureError, match="with a password"):
        pages(path)


@pytest.mark.parametrize(
    ("content", "found"),
    [
        (b"", "an empty file"),
        (b"%PDF-1.4\nnothing", "a damaged PDF"),
        (b"HIERARCHY\nROOT Hips\n", "not a picture"),
        (b"\x89PNG\r\n\x1a\n", "a PNG that is damaged or cut off"),
    ],
)
def test_what_is_no_picture_is_refused(tmp_path: Path, content: bytes, found: str) -> None:
    (tmp_path / "page").write_bytes(content)
    with pytest.raises(CaptureError, match=found) as raised:
        pages(str(tmp_path / "page"))
    assert str(raised.value).startswith(str(tmp_path / "page"))


@pytest.mark.parametrize("ending", ["png", "jpg", "tif", "bmp"])
def test_a_part_of_a_picture_is_refused(
    tmp_path: Path, ending: str, capfd: pytest.CaptureFixture[str]
) -> None:
    content = cv2.imencode(f".{ending}", shaded())[1].tobytes()
    (tmp_path / "page").write_bytes(content[: len(content) // 2])
    with pytest.raises(CaptureError, match="that is damaged or cut off"):
        pages(str(tmp_path / "page"))
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize(("orientation", "turns"), [(1, 0), (3, 2), (6, 1), (8, 3)])
def test_a_picture_of_a_turned_phone_is_upright(
    tmp_path: Path, orientation: int, turns: int
) -> None:
    _, content = cv2.imencode(".jpg", np.rot90(shaded(), turns))
    begin = b"II*\0\x08\0\0\0\x01\0\x12\x01\x03\0\x01\0\0\0" + bytes([orientation, *bytes(7)])
    exif = b"Exif\0\0" + begin
    told = b"\xff\xe1" + (len(exif) + 2).to_bytes(2, "big") + exif
    (tmp_path / "page.jpg").write_bytes(content[:2].tobytes() + told + content[2:].tobytes())
    (found,) = pages(str(tmp_path / "page.jpg"))
    assert found.shape == shaded().shape
    assert np.abs(found.astype(int) - shaded()).max() < 12


@pytest.mark.parametrize("kind", ["16", "palette", "cmyk", "bits"])
def test_other_kinds_of_pixels_are_grey(tmp_path: Path, kind: str) -> None:
    image = pytest.importorskip("PIL.Image")
    path, grey = str(tmp_path / "page.png"), shaded()
    if kind == "16":
        cv2.imwrite(path, grey.astype(np.uint16) * 257)
    elif kind == "palette":
        image.fromarray(grey).convert("P").save(path)
    elif kind == "cmyk":
        path = str(tmp_path / "page.jpg")
        image.fromarray(grey).convert("CMYK").save(path, quality=95)
    else:
        grey = np.where(grey > 128, 255, 0)
        image.fromarray(grey.astype(np.uint8)).convert("1").save(path)
    (found,) = pages(path)
    assert np.abs(found.astype(int) - grey).max() < 12


def test_a_folder_is_refused(tmp_path: Path) -> None:
    with pytest.raises(CaptureError, match=": a folder, wanted a file that can be read"):
        pages(str(tmp_path))


def test_inspect_says_what_a_picture_is(tmp_path: Path) -> None:
    cv2.imwrite(str(tmp_path / "page.png"), shaded())
    done = command.run("inspect", "page.png", cwd=tmp_path)
    assert done.returncode == 2
    assert done.stderr.startswith("lanindex: page.png: a picture or a PDF, which has no movement")
    assert "lanindex read-score page.png" in done.stderr


def test_no_file_is_refused(tmp_path: Path) -> None:
    with pytest.raises(CaptureError, match="there is no such file"):
        pages(str(tmp_path / "page.png"))


@pytest.mark.parametrize("ending", ["png", "jpg", "bmp", "webp"])
def test_the_header_tells_the_size(ending: str) -> None:
    _, content = cv2.imencode(f".{ending}", shaded())
    assert reader._size(content.tobytes()) == (140, 90)


def test_what_is_too_large_is_refused_by_its_header(tmp_path: Path) -> None:
    content = bytearray(cv2.imencode(".png", shaded())[1].tobytes())
    content[16:24] = (20_000).to_bytes(4, "big") + (10_000).to_bytes(4, "big")
    (tmp_path / "large.png").write_bytes(content)
    with pytest.raises(CaptureError, match="20,000 x 10,000 pixels, wanted 100 million"):
        pages(str(tmp_path / "large.png"))
