"""Curves of a limb: windows are those of the whole, and the numbers are those of the method."""

import json
from pathlib import Path

import numpy as np
import pytest
from dances import RAISE
from numpy.testing import assert_array_equal

import lanindex
from lanindex.encoding.written import OUTCOMES
from lanindex.errors import ExportError, UsageError
from lanindex.pipeline.library import Library, open_library

ALONG = ("frames", "times", "speed", "distance", "azimuth", "elevation", "cells")


@pytest.fixture
def library(tmp_path: Path, repository: Path):
    jacks = (repository / "corpus/jumping_jacks.bvh").read_bytes()
    (tmp_path / "jacks.bvh").write_bytes(jacks)
    (tmp_path / "raise.lnd").write_text(RAISE)
    with open_library(tmp_path / "l.db", create=True) as opened:
        opened.ingest(tmp_path)
        yield opened


def test_the_whole_is_the_trace_of_the_method(library: Library, tmp_path: Path) -> None:
    whole = library.curves("jacks.bvh", "r_arm")
    (trace,) = lanindex.trace(lanindex.read(tmp_path / "jacks.bvh"), "r_arm")
    assert_array_equal(whole.speed, trace.speed)
    assert_array_equal(whole.cells, trace.course.cells)
    assert_array_equal(whole.candidates, trace.candidates)
    assert_array_equal(whole.holds, trace.holds)
    assert_array_equal(whole.moves, trace.segments)
    runs = [run for move in trace.runs for run in move]
    assert [OUTCOMES[code] for code in whole.runs[:, 4]] == [run.outcome for run in runs]
    assert whole.runs[:, 0].tolist() == [run.cell for run in runs]
    # each candidate lies at most d_t from the first one of its hold, as METHOD.md says
    assert whole.distance[whole.candidates].max() <= whole.thresholds.d_t
    assert whole.distance[whole.holds[:, 0]].max() == 0


def test_windows_are_those_of_the_whole(library: Library) -> None:
    whole = library.curves("jacks.bvh", "l_leg")
    pieces = [
        library.curves("jacks.bvh", "l_leg", at, min(at + 2.5, 12)) for at in (0, 2.5, 5, 7.5, 10)
    ]
    for name in (*ALONG, "candidates"):
        joined = np.concatenate([getattr(piece, name) for piece in pieces])
        assert_array_equal(joined, getattr(whole, name))
    for name in ("holds", "moves", "runs"):
        rows = [tuple(row) for piece in pieces for row in getattr(piece, name).tolist()]
        assert [*dict.fromkeys(rows)] == [tuple(row) for row in getattr(whole, name).tolist()]
    window = pieces[1]
    assert (window.times.min(), window.times.max()) == (2.5, 299 / 60)
    assert window.moves[:, 1].min() >= 150
    assert window.moves[:, 0].max() < 300


def test_thresholds_are_those_of_the_method(library: Library) -> None:
    found = library.curves("jacks.bvh", "r_arm", 0, 1)
    own = found.thresholds
    wanted = [it * found.length for it in (1.09, 0.1, 0.02, 0.09, 0.18, 0.38268)]
    assert [own.v0, own.prominence, own.still, own.d_t, own.stray, own.place] == pytest.approx(
        wanted
    )
    paper = library.curves("jacks.bvh", "r_arm", 0, 1, "paper").thresholds
    assert (paper.v0, paper.d_t, paper.stray, paper.place) == (600, 50, 0, 250)


def test_a_record_is_json(library: Library) -> None:
    found = library.curves("jacks.bvh", "r_arm", 1.0, 3.0).record()
    assert json.loads(json.dumps(found)) == found
    assert {len(found[name]) for name in ("times", "speed", "distance", "azimuth", "cells")} == {
        120
    }
    assert found["azimuth_from"]["right"] == 337.5
    assert found["elevation_from"] == {"low": 0, "mid": 67.5, "high": 112.5}
    at = found["times"].index(2.0)
    elevation, level = found["elevation"][at], found["cells"][at].split()[1]
    assert level == ("low" if elevation < 67.5 else "mid" if elevation < 112.5 else "high")


def test_what_cannot_be_followed_is_said(library: Library, tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="a score, which has no movement"):
        library.curves("raise.lnd", "r_arm")
    with pytest.raises(UsageError, match='no part "step" is known') as caught:
        library.curves("jacks.bvh", "step")
    assert {"r_arm", "l_leg"} <= {*caught.value.wanted.replace(",", "").split()}
    with pytest.raises(UsageError, match="nothing from 20 s"):
        library.curves("jacks.bvh", "r_arm", 20, 21)
    library.curves("jacks.bvh", "r_arm")
    (tmp_path / "jacks.bvh").unlink()
    with pytest.raises(ExportError, match="jacks"):
        library.curves("jacks.bvh", "r_arm")


def test_its_own_profile_is_taken_or_missed(tmp_path: Path, repository: Path) -> None:
    with open_library(tmp_path / "l.db", create=True) as library:
        library.ingest(repository / "corpus/jumping_jacks.bvh", profile="paper")
        assert library.curves("jumping_jacks.bvh", "r_arm").thresholds.v0 == 600
    own = tmp_path / "mine"
    own.mkdir()
    built_in = repository / "lanindex/encoding/profiles/paper"
    for file in built_in.iterdir():
        (own / file.name).write_text(file.read_text().replace('"paper"', '"mine"'))
    with open_library(tmp_path / "m.db", create=True) as library:
        library.ingest(repository / "corpus/jumping_jacks.bvh", profile=str(own))
        with pytest.raises(UsageError, match='its profile "mine" is not here'):
            library.curves("jumping_jacks.bvh", "r_arm")
        assert library.curves("jumping_jacks.bvh", "r_arm", profile=own).profile.name == "mine"
