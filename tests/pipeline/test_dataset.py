"""Data sets: contents, splits, refusals."""

import io
import json
import shutil
from fractions import Fraction
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from dances import BOW, RAISE, dance
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

import lanindex
from lanindex.alphabet import JOINTS
from lanindex.encoding.joints import body
from lanindex.errors import ExportError, UsageError
from lanindex.formats import smpl
from lanindex.formats.smpl import CHAINS, grounded, placed, used
from lanindex.model import Capture
from lanindex.pipeline import dataset
from lanindex.pipeline.dataset import (
    distinct,
    performers,
    read_shares,
    sentence_of,
    sentence_of_symbols,
    split,
    units,
)
from lanindex.pipeline.layouts import SPLITS, joints22, tagged
from lanindex.pipeline.library import Library, open_library

PEOPLE = ("Ada", "Bo", "Cy", "Di", "Eve")


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Make a library of five people with two takes each, a score and a copy without performer."""
    folder = tmp_path_factory.mktemp("dataset")
    rows = ["file,label,performer,licence"]
    for number, person in enumerate(PEOPLE):
        for take, text in (("raise", RAISE), ("bow", BOW)):
            dance(folder / f"{person}_{take}.bvh", text, 30 + number)
            rows.append(f"{person}_{take}.bvh,{take},{person},{'CC0' if number else ''}")
    shutil.copy(folder / "Ada_raise.bvh", folder / "copy.bvh")
    (folder / "score.lnd").write_text(RAISE)
    (folder / "labels.csv").write_text("\n".join(rows))
    with open_library(folder / "l.db", create=True) as opened:
        opened.ingest(folder, labels=folder / "labels.csv")
    return folder


@pytest.fixture
def library(made: Path, tmp_path: Path):
    shutil.copytree(made, tmp_path / "here")
    with open_library(tmp_path / "here" / "l.db") as opened:
        for capture in opened.captures():
            opened.store.move(capture.id, tmp_path / "here" / Path(capture.path).name)
        yield opened


def index(folder: Path) -> list[dict]:
    return [json.loads(line) for line in (folder / "clips.jsonl").read_text().splitlines()]


def test_clips_hold_the_joints_of_their_frames(library: Library, tmp_path: Path) -> None:
    hits = library.search("r_arm right mid")
    card = library.dataset({"up": hits}, tmp_path / "set", pad="0.1s")
    rows = index(tmp_path / "set")
    assert card["clips"] == len(rows) == len([hit for hit in hits if hit.path[-3:] == "bvh"])
    for row in rows:
        clip = np.load(tmp_path / "set" / row["clip"])  # no pickle
        places = body(lanindex.read(row["capture"])).places
        there = places[row["start_frame"] : row["end_frame"]] / 1000
        assert clip["joints"].dtype == np.float32
        assert np.nanmax(np.abs(clip["joints"] - there)) < 1e-6
        assert (np.isnan(clip["joints"]) == np.isnan(there)).all()
        assert tuple(clip["joint_names"]) == JOINTS
        assert float(clip["fps"]) == row["fps"]
        assert list(clip["texts"]) == row["texts"]
        assert row["texts"][0] == row["label"] == "up"
        assert row["texts"][1] == "The right arm moves to the right, at middle height."
        arms = clip["symbol_part"] == "r_arm"
        words = set(zip(clip["symbol_direction"][arms], clip["symbol_level"][arms], strict=True))
        assert ("right", "mid") in words
        assert clip["symbol_frames"].min() >= 0
        assert clip["symbol_frames"].max() <= len(clip["joints"]) == row["frames"]
        again = lanindex.read(tmp_path / "set" / row["clip"])  # LanIndex reads it, too
        assert np.allclose(again.positions, clip["joints"] * 1000, atol=1e-3, equal_nan=True)


def test_clips_are_resampled(library: Library, tmp_path: Path) -> None:
    card = library.dataset(None, tmp_path / "set", fps=15)
    assert card["fps"] == 15
    for row in index(tmp_path / "set"):
        clip = np.load(tmp_path / "set" / row["clip"])
        source = lanindex.read(row["capture"])
        assert float(clip["fps"]) == 15
        assert len(clip["joints"]) == int((len(source) - 1) * 15 / source.rate) + 1
        if source.rate == 30:
            assert np.allclose(clip["joints"], body(source).places[::2] / 1000, atol=1e-6)
        assert clip["symbol_frames"].max() <= len(clip["joints"])


def test_no_performer_and_no_content_is_in_two_splits(library: Library, tmp_path: Path) -> None:
    library.dataset(None, tmp_path / "set")
    rows = index(tmp_path / "set")
    for name in ("performer", "capture"):
        splits: dict[str, set[str]] = {}
        for row in rows:
            splits.setdefault(row[name], set()).add(row["split"])
        splits.pop("", None)
        assert {len(one) for one in splits.values()} == {1}
    (copy,) = (row for row in rows if Path(row["capture"]).name == "copy.bvh")
    (original,) = (row for row in rows if Path(row["capture"]).name == "Ada_raise.bvh")
    assert copy["performer"] == ""
    assert copy["split"] == original["split"]
    assert {row["split"] for row in rows} == set(SPLITS)


@given(
    st.lists(
        st.tuples(st.sampled_from(["", "A", "B", "C", "D"]), st.sampled_from("uvwxyz")), max_size=12
    ),
    st.integers(0, 9),
)
def test_splits_keep_groups_whole_and_are_the_same_again(told, seed: int) -> None:
    captures = [
        Capture(number, f"{number}.bvh", "bvh", content, "", Fraction(30), 9,
                metadata={"performer": who} if who else {})
        for number, (who, content) in enumerate(told, 1)
    ]  # fmt: skip
    own = units(captures, performers(captures))
    weights = {unit: sum(it == unit for it in own.values()) for unit in own.values()}
    found = split(weights, read_shares("80/10/10"), seed)
    assert found == split(dict(reversed(weights.items())), read_shares("80/10/10"), seed)
    for one in captures:
        for other in captures:
            who = one.metadata.get("performer")
            if one.sha256 == other.sha256 or (who and who == other.metadata.get("performer")):
                assert found[own[one.id]] == found[own[other.id]]
    if len(weights) >= 3:
        assert set(found.values()) == set(SPLITS)


def test_shares_are_about_what_was_asked() -> None:
    weights = {str(number): number % 7 + 1 for number in range(400)}
    found = split(weights, read_shares("70/20/10"))
    for name, share in zip(SPLITS, (0.7, 0.2, 0.1), strict=True):
        got = sum(weight for unit, weight in weights.items() if found[unit] == name)
        assert abs(got / sum(weights.values()) - share) < 0.01
    assert found != split(weights, read_shares("70/20/10"), 1)
    assert set(split(weights, read_shares("100/0/0")).values()) == {"train"}


@pytest.mark.parametrize("text", ["80/20", "80/10/20", "a/b/c", "120/-10/-10", "", "1/0/0"])
def test_shares_that_are_none_are_refused(text: str) -> None:
    with pytest.raises(UsageError, match="80/10/10"):
        read_shares(text)


def test_the_card_counts_what_there_is(library: Library, tmp_path: Path) -> None:
    hits = {"up": library.search("r_arm right mid"), "front": library.search("r_arm forward mid")}
    card = library.dataset(hits, tmp_path / "set")
    rows = index(tmp_path / "set")
    assert card == json.loads((tmp_path / "set" / "card.json").read_text())
    for name in ("split", "label", "licence"):
        for key, told in card[f"by_{name}"].items():
            own = [row for row in rows if row[name] == key]
            assert told["clips"] == len(own)
            assert told["frames"] == sum(row["frames"] for row in own)
            assert told["captures"] == len({row["capture"] for row in own})
            assert told["hours"] == pytest.approx(sum(row["seconds"] for row in own) / 3600, 1e-3)
    assert set(card["by_licence"]) == {"CC0", "not told"}
    assert card["left_out"] == {"a score (lnd) has no motion": 2}
    assert [one["pattern"] for one in card["found"]] == ["r_arm right mid", "r_arm forward mid"]
    assert card["profiles"] == {"default": len(rows)}
    assert card["columns"] == list(rows[0])
    page = (tmp_path / "set" / "README.md").read_text()
    for said in ("not told", "CC0", "r_arm forward mid", "column performer", "Left out"):
        assert said in page


def test_without_performers_captures_are_kept_together(made: Path, tmp_path: Path) -> None:
    with open_library(tmp_path / "bare.db", create=True) as bare:
        bare.ingest(sorted(made.glob("*.bvh")))
        card = bare.dataset(bare.search("r_arm any"), tmp_path / "set")
        assert card["split_by"] == "capture"
        assert card["split_note"].startswith("Nobody told who performs")
        with pytest.raises(UsageError, match='no column "actor"'):
            bare.dataset(None, tmp_path / "more", split_by="actor")


def test_a_folder_that_holds_things_is_refused(library: Library, tmp_path: Path) -> None:
    folder = tmp_path / "set"
    folder.mkdir()
    (folder / "weights.bin").write_text("mine")
    with pytest.raises(ExportError, match="holds things already"):
        library.dataset(None, folder)
    library.dataset(None, folder, force=True)
    first = {row["clip"] for row in index(folder)}
    library.dataset(library.search("r_arm forward mid"), folder, force=True, seed=3)
    clips = {row["clip"] for row in index(folder)}
    there = {str(path.relative_to(folder)) for path in folder.rglob("*.npz")}
    assert there == clips != first  # of the earlier set nothing is left to leak
    assert (folder / "weights.bin").read_text() == "mine"
    with pytest.raises(ExportError, match="is no folder"):
        library.dataset(None, folder / "README.md")


def test_a_source_that_is_gone_or_changed_is_said(library: Library, tmp_path: Path) -> None:
    source = Path(library.capture("Bo_bow.bvh").location)
    data = source.read_bytes()
    source.write_bytes(data + b"\n")
    with pytest.raises(ExportError, match="has changed since it was ingested"):
        library.dataset(None, tmp_path / "set")
    assert not [path for path in (tmp_path / "set").rglob("*") if path.is_file()]
    source.unlink()
    with pytest.raises(ExportError, match=r"Bo_bow\.bvh: is no longer there"):
        library.dataset(None, tmp_path / "set")


def test_nothing_found_writes_nothing(library: Library, tmp_path: Path) -> None:
    card = library.dataset(library.search("head back low"), tmp_path / "set")
    assert card["clips"] == 0
    assert not (tmp_path / "set").exists()


def test_humanml3d_reads_back_as_the_same_places(library: Library, tmp_path: Path) -> None:
    card = library.dataset(None, tmp_path / "set", layout="humanml3d")
    names = (tmp_path / "set" / "all.txt").read_text().split()
    assert len(names) == card["clips"] > 0
    by_split = [(tmp_path / "set" / f"{one}.txt").read_text().split() for one in SPLITS]
    assert sorted(name for names_in in by_split for name in names_in) == names
    train = []
    for name, row in zip(
        sorted(names),
        sorted(index(tmp_path / "set"), key=lambda one: Path(one["clip"]).stem),
        strict=True,
    ):
        places = np.load(tmp_path / "set" / "new_joints" / f"{name}.npy")
        values = np.load(tmp_path / "set" / "new_joint_vecs" / f"{name}.npy")
        assert places.shape == (len(values), 22, 3)
        assert places[..., 1].min() == pytest.approx(0, abs=0.05)
        assert np.abs(places[0, 0, [0, 2]]).max() < 1e-6
        assert np.abs(placed(values[:, : used(263)]) - places).max() < 1e-5
        if name in by_split[0]:
            train.append(values)
        for line in (tmp_path / "set" / "texts" / f"{name}.txt").read_text().splitlines():
            caption, tokens, start, stop = line.split("#")
            assert (start, stop) == ("0.0", "0.0")
            assert caption in (row["texts"] or ["a movement"])
            assert all(len(token.split("/")) == 2 for token in tokens.split())
        # as far apart as in the source: only moved and turned as a whole
        whole = body(lanindex.read(row["capture"])).places / 1000
        wrists = whole[0, JOINTS.index("LWrist")] - whole[0, JOINTS.index("RWrist")]
        assert np.linalg.norm(places[0, 20] - places[0, 21]) == pytest.approx(
            np.linalg.norm(wrists), abs=1e-5
        )
    mean = np.load(tmp_path / "set" / "Mean.npy")
    assert np.allclose(mean, np.concatenate(train).mean(axis=0), atol=1e-5)
    assert (np.load(tmp_path / "set" / "Std.npy") >= 0).all()
    assert lanindex.read(tmp_path / "set" / "new_joint_vecs" / f"{name}.npy").rate == 20


def test_features_turn_bones_to_where_they_are() -> None:
    """Carry out the turns along the chains, as those who train on them do."""
    random = np.random.default_rng(0)
    places = grounded(np.cumsum(random.normal(size=(40, 22, 3)) * 0.03, axis=0)
                      + random.normal(size=(22, 3)))  # fmt: skip
    values = smpl.features(places).astype(np.float64)
    turns = 2 * np.cumsum(np.append(0, values[:-1, 0]))
    root = Rotation.from_rotvec(np.outer(turns, [0, 1, 0])).as_matrix()
    for chain in CHAINS:
        matrix = root
        for parent, child in pairwise(chain):
            six = values[:, 67 + 6 * (child - 1) :][:, :6]
            x, y = six[:, :3], six[:, 3:]
            own = np.stack((x, y, np.cross(x, y)), axis=-1)
            assert np.allclose(own.swapaxes(1, 2) @ own, np.eye(3), atol=1e-5)
            matrix = matrix @ own
            bone = places[:-1, child] - places[:-1, parent]
            length = np.linalg.norm(bone, axis=1)[:, None]
            assert np.allclose(matrix @ smpl._rest_direction(child), bone / length, atol=1e-4)
    velocity = values[:, 193:259].reshape(-1, 22, 3)
    assert np.allclose(
        np.linalg.norm(velocity, axis=2),
        np.linalg.norm(np.diff(places, axis=0), axis=2),
        atol=1e-5,
    )
    assert set(np.unique(values[:, 259:])) <= {0.0, 1.0}


def test_clips_without_some_joint_are_left_out_of_humanml3d(tmp_path: Path, library) -> None:
    whole = body(lanindex.read(library.capture("Bo_bow.bvh").location)).places / 1000
    here = np.where(np.array([name in ("LToe", "RToe") for name in JOINTS])[:, None], np.nan, whole)
    content = io.BytesIO()
    np.savez(content, joints=here, joint_names=np.array(JOINTS), fps=31, unit="m", up="y")
    (tmp_path / "toeless.npz").write_bytes(content.getvalue())
    library.ingest(tmp_path / "toeless.npz")
    card = library.dataset(None, tmp_path / "set", layout="humanml3d")
    assert card["left_out"]["not known all the time: RToe, LToe"] == 1
    with pytest.raises(UsageError, match="20, as humanml3d has it"):
        library.dataset(None, tmp_path / "other", layout="humanml3d", fps=30)
    with pytest.raises(UsageError, match="npz or humanml3d"):
        library.dataset(None, tmp_path / "other", layout="zarr")


def test_the_spine_lies_between_pelvis_and_neck() -> None:
    places = np.zeros((1, 20, 3))
    for name, height in (("Pelvis", 1.0), ("Chest", 1.1), ("Neck", 1.5)):
        places[0, JOINTS.index(name), 1] = height
    made = joints22(places)
    assert made[0, [3, 6, 9], 1] == pytest.approx([1.12, 1.25, 1.3])


def test_texts_say_what_was_seen() -> None:
    rest = {"part": "l_arm", "direction": "place", "level": "low", "start_frame": 0, "end_frame": 0}
    move = {**rest, "direction": "left", "level": "high", "end_frame": 9, "amount": 3}
    turn = {"part": "body_turn", "direction": "left", "level": None, "start_frame": 2,
            "end_frame": 5, "amount": 90}  # fmt: skip
    assert sentence_of_symbols([rest, move, turn]) == (
        "The left arm is straight down, then moves to the left, high, bent by degree 3, while the "
        "body turns to the left, by 68 to 112 degrees."
    )
    many = [{**move, "start_frame": it} for it in range(40)]
    assert sentence_of_symbols([]) == sentence_of_symbols(many) == ""
    assert sentence_of("no pattern at all") == ""
    assert distinct(["a", "", " a ", "b\nc"]) == ["a", "b c"]
    assert tagged("kick #3") == "kick/VERB"
    assert dataset.PERFORMERS[0] == "performer"
