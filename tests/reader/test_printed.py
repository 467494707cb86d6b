"""A picture of a score is a capture without motion: ingested, searched, drawn, cut as a score."""

import sys
from pathlib import Path

import command
import numpy as np
import pytest

import lanindex
from lanindex.pipeline.library import open_library

cv2 = pytest.importorskip("cv2")
sys.path.append(str(Path(__file__).parents[1] / "benchmarks"))

from printed_page import clean, scribbled  # noqa: E402
from reader_pages import made  # noqa: E402

from lanindex.reader import doubts  # noqa: E402
from lanindex.reader.boxes import around  # noqa: E402
from lanindex.reader.printed import open_printed  # noqa: E402
from lanindex.reader.score import read_signs  # noqa: E402


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with a page, and a picture that is none."""
    folder = tmp_path_factory.mktemp("printed")
    cv2.imwrite(str(folder / "page.png"), clean())
    cv2.imwrite(str(folder / "photo.jpg"), np.full((300, 300), 200, np.uint8))
    return folder


def test_it_is_ingested_and_found(folder: Path, tmp_path: Path) -> None:
    run = {"cwd": folder, "env": {"LANINDEX_DB": str(tmp_path / "l.db")}}
    done = command.run("ingest", "page.png", "photo.jpg", **run)
    assert done.returncode == 2
    assert "photo.jpg: no staff of Labanotation" in done.stderr
    assert "1 added, 1 failed; 8.0 s of movement, 6 symbols" in done.stderr
    assert "1 file unchanged" in command.run("ingest", "page.png", **run).stderr
    found = command.run("search", "r_arm right mid -> forward high", **run)
    assert found.stdout.startswith("page.png\t0\t16\t0.0\t4.0\t")
    assert command.run("show", "page.png", **run).stdout.count("r_arm") == 3
    assert command.run("score", "page.png", "-o", str(tmp_path / "x.svg"), **run).returncode == 0
    done = command.run("export", "l_arm", "--format", "bvh", "-o", str(tmp_path / "clips"), **run)
    assert done.returncode == 2
    assert "page.png: came as png, wanted a bvh source." in done.stderr


def test_what_is_not_known_is_a_doubt_of_the_capture(tmp_path: Path) -> None:
    cv2.imwrite(str(tmp_path / "page.png"), scribbled())
    with open_library(tmp_path / "l.db", create=True) as library:
        (outcome,) = library.ingest(tmp_path / "page.png")
        warnings = library.capture(outcome.path).warnings
    assert warnings == ("page 1, staff 1, l_arm, count 4 to 6: not known, left out",)


def test_what_is_not_known_is_shown(tmp_path: Path) -> None:
    cv2.imwrite(str(tmp_path / "page.png"), scribbled())
    words = ["read-score", "page.png", "--doubts", "doubts.html"]
    done = command.run(*words, cwd=tmp_path)
    shown = (tmp_path / "doubts.html").read_text()
    told = [line for line in done.stderr.splitlines() if line.startswith("page 1, ")]
    assert len(told) == 1
    assert all(line in shown for line in told)
    assert shown.count("<rect ") == shown.count("<li>") == len(told)
    assert command.run(*words, cwd=tmp_path).returncode == 2  # it is there already
    done = command.run(*words[:3], "doubts.png", "--force", cwd=tmp_path)
    assert done.stderr == 'lanindex: --doubts: "doubts.png", wanted an ending of html\n'


def test_folders_are_not_searched_for_pictures(folder: Path, tmp_path: Path) -> None:
    done = command.run("ingest", str(folder), "--db", str(tmp_path / "l.db"))
    assert done.returncode == 1
    assert "2 pictures (name those of printed scores)" in done.stderr


def test_a_page_without_a_staff_is_told_beside_one_that_has(folder: Path, tmp_path: Path) -> None:
    page = cv2.imread(str(folder / "page.png"), cv2.IMREAD_GRAYSCALE)
    cv2.imwritemulti(str(tmp_path / "score.tiff"), [np.full_like(page, 255), page])
    printed = open_printed(str(tmp_path / "score.tiff"))
    score, told = printed.score(), "page 1: no staff of Labanotation, left out"
    assert score.warnings[0] == told
    assert f"<ul><li>{told}</li></ul>" in doubts.written(printed)
    assert lanindex.write_lnd(score).count("r_arm") == 3


def test_boxes_lie_where_signs_are_drawn() -> None:
    page = made(4)
    read = read_signs(page.image)
    truth = {(it.part, it.start): it for it in page.truth}
    seen = 0
    for record in read.records:
        sign = truth.get((record.part, record.start))
        if sign and (sign.end, sign.direction) == (record.end, record.direction):
            corners = page.boxes(sign.part, sign.start, sign.end)[0]
            drawn = *corners.min(axis=0), *corners.max(axis=0)
            unit = record.box[2] - record.box[0]
            assert np.abs(np.array(drawn) - record.box).max() < 0.4 * unit
            assert np.ptp(np.reshape(around(page.image, record.box), (2, 2)), axis=0).min() > unit
            seen += 1
    assert seen > 10
