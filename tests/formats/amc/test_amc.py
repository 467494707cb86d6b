"""AMC and ASF: reading, refusals, and where the skeleton is found."""

import os
from fractions import Fraction
from pathlib import Path
from zipfile import ZipFile

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from lanindex import formats
from lanindex.errors import CaptureError
from lanindex.formats import amc
from lanindex.formats.amc import Numbers
from lanindex.formats.file import File, opened
from lanindex.model import Motion, Reading, Span
from lanindex.pipeline.library import open_library

# name, what it hangs on, where it goes (cm), how its axes are turned, dof
BONES = (
    ("lfemur", "root", (9, -40, 0), (0, 0, 20), "rx ry rz"),
    ("ltibia", "lfemur", (0, -42, 0), (0, 0, 20), "rx"),
    ("lfoot", "ltibia", (0, 0, 20), (-90, 0, 20), "rx rz"),
    ("rfemur", "root", (-9, -40, 0), (0, 0, -20), "rx ry rz"),
    ("rtibia", "rfemur", (0, -42, 0), (0, 0, -20), "rx"),
    ("rfoot", "rtibia", (0, 0, 20), (-90, 0, -20), "rx rz"),
    ("thorax", "root", (0, 50, 0), (0, 0, 0), "rx ry rz"),
    ("lclavicle", "thorax", (17, 0, 0), (0, 0, 0), ""),
    ("lhumerus", "lclavicle", (28, 0, 0), (180, -30, -90), "rx ry rz"),
    ("lradius", "lhumerus", (18, 0, 0), (180, -30, -90), "rx"),
    ("lwrist", "lradius", (9, 0, 0), (0, 90, 90), "ry"),
    ("lhand", "lwrist", (9, 0, 0), (0, 90, 90), "rx rz"),
    ("rclavicle", "thorax", (-17, 0, 0), (0, 0, 0), ""),
    ("rhumerus", "rclavicle", (-28, 0, 0), (180, 30, 90), "rx ry rz"),
    ("rradius", "rhumerus", (-18, 0, 0), (180, 30, 90), "rx"),
    ("rwrist", "rradius", (-9, 0, 0), (0, -90, -90), "ry"),
    ("rhand", "rwrist", (-9, 0, 0), (0, -90, -90), "rx rz"),
    ("head", "thorax", (0, 20, 0), (0, 0, 0), "rx ry rz"),
)
WIDTHS = {"root": 6, **{name: len(dof.split()) for name, *_, dof in BONES if dof}}


def asf(length: str = "2.54", angle: str = "deg", end: str = "\n") -> bytes:
    """Return a person of 1.6 m with arms stretched out."""
    lines = ["# made", ":version 1.10", ":units", f" length {length}", f" angle {angle}", ":root"]
    lines += [" order TX TY TZ RX RY RZ", " axis XYZ", " position 0 0 0", " orientation 0 0 0"]
    lines += [":bonedata"]
    for number, (name, _, shift, axis, dof) in enumerate(BONES, 1):
        size = sum(part * part for part in shift) ** 0.5
        turned = [a if angle == "deg" else np.radians(a) for a in axis]
        lines += [" begin", f"  id {number}", f"  name {name}"]
        lines += [f"  direction {' '.join(str(part / size) for part in shift)}"]
        lines += [f"  length {size}", f"  axis {' '.join(map(str, turned))} XYZ"]
        lines += [f"  dof {dof}", "  limits (-160.0 20.0)", "         (-70 70)"] if dof else []
        lines += [" end"]
    lines += [":hierarchy", " begin"]
    below: dict[str, list[str]] = {}
    for name, above, *_ in BONES:
        below.setdefault(above, []).append(name)
    lines += [f"  {above} {' '.join(names)}" for above, names in below.items()]
    return (end.join([*lines, " end"]) + end).encode()


def numbers(frames: int) -> np.ndarray:
    random = np.random.default_rng(5)
    start = random.normal(0, 30, sum(WIDTHS.values()))
    start[:6] = 0, 90, 0, 3, -5, 2
    values: np.ndarray = (start + random.normal(0, 0.5, (frames, len(start)))).round(4)
    return values


def motion(values: np.ndarray, order: tuple[str, ...] = tuple(WIDTHS), first: int = 1) -> bytes:
    stops = dict(zip(WIDTHS, np.cumsum(list(WIDTHS.values())).tolist(), strict=True))
    lines = ["# made", ":FULLY-SPECIFIED", ":DEGREES"]
    for number, row in enumerate(values.tolist(), first):
        lines.append(str(number))
        for name in order:
            words = row[stops[name] - WIDTHS[name] : stops[name]]
            lines.append(" ".join([name, *map(str, words)]))
    return ("\n".join(lines) + "\n").encode()


GOOD = motion(numbers(4))
LINES = GOOD.splitlines(keepends=True)
FRAME = len(WIDTHS) + 1


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "ada.asf").write_bytes(asf())
    return tmp_path


def read(folder: Path, data: bytes, **told: object) -> Motion:
    (folder / "ada_1.amc").write_bytes(data)
    return formats.read_file(
        opened(folder / "ada_1.amc"),
        Reading(**told),
        formats.Wanted(),  # type: ignore[arg-type]
    )


def test_places_and_rotations_are_scipys(folder: Path) -> None:
    values = numbers(3)
    found = read(folder, motion(values))
    turns = {"root": Rotation.from_euler("xyz", values[:, 3:6], degrees=True)}
    begun = {"root": values[:, :3]}
    ends = {"root": values[:, :3]}
    column = 6
    for name, above, shift, axis, dof in BONES:
        own = Rotation.identity(3)
        for about in dof.split():
            own = Rotation.from_euler(about[1], values[:, [column]], degrees=True) * own
            column += 1
        axes = Rotation.from_euler("xyz", axis, degrees=True)
        turns[name] = turns[above] * axes * own * axes.inv()
        begun[name], ends[name] = ends[above], ends[above] + turns[name].apply(shift)
    skeleton = found.skeleton
    for index, name in enumerate(skeleton.names):
        bone = name.removesuffix(" End")
        wanted = ends[bone] if name.endswith(" End") else begun[bone]
        np.testing.assert_allclose(found.positions[:, index], wanted * 10, atol=1e-3)
        assert found.rotations is not None
        quaternion = turns[bone].as_quat(scalar_first=True)
        alike = np.abs((found.rotations[:, index] * quaternion).sum(axis=1))
        np.testing.assert_allclose(alike, 1, atol=1e-6)
    assert skeleton.names[-1] == "head End"
    np.testing.assert_allclose(
        skeleton.offsets[skeleton.names.index("lradius")], (280, 0, 0), atol=1e-3
    )
    played = skeleton.played()
    assert [played[it] for it in ("LHip", "RKnee", "LAnkle", "RElbow")] == [
        "lfemur", "rtibia", "lfoot", "rradius"
    ]  # fmt: skip
    assert played["LWrist"] == "lhand"  # behind the last third of the forearm
    assert (found.source.format, found.source.unit, found.source.up) == ("amc", "cm", "y")


def test_the_rate_is_told_or_usual(folder: Path) -> None:
    usual = read(folder, GOOD)
    assert usual.rate == 120
    assert usual.warnings == (
        "it does not tell its rate: 120 frames a second. If that is wrong, give --fps",
    )
    assert (read(folder, GOOD, rate=60).rate, read(folder, GOOD, rate=60).warnings) == (60, ())
    said = GOOD.replace(b":DEGREES", b":DEGREES\n:SAMPLES-PER-SECOND 59.94")
    assert read(folder, said).rate == Fraction(60000, 1001)
    assert read(folder, said).warnings == ()
    first = said.replace(b":FULLY-SPECIFIED\n:DEGREES\n", b"")  # no keyword but this
    assert read(folder, first).rate == Fraction(60000, 1001)
    for odd in (b"0", b"1.2.3", b"many", b"", b"."):
        assert read(folder, said.replace(b"59.94", odd)).rate == 120


@pytest.mark.parametrize(
    "written",
    [
        pytest.param(lambda data: data.replace(b"\n", b"\r\n"), id="CRLF"),
        pytest.param(lambda data: data.replace(b"\n2\n", b"\n# made\n\n2\n"), id="comment"),
        pytest.param(lambda data: data.replace(b"root ", b"  root\t "), id="blanks"),
        pytest.param(lambda data: data.replace(b"\n", b"  \n"), id="blanks behind"),
        pytest.param(lambda data: data.replace(b"\n3\n", b"\n 3\n"), id="indented"),
        pytest.param(lambda data: data.rstrip(), id="no last line end"),
        pytest.param(lambda data: b"\xef\xbb\xbf" + data, id="BOM"),
        pytest.param(lambda data: motion(numbers(4), tuple(WIDTHS)[::-1]), id="another order"),
        pytest.param(lambda data: motion(numbers(4), first=1000), id="from 1000"),
        pytest.param(lambda data: data.replace(b"\nhead", b"\nlclavicle\nhead"), id="stiff bone"),
        pytest.param(
            lambda data: data.replace(b"\n3\nroot", b"\n3\nhead 1 2 3\nroot").replace(
                b"\n4\n", b"\n5\n"
            ),
            id="one differs",
        ),
    ],
)
def test_however_it_is_written(folder: Path, written, monkeypatch: pytest.MonkeyPatch) -> None:
    data = written(GOOD)
    if data.count(b"head 1 2 3"):
        head = data.index(b"\nhead", data.index(b"head 1 2 3") + 1)
        data = data[:head] + data[data.index(b"\n", head + 1) :]
    plain = read(folder, data)
    if b"head 1 2 3" not in data:
        assert np.array_equal(plain.positions, read(folder, GOOD).positions)
    else:
        assert plain.warnings[0] == "frame 5 follows frame 3: taken for the next"
    monkeypatch.setattr(Numbers, "_read_alike", lambda *_: None)
    assert np.array_equal(plain.positions, read(folder, data).positions)


def test_radians(folder: Path) -> None:
    values = numbers(4)
    values[:, 3:] = np.radians(values[:, 3:])
    data = motion(values).replace(b":DEGREES", b":RADIANS")
    wanted = read(folder, GOOD).positions
    np.testing.assert_allclose(read(folder, data).positions, wanted, atol=1e-2)
    (folder / "ada.asf").write_bytes(asf(angle="rad"))
    data = data.replace(b":RADIANS\n", b"")  # as its skeleton says
    np.testing.assert_allclose(read(folder, data).positions, wanted, atol=1e-2)


def test_units(folder: Path) -> None:
    sizes = read(folder, GOOD).positions
    for length, unit in (("2.54", "cm"), ("3", "cm (detected)"), ("0", "cm (detected)")):
        (folder / "ada.asf").write_bytes(asf(length))
        assert read(folder, GOOD).source.unit == unit
        assert np.array_equal(read(folder, GOOD).positions, sizes)
    (folder / "ada.asf").write_bytes(asf("0.45"))
    assert any("inch/0.45, in which its leg" in it for it in read(folder, GOOD).warnings)


class TestSkeleton:
    """Where it is looked for."""

    @pytest.mark.parametrize(
        ("names", "wanted"),
        [
            (["ada.asf", "ada_1.asf"], "ada_1.asf"),
            (["ADA.asf", "ada.ASF"], "ada.ASF"),
            (["ada_1.asf", "eve.asf"], "ada_1.asf"),
            (["eve.Asf"], "eve.Asf"),
        ],
    )
    def test_beside(self, tmp_path: Path, names: list[str], wanted: str) -> None:
        for name in names:
            (tmp_path / name).write_text(name)
        found = amc.beside(File(str(tmp_path / "ada_1.amc"), b""))
        assert found == ((".asf", wanted.encode()),)

    def test_of_a_longer_name(self, folder: Path) -> None:
        (folder / "eve.asf").write_text("not this one")
        file = File(str(folder / "ada_walk_fast_001.amc"), GOOD)
        assert len(formats.read_file(file, Reading(), formats.Wanted())) == 4

    def test_the_only_one_is_doubtful(self, tmp_path: Path) -> None:
        (tmp_path / "eve.asf").write_bytes(asf())
        said = "its skeleton is taken to be eve.asf, the only one beside it"
        assert read(tmp_path, GOOD).warnings[0] == said

    def test_in_an_archive(self, tmp_path: Path) -> None:
        with ZipFile(tmp_path / "takes.zip", "w") as archive:
            for name, data in (("a/ada.ASF", asf()), ("a/ada_1.amc", GOOD), ("eve.asf", b"")):
                archive.writestr(name, data)
        assert len(formats.read(f"{tmp_path}/takes.zip!/a/ada_1.amc")) == 4
        with ZipFile(tmp_path / "takes.zip", "w") as archive:
            archive.writestr("ada_1.amc", GOOD)
        with pytest.raises(CaptureError, match="no skeleton beside it"):
            formats.read(f"{tmp_path}/takes.zip!/ada_1.amc")

    def test_a_folder_is_looked_through_once(
        self, folder: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        looked = []
        listed = os.listdir
        monkeypatch.setattr("os.listdir", lambda path: looked.append(path) or listed(path))
        for number in range(5):
            amc.beside(File(f"{folder}/ada_{number}.amc", GOOD))
        assert looked == [str(folder)]

    def test_told(self, tmp_path: Path) -> None:
        (tmp_path / "it").write_bytes(asf())
        told = Reading(skeleton=str(tmp_path / "it"))
        assert amc.beside(File("nowhere/ada_1.amc", GOOD), told) == ((".asf", asf()),)
        assert len(read(tmp_path, GOOD, skeleton=str(tmp_path / "it"))) == 4

    @pytest.mark.parametrize(
        ("names", "found"),
        [([], "no skeleton beside it"), (["eve.asf", "bob.asf"], "2 skeletons beside it")],
    )
    def test_none(self, tmp_path: Path, names: list[str], found: str) -> None:
        for name in names:
            (tmp_path / name).write_text("")
        with pytest.raises(CaptureError) as caught:
            read(tmp_path, GOOD)
        assert str(caught.value) == (
            f"{tmp_path}/ada_1.amc: {found}, wanted ada_1.asf or ada.asf, or a single .asf in "
            "its folder. Name it with --skeleton FILE."
        )


def damaged(number: int, line: bytes) -> bytes:
    """Return the good file with one line replaced, counted from 1."""
    return b"".join([*LINES[: number - 1], line, *LINES[number:]])


SECOND = 4 + FRAME  # the line of the second frame's number


@pytest.mark.parametrize(
    ("data", "line", "found", "wanted"),
    [
        (damaged(SECOND + 1, b""), SECOND, "the frame lacks root", "17 bones"),
        (damaged(SECOND + 2, b"lfemur 1 2\n"), SECOND + 2, "lfemur has 2 numbers", "3 as"),
        (damaged(SECOND + 2, b"lfemur 1 2 3 4\n"), SECOND + 2, "lfemur has 4 numbers", "3 as"),
        (damaged(SECOND + 2, b"lfemur 1 2 x\n"), SECOND + 2, "lfemur has 'x'", "numbers with"),
        (damaged(SECOND + 2, b"lfemur 1 2 1_0\n"), SECOND + 2, "lfemur has '1_0'", "numbers with"),
        (damaged(SECOND + 2, b"lfemur 1 2 nan\n"), SECOND + 2, "lfemur has 'nan'", "finite"),
        (damaged(SECOND + 2, b"lfemur 1 2 1e30\n"), SECOND + 2, "lfemur has '1e30'", "finite"),
        (damaged(SECOND + 2, b"tail 1 2 3\n"), SECOND + 2, "the bone 'tail'", "each bone"),
        (damaged(SECOND + 3, b"lfemur 1 2 3\n"), SECOND + 3, "a second lfemur", "once"),
        (damaged(SECOND, b"2 3\n"), SECOND, "'2 3'", "alone on its line"),
        (damaged(SECOND, b"9" * 20 + b"\n"), SECOND, "'99999999999999999999'", "alone"),
        (b"".join(LINES[:-1]), 4 + 3 * FRAME, "the frame lacks head", "17 bones"),
        (b"".join(LINES[:3]), None, "no frames", "a frame's number"),
    ],
)
def test_damage_is_named(
    folder: Path, data: bytes, line: int | None, found: str, wanted: str
) -> None:
    with pytest.raises(CaptureError) as caught:
        read(folder, data)
    error = caught.value
    assert found in error.found
    assert wanted in error.wanted
    assert error.place == str(folder / "ada_1.amc") + (f":{line}" if line else "")


def test_line_ends_that_are_not_known_are_named(folder: Path) -> None:
    with pytest.raises(CaptureError, match="in carriage returns alone: save it with line feeds"):
        read(folder, b"".join(LINES).replace(b"\r", b"").replace(b"\n", b"\r"))


@pytest.mark.parametrize(
    ("old", "new", "found", "wanted"),
    [
        (b"length 2.54", b"length x", "'length x'", "a number behind length"),
        (b"angle deg", b"angle grad", "'angle grad'", "deg or angle rad"),
        (b"axis XYZ", b"axis XXZ", "'axis XXZ'", "each of X Y Z once"),
        (b"axis XYZ", b"axis XY", "'axis XY'", "XYZ in some order"),
        (b"TX TY", b"TX TX", "'order TX TX TZ", "once at most"),
        (b"dof rx\n", b"dof rx l\n", "'dof rx l'", "each of RX RY RZ"),
        (b"name ltibia", b"name lfemur", "'name lfemur'", "a name of its own"),
        (b"name ltibia", b"name", "'name'", "one word behind name"),
        (b"  length", b"  lengthy", "'begin'", "a bone with its length"),
        (b"  direction", b"  direction 1 2 1_0", "'direction 1 2 1_0", "3 numbers behind"),
        (b"  direction", b"  direction inf 1 2", "'direction inf 1 2", "3 numbers behind"),
        (b"  lfemur ltibia", b"  lfemur tail", "'lfemur tail'", "'tail' is none"),
        (b"  lfemur ltibia", b"  lfemur rfemur", "'lfemur rfemur'", "rfemur below one other"),
        (b"  lfemur ltibia", b"  lfemur root", "'lfemur root'", "root below one other"),
        (b"  lfemur ltibia", b"", "'ltibia' hangs on nothing", "all bones below root"),
        (b"  lfemur ltibia", b"  lfoot ltibia", "'ltibia' hangs on nothing", "below root"),
        (b":hierarchy", b":other", "ends without :hierarchy", ":bonedata and"),
        (b":bonedata", b":other", "ends without :bonedata", ":bonedata and"),
        (b"# made\n:version", b"version", "'version 1.10'", "an ASF file"),
    ],
)
def test_damage_of_the_skeleton_is_named(
    folder: Path, old: bytes, new: bytes, found: str, wanted: str
) -> None:
    assert old in asf()
    (folder / "ada.asf").write_bytes(asf().replace(old, new, 1))
    with pytest.raises(CaptureError) as caught:
        read(folder, GOOD)
    assert found in caught.value.found
    assert wanted in caught.value.wanted
    assert caught.value.place.startswith(str(folder / "ada.asf"))


def test_a_skeleton_of_nonsense_is_no_work(folder: Path) -> None:
    bone = b" begin\n name b%d\n direction 0 1 0\n length 1\n end\n"
    many = b"".join(bone % number for number in range(2000))
    (folder / "ada.asf").write_bytes(asf().replace(b":hierarchy", many + b":hierarchy"))
    with pytest.raises(CaptureError, match="2018 bones, wanted at most 1000"):
        read(folder, GOOD)
    lines = [f" {up} {low}\n" for up, low in zip(["root", *range(899)], range(900), strict=True)]
    few = b"".join(bone.replace(b"b%d", b"%d") % number for number in range(900))
    few = asf().replace(b":hierarchy", few + b":hierarchy") + "".join(lines).encode()
    (folder / "ada.asf").write_bytes(few)
    with pytest.raises(CaptureError, match=r"\d+ joints in 2000 frames, of which few can move"):
        read(folder, motion(np.zeros((2000, sum(WIDTHS.values())))))
    (folder / "ada.asf").write_bytes(bytes(17 << 20))
    with pytest.raises(CaptureError, match="a skeleton of 17825792 bytes"):
        read(folder, GOOD)


def test_what_is_unusual_in_a_skeleton_is_said(folder: Path) -> None:
    (folder / "ada.asf").write_bytes(asf().replace(b"orientation 0 0 0", b"orientation 0 90 0"))
    assert read(folder, GOOD).warnings[0].startswith("the root of its skeleton is turned at rest")
    (folder / "ada.asf").write_bytes(asf().replace(b"rx ry rz", b"rx rz ry", 1))
    said = "lfemur turns in the order of its dof, not that of its axis"
    assert read(folder, GOOD).warnings[0] == said


def test_a_clip_is_its_lines_with_frames_from_1(folder: Path) -> None:
    data = motion(numbers(9), first=700).replace(b"\n704\n", b"\n# here\n 704\r\n")
    cut = formats.cutter(File("ada_1.amc", data))
    assert cut(Span(1, 3)) == motion(numbers(9)[1:3])
    whole, clip = read(folder, data), read(folder, cut(Span(2, 9)))
    assert b"# here" in cut(Span(2, 9))
    assert np.array_equal(clip.positions, whole.positions[2:])
    assert cut(Span(0, 9)) == motion(numbers(9)).replace(b"\n5\n", b"\n# here\n 5\r\n")


@pytest.mark.parametrize("piece", [1, 7, 64, 1000])
def test_frames_are_found_across_pieces(piece: int, monkeypatch: pytest.MonkeyPatch) -> None:
    data = GOOD.replace(b"\n3\n", b"\n  3\n")
    whole = amc.scan(data, "x")
    monkeypatch.setattr(amc, "PIECE", piece)
    found = amc.scan(data, "x")
    for name in ("stops", "ends", "numbers"):
        assert np.array_equal(getattr(found, name), getattr(whole, name))
    assert whole.numbers.tolist() == [1, 2, 3, 4]


def test_the_skeleton_counts_in_what_a_library_holds(folder: Path) -> None:
    (folder / "ada.amc").write_bytes(motion(numbers(40)))
    with open_library(folder / "l.db", create=True) as library:
        for length in ("2.54", "2.5"):
            (folder / "ada.asf").write_bytes(asf(length))
            for status in ("added", "unchanged"):
                (outcome,) = library.ingest(folder / "ada.amc")
                assert (outcome.status, outcome.beside) == (status, (str(folder / "ada.asf"),))
        assert len(library.captures()) == 1
