"""Precision, recall and F1, worked by hand, and their standard error, by a plain loop."""

import importlib
import math
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from random import Random

import numpy as np
import pytest
from dances import BOW, RAISE, dance
from effort import seeds
from generated_patterns import random_patterns
from hypothesis import given
from hypothesis import strategies as st
from in_shards import Here
from plain_matcher import find
from random_library import DIRECTIONS, PARTS, random_library

from lanindex.encoding.profile import load
from lanindex.errors import LanindexError, UsageError
from lanindex.evaluate import (
    Clip,
    Expectation,
    Result,
    evaluate,
    read_clips,
    read_patterns,
    summary,
)
from lanindex.model import Capture
from lanindex.search.language import parse

UP = Expectation("up", "r_arm high", parse("r_arm high"), frozenset({"raise"}))


def result(found: str, wanted: str, expectation: Expectation = UP) -> Result:
    """Return a result from rows of + and -."""
    return Result(expectation, *(tuple(it == "+" for it in row) for row in (found, wanted)), ())


def test_figures_by_hand() -> None:
    record = result("++-+-", "+-++-").record()
    assert (record["found_rightly"], record["found_wrongly"], record["missed"]) == (2, 1, 1)
    assert record["precision"] == pytest.approx(2 / 3)
    assert record["recall"] == pytest.approx(2 / 3)
    assert record["f1"] == pytest.approx(2 / 3)
    assert (record["positives"], record["clips"]) == (3, 5)


@pytest.mark.parametrize(
    ("found", "wanted", "precision", "recall", "f1"),
    [
        ("---", "+--", 0.0, 0.0, 0.0),
        ("--+", "+--", 0.0, 0.0, 0.0),
        ("+++", "+--", 1 / 3, 1.0, 0.5),
        ("---", "---", 0.0, 0.0, None),
        ("+--", "---", 0.0, 0.0, None),
    ],
)
def test_edges(found: str, wanted: str, precision: float, recall: float, f1: float | None) -> None:
    record = result(found, wanted).record()
    assert (record["precision"], record["recall"], record["f1"]) == (precision, recall, f1)


def test_the_mean_counts_patterns_that_have_positives() -> None:
    told = summary([result("++-", "+--"), result("+--", "+--"), result("--+", "---")])
    assert told["mean_f1"] == pytest.approx((2 / 3 + 1) / 2)
    assert (told["clips"], told["patterns"]) == (3, 3)
    nothing = summary([result("+-", "--")])
    assert nothing["mean_f1"] is None
    assert nothing["standard_error"] is None


def test_what_is_all_right_has_no_error() -> None:
    assert summary([result("+---------", "+---------")])["standard_error"] == 0


@given(st.lists(st.tuples(st.booleans(), st.booleans()), min_size=1, max_size=12))
def test_the_error_is_that_of_a_plain_bootstrap(clips: list[tuple[bool, bool]]) -> None:
    clips = [(True, True), *clips]
    found, wanted = zip(*clips, strict=True)
    told = summary([Result(UP, found, wanted, ())])["standard_error"]
    draws = np.random.default_rng(1).integers(len(clips), size=(4000, len(clips)))
    values = []
    for draw in draws.tolist():
        both = sum(found[clip] and wanted[clip] for clip in draw)
        either = sum(found[clip] + wanted[clip] for clip in draw)
        values.append(2 * both / either if either else 1.0)
    mean = sum(values) / len(values)
    plain = math.sqrt(sum((value - mean) ** 2 for value in values) / len(values))
    assert told == pytest.approx(plain, abs=0.03)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    dance(tmp_path / "raise.bvh", RAISE)
    dance(tmp_path / "bow.bvh", BOW)
    (tmp_path / "broken.bvh").write_text("HIERARCHY\n")
    (tmp_path / "unlabelled.bvh").write_bytes((tmp_path / "bow.bvh").read_bytes())
    return tmp_path


def test_clips_are_what_has_a_label_and_lies_there(folder: Path) -> None:
    labels = {
        str(folder / f"{name}.bvh"): (label, {"take": "1"})
        for name, label in {
            "raise": "raise",
            "bow": "bow",
            "broken": "raise",
            "gone": "bow",
        }.items()
    }
    clips = list(read_clips(folder, labels, load()))
    assert [Path(clip.capture.path).stem for clip in clips] == ["bow", "broken", "raise"]
    assert [clip.capture.label for clip in clips] == ["bow", "raise", "raise"]
    assert clips[0].capture.metadata == {"take": "1"}
    assert "broken.bvh" in str(clips[1].error)
    assert not clips[1].tracks
    (judged,) = evaluate(clips, [UP])
    assert judged.wanted == (False, True, True)
    assert judged.found == (False, False, True)
    (miss,) = judged.misses
    assert miss.capture is clips[1].capture
    assert miss.hit is None


def test_left_out_keeps_only_what_the_other_clips_need(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.syspath_prepend(Path(__file__).parent / "benchmarks")
    left_out = importlib.import_module("left_out")
    labels = {str(folder / f"{name}.bvh"): (name, {}) for name in ("raise", "bow")}
    judge = left_out.Judge(list(read_clips(folder, labels, load())), ["raise"])
    text = "r_arm high without (head low with torso) never l_leg mid or r_arm forward mid"
    assert list(left_out.pieces(text)) == [
        *("r_arm high", "without (head low with torso)", "never l_leg mid", "or r_arm forward mid")
    ]
    both = list(judge.wanted)
    assert judge.made_on(text, both) == "r_arm high"
    told = judge.left_out(text, {it: [it] for it in both})
    assert judge.counts(text, both) == (1, 1, 0)
    assert told == {it: (int(judge.wanted[it]), 0, 0) for it in both}


def test_what_is_wrongly_found_shows_its_hit(folder: Path) -> None:
    labels = {str(folder / "raise.bvh"): ("other", {})}
    (miss,) = evaluate(list(read_clips(folder, labels, load())), [UP])[0].misses
    assert miss.hit is not None
    assert [symbol.level for symbol in miss.hit.symbols] == ["high"]


def test_of_several_wrong_hits_the_first_is_shown(folder: Path) -> None:
    (clip,) = read_clips(folder, {str(folder / "raise.bvh"): ("other", {})}, load())
    anything = Expectation("any", "r_arm any", parse("r_arm any"), frozenset({"raise"}))
    (miss,) = evaluate([clip], [anything])[0].misses
    spans = [hit.span for hit in find(anything.query, [(clip.capture, clip.tracks)])]
    assert len(spans) > 1
    assert miss.hit is not None
    assert miss.hit.span == min(spans)


def test_patterns_are_read(tmp_path: Path) -> None:
    path = tmp_path / "p.toml"
    path.write_text('up = {pattern = "r_arm high", positives = ["raise", "wave"]}\n')
    (pattern,) = read_patterns(path)
    assert (pattern.name, pattern.text) == ("up", "r_arm high")
    assert pattern.positives == {"raise", "wave"}


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("", "no patterns"),
        ("up = ", "wanted TOML"),
        (f"up = {'9' * 5000}", "a number without end, wanted at most 4300 digits"),
        (f"up = {'[' * 100_000}", "brackets inside brackets, too many, wanted TOML"),
        (f"up = 0x{'f' * 5000}", "up = something too large to show, wanted name = {"),
        (f"{'u' * 5000} = 1", f"{'u' * 59}… = 1, wanted name = {{"),
        ('up = "r_arm high"', "up = 'r_arm high'"),
        ('up = {pattern = "r_arm high"}', "up = {"),
        ('up = {pattern = "r_arm high", positives = [1]}', "up = {"),
        ('up = {pattern = "r_arm high", positives = [], more = 1}', "up = {"),
        ('up = {pattern = "r_arm hgih", positives = []}', 'Did you mean "high"?'),
    ],
    ids=lambda text: text[:40],
)
def test_bad_patterns_are_told(tmp_path: Path, text: str, found: str) -> None:
    path = tmp_path / "p.toml"
    path.write_text(text)
    with pytest.raises(LanindexError) as caught:
        read_patterns(path)
    assert str(path) in str(caught.value)
    assert len(str(caught.value)) < 400
    assert found in str(caught.value)


def test_a_clip_without_tracks_is_never_found() -> None:
    clip = Clip(Capture(1, "a", "bvh", "", "raise", Fraction(30), 10), {}, "torn")
    assert evaluate([clip], [UP])[0].found == (False,)


def wants(*positives: str) -> Expectation:
    return Expectation("up", "r_arm high", parse("r_arm high"), frozenset(positives))


@pytest.mark.parametrize(
    ("positives", "label", "fits"),
    [
        (["walk*"], "walk slow", True),
        (["walk*"], "Walk", False),
        (["run", "walk [a]"], "walk [a]", True),
        (["walk [ab]"], "walk b", True),
        (["*"], "run", True),
        (["*"], "", False),
        (["walk"], "walks", False),
        ([], "", False),
    ],
)
def test_positives_are_labels_or_globs(positives: list[str], label: str, fits: bool) -> None:
    assert wants(*positives).wants(label) is fits


def test_positives_that_fit_no_label_are_told() -> None:
    assert wants("run", "walk*", "jump*").unused(["walk slow", "", "jum"]) == ["jump*", "run"]


def test_a_score_counts_in_its_own_beats(tmp_path: Path) -> None:
    slow = "#speed=30\n#unit0\ndirection r_arm place low 0 0\n#unit1\n"
    (tmp_path / "slow.lnd").write_text(slow + "direction r_arm place high 1 3\n")
    labels = {str(tmp_path / "slow.lnd"): ("raise", {})}
    (clip,) = read_clips(tmp_path, labels, load())
    for text, found in (("r_arm high 2b", True), ("r_arm high 4s", True), ("r_arm high 4b", False)):
        question = Expectation("up", text, parse(text), frozenset({"raise"}))
        assert evaluate([clip], [question])[0].found == (found,)


def test_the_record_holds_what_was_judged_wrongly(folder: Path) -> None:
    names = {"raise": "other", "bow": "raise"}
    labels = {str(folder / f"{name}.bvh"): (label, {}) for name, label in names.items()}
    (judged,) = evaluate(list(read_clips(folder, labels, load())), [UP])
    assert "misses" not in judged.record()
    missed, wrong = judged.record(misses=True)["misses"]
    assert (missed["kind"], missed["label"]) == ("missed", "raise")
    assert missed["capture"].endswith("bow.bvh")
    assert missed["obstacle"] == judged.obstacle(judged.misses[0])
    assert (wrong["kind"], wrong["label"]) == ("wrong", "other")
    assert wrong["hit"]["capture"] == wrong["capture"]
    assert wrong["hit"]["symbols"][0]["level"] == "high"


def test_a_pattern_may_stand_in_a_file_beside(tmp_path: Path):
    (tmp_path / "up.lq").write_text("// up\nr_arm low -> high\n")
    table = tmp_path / "patterns.toml"
    table.write_text('up = {pattern = "@up.lq", positives = ["raise"]}')
    assert str(read_patterns(table)[0].query) == "r_arm low -> high"
    (tmp_path / "up.lq").write_text("// up\nr_arm lwo -> high\n")
    with pytest.raises(UsageError, match=r"up\.lq:2:"):
        read_patterns(table)


def test_words_of_the_dictionary_and_ones_own_are_patterns(tmp_path: Path):
    own, path = tmp_path / "own.toml", tmp_path / "patterns.toml"
    own.write_text('salute = {pattern = "r_arm high"}\n')
    path.write_text(
        "".join(f'{word} = {{pattern = "{word}", positives = []}}\n' for word in ("walk", "salute"))
    )
    path.write_text(path.read_text() + 'both = {pattern = "@salute with @walk", positives = []}\n')
    walk, salute, both = (str(it.query) for it in read_patterns(path, own))
    assert walk.startswith("body_travel not place 0.9s+")
    assert salute == "r_arm high"
    assert salute in both
    with pytest.raises(UsageError, match="salute"):
        read_patterns(path)


def test_a_pattern_that_pipes_its_hits_is_none_to_evaluate(tmp_path: Path):
    table = tmp_path / "patterns.toml"
    table.write_text('up = {pattern = "r_arm high | first 3", positives = ["raise"]}')
    with pytest.raises(UsageError, match=r'up: "\| first 3", wanted a pattern without a pipe'):
        read_patterns(table)


@pytest.mark.parametrize("seed", seeds(3))
@pytest.mark.parametrize("fuzzy", [None, "1"])
def test_batches_of_clips_are_judged_the_same(
    seed: int, fuzzy: str | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("lanindex.evaluate.FEWEST", 1)
    random = Random(seed)
    clips = [
        Clip(replace(capture, label=random.choice(("a", "b", ""))), tracks, None)
        for capture, tracks in random_library(random, captures=14, most=8, known=PARTS)
    ]
    texts = ["r_arm any -> any", "arm low -> high", "arms low ... high", "l_arm right -> left"]
    if fuzzy is None:  # not all have edits
        texts += random_patterns(seed, 4, directions=DIRECTIONS, steps=2)
    table = [Expectation(text, text, parse(text), frozenset("a")) for text in texts]
    told = []
    for spread in (None, *map(Here, (1, 2, 7))):
        at: list[tuple[str, int, int]] = []
        how = {"fuzzy": fuzzy, "progress": lambda *it, at=at: at.append(it)}
        judged = evaluate(clips, table, **how, spread=spread)
        told.append([(repr(it.record(misses=True)), [*map(str, it.refused)]) for it in judged])
    assert told[1:] == told[:1] * 3
    assert at[-1][0] == "clips"
