"""Motion-BIDS: positions without a header, described by the files beside them."""

import json
import shutil
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import lanindex
from lanindex import formats
from lanindex.errors import CaptureError, LanindexError, UsageError
from lanindex.formats import bids
from lanindex.model import Motion, Reading
from lanindex.pipeline.ingest import discover
from lanindex.pipeline.library import open_library

STEM = "sub-01_task-jump_tracksys-body"
NAME = f"{STEM}_motion.tsv"


def saved(folder: Path, motion: Motion | None = None) -> Path:
    """Write a motion, and return where its positions are."""
    motion = motion or lanindex.read("corpus/jumping_jacks.bvh")
    for path, content in bids.files(motion, folder / NAME):
        path.write_bytes(content)
    return folder / NAME


def changed(folder: Path, ending: str, *pairs: tuple[str, str]) -> Path:
    path = saved(folder).with_name(STEM + ending)
    text = path.read_text()
    for old, new in pairs:
        assert old in text
        text = text.replace(old, new)
    path.write_text(text)
    return folder / NAME


def test_what_is_written_is_read(tmp_path: Path) -> None:
    motion = lanindex.read("corpus/jumping_jacks.bvh")
    again = lanindex.read(saved(tmp_path))
    assert (again.source.format, again.source.unit, again.source.up) == ("bids", "m", "y")
    assert (again.rate, len(again), again.warnings) == (motion.rate, len(motion), ())
    places = dict(zip(again.skeleton.names, range(99), strict=False))
    order = [places[name] for name in motion.skeleton.names]
    assert np.abs(again.positions[:, order] - motion.positions).max() < 1e-3
    score, found = lanindex.encode(motion), lanindex.encode(again)
    for part in ("r_arm", "l_leg", "r_support", "jump"):
        assert list(map(str, found.symbols(part))) == list(map(str, score.symbols(part)))


def test_what_the_files_say(tmp_path: Path) -> None:
    path = saved(tmp_path)
    rows = [line.split("\t") for line in path.read_text().splitlines()]
    channels = (tmp_path / f"{STEM}_channels.tsv").read_text().splitlines()
    assert channels[0] == "name\tcomponent\ttype\ttracked_point\tunits\treference_frame"
    assert channels[1] == "Hips_x\tx\tPOS\tHips\tm\tglobal"
    assert {len(row) for row in rows} == {len(channels) - 1}
    said = json.loads((tmp_path / f"{STEM}_motion.json").read_text())
    assert (said["SamplingFrequency"], said["TaskName"], said["POSChannelCount"]) == (
        30,
        "jump",
        84,
    )


def test_what_is_unknown(tmp_path: Path) -> None:
    path = saved(tmp_path)
    lines = path.read_text().splitlines()
    cells = lines[5].split("\t")
    cells[:3] = ["n/a", " ", "n/a"]
    lines[5] = "\t".join(cells)
    path.write_text("\n".join(lines))
    found = lanindex.read(path)
    assert np.isnan(found.positions[5]).all(axis=1).sum() == 1
    again = lanindex.read(saved(tmp_path, found))
    assert np.array_equal(np.isnan(again.positions), np.isnan(found.positions))
    assert b"n/a\tn/a\tn/a" in path.read_bytes()


@pytest.mark.parametrize("axes", ["FRU", "RSP", "PUR"])
def test_axes_that_lead_elsewhere(tmp_path: Path, axes: str) -> None:
    path = saved(tmp_path)
    before = lanindex.read(path).positions
    left, up, ahead = np.moveaxis(np.loadtxt(path).reshape(360, -1, 3), -1, 0)
    ours = {"R": -left, "U": up, "S": up, "F": ahead, "P": -ahead}
    np.savetxt(path, np.stack([ours[it] for it in axes], -1).reshape(360, -1), delimiter="\t")
    frames = tmp_path / f"{STEM}_channels.json"
    frames.write_text(frames.read_text().replace("LSA", axes))
    assert np.abs(lanindex.read(path).positions - before).max() < 1e-2


def test_axes_in_the_sidecar_or_nowhere(tmp_path: Path) -> None:
    path = saved(tmp_path)
    (tmp_path / f"{STEM}_channels.json").unlink()
    (doubt,) = lanindex.read(path).warnings
    assert doubt == "where its axes lead is not told: taken for right-handed"
    sidecar = tmp_path / f"{STEM}_motion.json"
    sidecar.write_text(sidecar.read_text().replace("{", '{"SpatialAxes": "LSA",', 1))
    assert lanindex.read(path).warnings == ()


def test_times_of_their_own(tmp_path: Path) -> None:
    path = changed(tmp_path, "_channels.tsv", ("Hips_x\tx\tPOS\tHips\tm\tglobal",
                   "time\tn/a\tLATENCY\tn/a\ts\tn/a\nHips_x\tx\tPOS\tHips\tm\tglobal"))  # fmt: skip
    lines = path.read_text().splitlines()
    path.write_text("\n".join(f"{at / 60:.6f}\t{line}" for at, line in enumerate(lines)) + "\n")
    found = lanindex.read(path)
    assert found.rate == 60
    assert found.warnings == ("says 30 frames a second, its times say 60: the times believed",)


def test_one_frame(tmp_path: Path) -> None:
    path = saved(tmp_path)
    path.write_text(path.read_text().splitlines()[0])
    assert len(lanindex.read(path)) == 1


@pytest.mark.parametrize(
    ("ending", "pairs", "said"),
    [
        ("_channels.tsv", [("component", "axis")], "_channels.tsv:1: no column component, wanted"),
        (
            "_channels.tsv",
            [("\tPOS\t", "\tVEL\t")],
            "no positions, wanted channels of the type POS",
        ),
        (
            "_channels.tsv",
            [("Hips_z\tz\tPOS\tHips\tm\tglobal\n", "")],
            "1: 84 columns, _channels.tsv",
        ),
        ("_channels.tsv", [("Hips_x\tx", "Hips_x\tz")], "_channels.tsv:4: z of 'Hips' again"),
        ("_channels.tsv", [("Head\tm\t", "Head\tmm\t")], "positions in 'm' and 'mm'"),
        ("_channels.tsv", [("Head\tm\tglobal", "Head\tm\tlocal")], "in 'global' and 'local'"),
        ("_channels.tsv", [("\tm\t", "\tfurlong\t")], "positions in 'furlong', wanted one of mm"),
        ("_motion.json", [("{", "")], "_motion.json: damaged JSON"),
        ("_motion.json", [("SamplingFrequency", "Frequency")], "_motion.json"),
        ("_motion.json", [(": 30.0", ': "30"')], "_motion.json"),
        (
            "_channels.json",
            [
                (
                    "{",
                    "[",
                )
            ],
            "_channels.json: damaged JSON",
        ),
        ("_motion.tsv", [("0.", "o.")], "o.0"),
    ],
)
def test_what_is_wrong_is_said(
    tmp_path: Path, ending: str, pairs: list[tuple[str, str]], said: str
) -> None:
    path = changed(tmp_path, ending, *pairs)
    with pytest.raises(LanindexError) as caught:
        lanindex.read(path)
    assert said in str(caught.value)


@pytest.mark.parametrize("ending", ["_channels.tsv", "_motion.json"])
def test_files_that_are_missing(tmp_path: Path, ending: str) -> None:
    path = saved(tmp_path)
    (tmp_path / (STEM + ending)).unlink()
    with pytest.raises(CaptureError) as caught:
        lanindex.read(path)
    assert str(caught.value) == f"{path}: no file that tells of it beside it, wanted {STEM}{ending}"


def test_no_frames(tmp_path: Path) -> None:
    path = saved(tmp_path)
    path.write_text("\n")
    with pytest.raises(CaptureError, match="no frames, wanted lines of numbers"):
        lanindex.read(path)


@given(data=st.data())
@settings(max_examples=40, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_damage_is_read_or_refused(tmp_path: Path, data: st.DataObject) -> None:
    path = saved(tmp_path)
    beside = tmp_path / (STEM + data.draw(st.sampled_from(
        ["_motion.tsv", "_channels.tsv", "_motion.json", "_channels.json"])))  # fmt: skip
    content = beside.read_bytes()
    start = data.draw(st.integers(0, min(len(content), 2000)))
    stop = data.draw(st.integers(start, min(start + 9, len(content))))
    beside.write_bytes(content[:start] + data.draw(st.binary(max_size=4)) + content[stop:])
    with suppress(LanindexError):
        lanindex.read(path)


def test_other_names_are_refused(tmp_path: Path) -> None:
    motion = lanindex.read("corpus/compass.bvh")
    for name in ("walk_motion.tsv", "sub-01_task-a b_tracksys-c_motion.tsv", "walk.bvh"):
        with pytest.raises(UsageError, match="wanted a name like sub-01_task-walk_tracksys-body"):
            list(bids.files(motion, tmp_path / name))


def test_points_of_one_name_are_told_apart() -> None:
    assert bids._distinct_names(("a", "a", "a 2", "b\tc", "", "a")) == [
        "a",
        "a 2",
        "a 2 2",
        "b c",
        "point",
        "a 3",
    ]


def test_a_folder_and_a_library(tmp_path: Path) -> None:
    place = tmp_path / "data" / "sub-01" / "motion"
    place.mkdir(parents=True)
    path = saved(place)
    shutil.copy(path, place / "events.tsv")
    assert list(discover([tmp_path / "data"])) == [str(path)]
    assert formats.is_capture(str(path))
    beside = formats.companions(formats.opened(path), Reading())
    assert [Path(it.name).name for it in beside] == [
        *(f"{STEM}_channels.tsv", f"{STEM}_motion.json", f"{STEM}_channels.json")
    ]
    with open_library(tmp_path / "l.db", create=True) as library:
        (done,) = library.ingest(path)
        assert (done.status, done.seconds) == ("added", 12.0)
        hits = library.search("r_arm high")
        (row, *_) = library.export(hits[:1], tmp_path / "clips")
        assert row["clip"].endswith(".csv")
