"""Notebooks: what objects display, how large that is, and the notebook that ships."""

import re
import shutil
import subprocess
import sys
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from conftest import REPOSITORY
from dances import RAISE, dance

import lanindex
from lanindex.draw import svg
from lanindex.errors import LanindexError
from lanindex.film import notebook
from lanindex.film.hits import POSES
from lanindex.library.selection import Selection
from lanindex.model import Meter, Reading, Score, Span, Track
from lanindex.model.symbol import blank


@pytest.fixture
def library(tmp_path: Path):
    dance(tmp_path / "raise.bvh")
    (tmp_path / "own.lnd").write_text(RAISE)
    with lanindex.open_library(tmp_path / "l.db", create=True) as opened:
        opened.ingest(tmp_path)
        yield opened


def drawings(html: str) -> list[ElementTree.Element]:
    return [ElementTree.fromstring(one) for one in re.findall("<svg.*?</svg>", html, re.DOTALL)]


def test_all_are_shown(library) -> None:
    from IPython.core.interactiveshell import InteractiveShell

    shell = InteractiveShell(warn_venv=False)  # another environment may be active
    hits = library.search("r_arm right mid", Selection("*.bvh"))
    motion = lanindex.read(hits[0].capture.location)
    for thing, least in (
        (lanindex.encode(motion), 1),
        (motion, 1),
        (hits[0], 2),
        (hits, len(hits)),
    ):
        shown = shell.display_formatter.format(thing)[0]
        assert len(drawings(shown["text/html"])) == least
        assert shown["text/plain"]
    assert svg.STYLES["lit"] in notebook.of_hit(hits[0])  # the arm that matched
    assert "<style" not in hits._repr_html_()  # it would hold for all of the page


def test_an_import_in_ipython_changes_and_loads_nothing() -> None:
    code = (
        "import sys;"
        "html = get_ipython().display_formatter.formatters['text/html'];"
        "before = str(html.type_printers), str(html.deferred_printers);"
        "import lanindex;"
        "print(before == (str(html.type_printers), str(html.deferred_printers)),"
        " *(name for name in ('numpy', 'lanindex.draw', 'lanindex.model') if name in sys.modules))"
    )
    command = [sys.executable, "-m", "IPython", "--no-banner", "-c", code]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    assert done.stdout.split() == ["True"]


def test_what_is_shown_is_bounded(library) -> None:
    count = 20_000
    rows = blank(count)
    rows["start"] = rows["tick"] = np.arange(count) * 10
    rows["stop"], rows["ticks"] = rows["start"] + 10, 10
    rows["direction"], rows["level"] = np.arange(count) % 9, np.arange(count) % 3
    track = Track("r_arm", rows, (Span(0, count * 10),))
    long = Score(Fraction(60), count * 10, Meter(), {"r_arm": track})
    shown = notebook.of_score(long)
    assert len(shown) < 400_000
    assert "the first 66.7 s" in shown
    hits = library.search("r_arm any")
    many = hits.arranged([0] * 3000)
    assert len(drawings(many._repr_html_())) <= 10
    assert len(many._repr_html_()) < 100_000


def test_gaps_are_left_open(library) -> None:
    motion = lanindex.read(library.capture("raise.bvh").location)
    places = motion.positions.copy()
    places[: len(places) // 2] = np.nan
    places[:, motion.skeleton.body[12:]] = np.nan
    shown = notebook.of_motion(replace(motion, positions=places))
    (drawn,) = drawings(shown)
    whole = drawings(notebook.of_motion(motion))[0]
    assert notebook.of_motion(motion).count("<text") == POSES
    assert 0 < len(drawn.findall(".//*")) < len(whole.findall(".//*"))
    assert "nan" not in shown
    assert "nothing" not in shown
    empty = replace(motion, positions=np.full_like(places, np.nan))
    assert "no bone of a body is known" in notebook.of_motion(empty)


def test_a_file_is_read_as_it_was_ingested(library, tmp_path: Path) -> None:
    library.ingest(tmp_path / "raise.bvh", reading=Reading(unit="cm", rate=15))
    hit = library.search("r_arm high", Selection("*.bvh"))[0]
    assert hit.capture.options == {"unit": "cm", "rate": "15"}
    body = notebook._figure(hit)
    wanted = lanindex.read(tmp_path / "raise.bvh", rate=15, unit="cm")
    assert body.rate == wanted.rate
    assert len(body) == len(wanted)


def test_what_cannot_be_shown_is_said(library) -> None:
    hit = library.search("r_arm right mid", Selection("*.bvh"))[0]
    notated = library.search("r_arm right mid", Selection("*.lnd"))[0]
    assert "a score, without motion" in notebook.of_hit(notated)
    place = Path(hit.capture.location)
    place.write_bytes(place.read_bytes() + b"\n")
    assert "has changed since it was ingested" in notebook.of_hit(hit)
    place.unlink()
    assert "raise.bvh" in notebook.of_hit(hit)
    assert len(drawings(notebook.of_hit(hit))) == 1  # the staff is there all the same
    empty = Score(Fraction(30), 5, Meter(), {})
    assert drawings(notebook.of_score(empty)) == []
    assert "0 hits" in library.search("head back low")._repr_html_()


def test_tables_are_the_symbols(library, monkeypatch: pytest.MonkeyPatch) -> None:
    score = library.score("raise.bvh")
    frame, table = score.to_pandas(), score.to_arrow()
    symbols = score.symbols()
    assert len(frame) == table.num_rows == len(symbols)
    for symbol, row in zip(symbols, table.to_pylist(), strict=True):
        told = (row["part"], row["direction"], row["level"], row["start_frame"], row["end_frame"])
        assert told == (symbol.part, symbol.direction, symbol.level, symbol.start, symbol.stop)
        assert row["amount"] == symbol.amount
        assert row["end"] == pytest.approx(float(symbol.stop / score.rate), abs=1e-6)
    hits = library.search("r_arm right mid")
    assert list(hits.to_pandas()["start_frame"]) == [hit.start for hit in hits]
    assert hits.to_arrow().column_names == list(hits.dicts()[0])
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(LanindexError, match=r"lanindex\[tables\]"):
        score.to_pandas()


@pytest.mark.filterwarnings("ignore")
def test_the_notebook_runs(tmp_path: Path) -> None:
    import nbformat
    from nbclient import NotebookClient

    shutil.copytree(REPOSITORY / "corpus", tmp_path / "corpus")
    book = nbformat.read(REPOSITORY / "corpus" / "first_look.ipynb", as_version=4)
    assert not any(cell.get("outputs") for cell in book.cells)
    done = NotebookClient(
        book, kernel_name="python3", resources={"metadata": {"path": tmp_path / "corpus"}}
    ).execute()
    outputs = [out for cell in done.cells for out in cell.get("outputs", ())]
    assert not [out for out in outputs if out.output_type in ("error", "display_data")]
    assert not [out for out in outputs if out.get("name") == "stderr"]
    shown = [out.data for out in outputs if out.output_type == "execute_result"]
    pictures = [len(drawings(data.get("text/html", ""))) for data in shown]
    assert pictures == [1, 1, 7, 2, 0, 0]
    texts = "".join(out.text for out in outputs if out.output_type == "stream")
    assert texts.startswith("10 captures,")
    assert "movements of the right arm a second" in texts
    assert "jumping_jacks_" in texts
    assert "7 clips" in texts
