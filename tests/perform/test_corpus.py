"""The choreographies that come with LanIndex."""

import csv
import re
import runpy
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from choreography import neighbours, spoken

from lanindex import formats
from lanindex.encoding import encode
from lanindex.library.selection import Selection
from lanindex.notation import lnd
from lanindex.perform.limbs import FOLDED
from lanindex.pipeline.library import Library, open_library

CORPUS = Path(__file__).parents[2] / "corpus"
SCORES = sorted(CORPUS.glob("*.lnd"), key=lambda path: path.name)
each = pytest.mark.parametrize("path", SCORES, ids=lambda path: path.stem)


def test_there_are_enough() -> None:
    assert len(SCORES) >= 6


def test_one_command_rebuilds_it(tmp_path: Path) -> None:
    """Text for text but for the last digit of angles, which another processor may round."""
    build = runpy.run_path(str(CORPUS / "build.py"))["build"]
    built = build(tmp_path)
    assert {path.name for path in built} == {path.name for path in CORPUS.glob("*.bvh")}
    for path in built:
        mine = CORPUS / path.name
        texts = [one.read_text("ascii").partition("Frame Time") for one in (mine, path)]
        assert texts[0][0] == texts[1][0]
        motions = [formats.read(one) for one in (mine, path)]
        assert motions[0].rate == motions[1].rate
        assert np.abs(motions[0].positions - motions[1].positions).max() < 0.01


def test_all_signs_are_drawn_anew_as_they_are_shown() -> None:
    """As large as the picture at hand: another version of what draws it may smooth otherwise."""
    drawn, shown = runpy.run_path(str(CORPUS / "build.py"))["signs"](), CORPUS / "signs.png"
    assert drawn[:24] == shown.read_bytes()[:24]  # the signature, width and height


@each
def test_scores_are_written_as_we_write(path: Path) -> None:
    assert lnd.write(lnd.read(path)).encode() == path.read_bytes()


def test_every_file_has_a_label() -> None:
    with (CORPUS / "labels.csv").open(encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    files = {path.name for path in CORPUS.iterdir() if path.suffix in {".bvh", ".lnd"}}
    assert sorted(row["file"] for row in rows) == sorted(files)
    assert all(row["label"] for row in rows)


@each
def test_it_comes_back(path: Path) -> None:
    """Symbol for symbol where neighbours are near, else with what lies on the way between."""
    score = lnd.read(path)
    heard = encode(formats.read(path.with_suffix(".bvh")))
    for part, track in score.tracks.items():
        wanted, found = spoken(score, part), spoken(heard, part)
        cells = [(int(row["direction"]), int(row["level"])) for row in track.symbols]
        near = all(FOLDED in (one, two) or two in neighbours(one) for one, two in pairwise(cells))
        if near:
            assert found == wanted
        left = iter(found)
        assert all(cell in left for cell in wanted), part


# Where a flag is, beginning below and round by the signaller's own right:
# 0 down, 1 right low, 2 right, 3 right high, 4 up, 5 left high, 6 left, 7 left low.
FLAGS = [
    "place low",
    "right low",
    "right mid",
    "right high",
    "place high",
    "left high",
    "left mid",
    "left low",
]
CIRCLES = {"0": "ABCDEFG", "1": "HIKLMN", "2": "OPQRS", "3": "TUY", "4": " JV", "5": "WX", "6": "Z"}
"""The signal book's: one flag stays, the other goes on round."""


def test_the_semaphore_spells_the_alphabet() -> None:
    letters = {
        letter: {FLAGS[int(first)], FLAGS[second]}
        for first, circle in CIRCLES.items()
        for second, letter in enumerate(circle, int(first) + 1)
    }
    score = lnd.read(CORPUS / "semaphore.lnd")
    unit = score.meter.division
    for index, letter in enumerate("ABCDEFGHIJKLMNOPQRSTUVWXYZ", 1):
        assert f"// {letter}" in score.other[score.other.index(f"#unit{index}") :][:2]
        flags = set()
        for part in ("r_arm", "l_arm"):
            arrived = [s for s in score.symbols(part) if s.span.stop <= index * unit]
            flags.add(f"{arrived[-1].direction} {arrived[-1].level}")
        assert flags == letters[letter], letter


SEARCHES = re.findall(
    r"^\| `(\w+)` \| `([^`]+)` \| (\d+) \|", (CORPUS / "README.md").read_text("utf-8"), re.MULTILINE
)


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Library]:
    with open_library(tmp_path_factory.mktemp("corpus") / "corpus.db", create=True) as library:
        library.ingest(CORPUS, labels=CORPUS / "labels.csv")
        yield library


@pytest.mark.parametrize(("name", "pattern", "hits"), SEARCHES)
def test_the_readme_tells_the_truth(library: Library, name: str, pattern: str, hits: str) -> None:
    for suffix in ("bvh", "lnd"):
        assert len(library.search(pattern, Selection(f"*{name}.{suffix}"))) == int(hits), suffix


def test_the_readme_has_something_to_search_in_each() -> None:
    assert {name for name, _, _ in SEARCHES} == {path.stem for path in SCORES}
