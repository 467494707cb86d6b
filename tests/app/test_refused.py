"""Captures that cost a pattern too much are named; the others are searched."""

import json
from pathlib import Path

import pytest
from sample_library import sample_score
from typer.testing import CliRunner

from lanindex import write_lnd
from lanindex.app.cli import app
from lanindex.errors import LanindexError
from lanindex.notation import eaf
from lanindex.pipeline.library import open_library
from lanindex.search import fuzzy, limits
from lanindex.search.match import arrays

PATTERN = "r_arm any with a: l_arm any ... b: any where b.end - a.start > 0.1s"

FUZZY = (  # the pattern itself is searched for exactly, too, or what must not happen
    "r_arm any ... any without r_arm any ... low",
    "r_arm any without (l_arm any ... any with r_arm any ... any) -> high",
)


NAMED = [f"{it}.lnd" for it in "234567"]


@pytest.fixture
def db(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return a library of seven captures that are too rich, between two that are not."""
    monkeypatch.setattr(limits, "MOST_TRIED", 1_000)
    with open_library(tmp_path / "l.db", create=True) as library:
        for name in ("a", *"234567", "z"):
            score = sample_score(0, ("r_arm", "l_arm"), 6 if name in "az" else 60)
            library.store.add(f"{name}.lnd", score, format="lnd", sha256=name)
    return tmp_path / "l.db"


def test_a_search_names_them_and_answers_the_others(db: Path) -> None:
    done = CliRunner().invoke(app, ["search", PATTERN, "--db", str(db), "--json"])
    assert done.exit_code == 2
    told = done.stderr.splitlines()
    assert [line.split(":")[0] for line in told[:5]] == [f"{it}.lnd" for it in "23456"]
    assert "the pattern fits in too many ways. Put fewer" in told[0]
    assert "1 more captures are too rich for this pattern" in told[5]
    assert "a.lnd" in done.stdout
    assert "z.lnd" in done.stdout


def test_a_tier_is_written_and_they_are_named(db: Path, tmp_path: Path) -> None:
    path = tmp_path / "a.eaf"
    path.write_bytes(eaf.write(sample_score(0, ("r_arm", "l_arm"), 6)))
    words = ["search", PATTERN, "--db", str(db), "--in", "[a2].lnd", "--into", str(path)]
    done = CliRunner().invoke(app, words)
    assert done.exit_code == 2
    assert done.stderr.startswith("2.lnd: the pattern fits in too many ways")
    assert " in the tier hits" in done.stderr.splitlines()[-1]


@pytest.mark.parametrize("pattern", FUZZY)
def test_a_fuzzy_search_names_them_too(db: Path, pattern: str) -> None:
    done = CliRunner().invoke(app, ["search", pattern, "--db", str(db), "--fuzzy", "0.5"])
    assert done.exit_code == 2
    told = done.stderr.splitlines()
    assert [line.split(":")[0] for line in told[:5]] == [f"{it}.lnd" for it in "23456"]
    assert "the pattern fits in too many ways. Put fewer" in told[0]
    with open_library(db) as library:
        hits = library.search(pattern, fuzzy="0.5")
        assert {Path(hit.path).name for hit in hits} == {"a.lnd", "z.lnd"}


def test_a_fuzzy_search_names_captures_with_too_many_symbols(
    db: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with open_library(db) as library:
        hits = library.search("r_arm any -> any", fuzzy="0.5")
        wanted = [str(hit) for hit in hits]
        of_few = [str(hit) for hit in hits if Path(hit.path).name in ("a.lnd", "z.lnd")]
        # what one capture has fits the keys of a search, what several have does not
        monkeypatch.setattr(fuzzy, "LATEST", 127)
        assert [str(hit) for hit in library.search("r_arm any -> any", fuzzy="0.5")] == wanted
        monkeypatch.setattr(fuzzy, "LATEST", 31)
        for best in (None, 1000):
            library.refused = []
            hits = library.search("r_arm any -> any", fuzzy="0.5", best=best)
            assert sorted(str(hit) for hit in hits) == sorted(of_few) != []
            assert [str(it).split(":")[0] for it in library.refused] == NAMED


def test_a_fuzzy_search_names_captures_with_too_many_pairs_of_lines(
    db: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pattern = "r_arm any with[100s] l_arm any"
    with open_library(db) as library:
        hits = library.search(pattern, fuzzy="0.5")
        wanted = [str(hit) for hit in hits if Path(hit.path).name in ("a.lnd", "z.lnd")]
        monkeypatch.setattr(limits, "available", lambda: 4 << 30)
        monkeypatch.setattr(arrays, "PAIR", 1 << 25)  # a line may have 32 others beside it
        assert [str(hit) for hit in library.search(pattern, fuzzy="0.5")] == wanted != []
        assert [str(it).split(":")[0] for it in library.refused] == NAMED
        assert all("the pattern fits in too many ways" in str(it) for it in library.refused)


def test_python_has_an_error_for_each(db: Path) -> None:
    with open_library(db) as library:
        hits = library.search(PATTERN)
        assert [Path(it.path).name for it, _ in hits.counts()] == ["a.lnd", "z.lnd"]
        assert len(library.refused) == 6
        assert len(library.search("r_arm high")) > 0
        assert len(library.refused) == 6


def test_why_says_that_it_cannot_be_told(db: Path) -> None:
    done = CliRunner().invoke(app, ["search", PATTERN, "--why", "3.lnd", "--db", str(db)])
    assert done.exit_code == 2
    with open_library(db) as library:
        seen = library.why(PATTERN, "3.lnd")
        assert (seen.hits, seen.stops) == ((), ())
        assert seen.refused
        assert str(seen.refused).startswith("3.lnd: the pattern fits in too many ways. Put fewer")
        assert library.why(PATTERN, "a.lnd").hits


NOTHING = PATTERN.replace("> 0.1s", "> 900s")


def test_a_search_that_finds_nothing_elsewhere_says_what_would_be_found(db: Path) -> None:
    done = CliRunner().invoke(app, ["search", NOTHING, "--db", str(db)])
    assert done.exit_code == 2
    assert "2.lnd: the pattern fits in too many ways" in done.stderr
    assert "The nearest patterns that find something:" in done.stderr


def test_advice_counts_the_other_captures(db: Path) -> None:
    told: list[str] = []
    with open_library(db) as library:
        library.store.session.note = told.append
        left_out = {it.condition: it for it in library.suggest(NOTHING).left_out}
        assert left_out["where b.end - a.start > 900s"].captures == 2
        assert [line.split(":")[0] for line in told[:5]] == [f"{it}.lnd" for it in "23456"]
        assert len(library.refused) == 6


def test_evaluate_names_them_and_counts_them_as_not_found(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(limits, "MOST_TRIED", 1_000)
    for name in ("few", "many"):
        score = sample_score(0, ("r_arm", "l_arm"), 6 if name == "few" else 60)
        (tmp_path / f"{name}.lnd").write_text(write_lnd(score))
    (tmp_path / "labels.csv").write_text("file,label\nfew.lnd,x\nmany.lnd,x\n")
    (tmp_path / "patterns.toml").write_text(f"long = {{pattern = '{PATTERN}', positives = ['x']}}")
    files = ["--labels", f"{tmp_path}/labels.csv", "--patterns", f"{tmp_path}/patterns.toml"]
    done = CliRunner().invoke(app, ["evaluate", str(tmp_path), *files, "--misses", "--json"])
    assert done.exit_code == 2
    assert f"long: {tmp_path}/many.lnd: the pattern fits in too many ways" in done.stderr
    result = json.loads(done.stdout.splitlines()[0])
    assert (result["found_rightly"], result["missed"]) == (1, 1)
    assert result["misses"][0]["obstacle"] == "the pattern fits in too many ways"


def test_in_less_memory_the_same_hits_are_found(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(limits, "LEAST", 0)
    with open_library(tmp_path / "l.db", create=True) as library:
        for number in range(3):
            score = sample_score(number, ("r_arm", "l_arm"), 60)
            library.store.add(f"{number}.lnd", score, format="lnd", sha256=str(number))
        found = [str(hit) for hit in library.search(PATTERN)]
        assert [str(hit) for hit in library.search(PATTERN, memory=2)] == found != []
        nearly = [str(hit) for hit in library.search(FUZZY[0], fuzzy="0.5")]
        assert (
            [str(hit) for hit in library.search(FUZZY[0], fuzzy="0.5", memory=20)] == nearly != []
        )
        with pytest.raises(LanindexError, match="too many ways"):
            list(library.search(FUZZY[0], fuzzy="0.5", memory=0.001))
    few = CliRunner().invoke(app, ["search", PATTERN, "--db", "l.db", "--memory", "1"])
    assert few.exit_code == 2
    assert "64" in few.stderr
