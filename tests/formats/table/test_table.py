"""Tables of points from several programs; their clips; motions written as tables."""

import numpy as np
import pytest
from made_points import NAMES, person
from mutations import fuzzed

from lanindex import formats
from lanindex.errors import BodyError, CaptureError, UsageError
from lanindex.formats import point_tables, sniff
from lanindex.formats.point_tables import KINECT
from lanindex.formats.text_rows import triples
from lanindex.model import Motion, Reading, Span


def read(data: bytes | str, name: str = "walk.csv", **told) -> Motion:
    return formats.read(name, data=data.encode() if isinstance(data, str) else data, **told)


def at(motion: Motion, names=NAMES) -> np.ndarray:
    return motion.positions[:, [motion.skeleton.names.index(name) for name in names]]


def text(value: float, comma: bool = False) -> str:
    return f"{value:.3f}".replace(".", ",") if comma else f"{value:.3f}"


def named(
    separator=",", comma=False, end="\n", before="", time="time", tick=1.0, axes="_{}", scale=1.0,
    shuffle=False, quote="", frames=20, rate=30.0,
) -> bytes:  # fmt: skip
    """Return a table whose header names its columns."""
    places = person(frames) * scale
    columns = [("frame", [str(k) for k in range(frames)])]
    if time:
        columns.append((time, [text(k / rate / tick, comma) for k in range(frames)]))
    for number, name in enumerate(NAMES):
        for axis in range(3):
            values = [text(value, comma) for value in places[:, number, axis].tolist()]
            columns.append((name + axes.format("xyz"[axis], "XYZ"[axis]), values))
    if shuffle:
        order = np.random.default_rng(2).permutation(len(columns))
        columns = [columns[k] for k in order.tolist()]
    header = separator.join(f"{quote}{name}{quote}" for name, _ in columns)
    rows = zip(*(values for _, values in columns), strict=True)
    return (before + end.join([header, *map(separator.join, rows)]) + end).encode()


KINDS = {
    "commas": {},
    "tabs": {"separator": "\t"},
    "semicolons": {"separator": ";"},
    "a comma for the point": {"separator": ";", "comma": True},
    "tabs and commas": {"separator": "\t", "comma": True},
    "CRLF": {"end": "\r\n"},
    "CR": {"end": "\r"},
    "any order": {"shuffle": True},
    "quoted": {"quote": '"'},
    "a mark before it": {"before": "\ufeff"},
    "comments before it": {"before": "# made by hand, in mm\n\n"},
    "points": {"axes": ".{1}"},
    "words": {"axes": " position {}"},
    "a unit": {"axes": "_{} [mm]"},
    "capitals": {"axes": "{1}"},
    "milliseconds": {"time": "timestamp_ms", "tick": 1e-3},
    "t": {"time": "t"},
}


@pytest.mark.parametrize("kind", KINDS)
def test_tables_that_name_their_columns(kind):
    motion = read(named(**KINDS[kind]))
    np.testing.assert_allclose(at(motion), person(), atol=1e-3)
    assert motion.rate == 30
    assert (motion.source.format, motion.warnings) == ("csv", ())


def test_times_in_what_is_usual():
    for tick, name in ((1e-3, "milliseconds"), (1e-7, "units of 100 ns"), (1e-9, "nanoseconds")):
        motion = read(named(time="timestamp", tick=tick))
        assert motion.rate == 30
        assert motion.warnings == (f"its times are taken for {name}",)


def test_no_time_needs_a_rate():
    with pytest.raises(CaptureError, match=r"nothing tells its rate.*Give the rate with --fps"):
        read(named(time=""))
    assert read(named(time=""), rate=25).rate == 25


def test_what_is_blank_is_unknown():
    lines = named().split(b"\n")
    cells = lines[4].split(b",")
    cells[2:5] = b"", b"NaN", b" "
    lines[4] = b",".join(cells)
    assert np.argwhere(np.isnan(at(read(b"\n".join(lines)))[..., 0])).tolist() == [[3, 0]]


def test_turns_are_no_places():
    cells = ["hip_x", "hip_y", "hip_z", "hip_rotation_x", "hip_rotation_y", "hip_rotation_z"]
    assert triples(cells) == ({"hip": (0, 1, 2)}, None)
    assert triples(["x", "y", "z", "a_x", "a_y"]) == ({}, None)


def kinect(frames: int = 20, start: int = 89810293609, step: int = 333333) -> bytes:
    """Return a table of LabanotationSuite: the person faces the camera."""
    where = dict(zip(NAMES, person(frames).swapaxes(0, 1) / 1000, strict=True))
    rows = []
    for frame in range(frames):
        cells = [str(start + frame * step)]
        for name in KINECT:
            side = next((side for side in ("Left", "Right") if name.endswith(side)), "")
            key = f"{side}_{name.removesuffix(side)}".strip("_").lower()
            x, y, z = where.get(key, where["pelvis"])[frame]
            cells += [f"{-x:.6f}", f"{y:.6f}", f"{2.5 - z:.6f}", "0" if key == "head" else "2"]
        rows.append(",".join(cells) + ",\n")
    return "".join(rows).encode()


def test_kinect():
    motion = read(kinect())
    assert (motion.rate, motion.source.unit, motion.source.up) == (30, "m", "y")
    assert motion.warnings == ()
    left, right = at(motion, ("WristLeft", "WristRight"))[0]
    assert left[0] == pytest.approx(-250)
    assert right[0] == pytest.approx(250)
    assert np.isnan(at(motion, ("Head",))).all()


@pytest.mark.parametrize("separator", [b";", b"\t"])
def test_kinect_with_decimal_commas_is_known_and_read_alike(separator):
    commas = kinect().replace(b",", separator).replace(b".", b",")
    assert sniff.table(commas[:4096])
    np.testing.assert_array_equal(read(commas).positions, read(kinect()).positions)


def test_kinect_says_that_frames_are_missing():
    lines = kinect().splitlines(keepends=True)
    motion = read(b"".join(lines[:8] + lines[10:]))
    assert motion.rate == 30
    assert motion.warnings == (
        "1 of 17 steps in time differ from the usual 0.03333 s: frames may be missing",
    )


MARKERS = ("LSHO", "RSHO", "LELB", "RELB", "LWRA", "RWRA", "LASI", "RASI", "LPSI", "RPSI",
           "LKNE", "RKNE", "LANK", "RANK", "C7")  # fmt: skip
AS_MARKERS = ("left_shoulder", "right_shoulder", "left_elbow", "right_elbow", "left_wrist",
              "right_wrist", "left_hip", "right_hip", "left_hip", "right_hip", "left_knee",
              "right_knee", "left_ankle", "right_ankle", "neck")  # fmt: skip


def marked(frames: int = 12) -> np.ndarray:
    places = person(frames)[:, [NAMES.index(name) for name in AS_MARKERS]]
    places[:, 6:8] += [0, 60, 90]
    places[:, 8:10] += [0, 60, -90]
    return places


def nexus(subjects=("Bob",), before: str = "", after: str = "", end: str = "\r\n") -> bytes:
    """Return an export of Vicon Nexus, z up."""
    places = marked()[..., [0, 2, 1]] * [1, -1, 1]
    names = [f"{subject}:{name}" for subject in subjects for name in MARKERS]
    many = len(names)
    lines = ["Trajectories", "100", ",," + ",".join(f"{name},," for name in names)]
    lines += ["Frame,Sub Frame," + ",".join(["X,Y,Z"] * many), ",," + ",".join(["mm"] * 3 * many)]
    for frame, row in enumerate(places):
        cells = ",".join(f"{value:.4f}" for value in row.ravel())
        lines.append(f"{695 + frame},0," + ",".join([cells] * len(subjects)))
    return (before + end.join(lines) + end + after).encode()


DEVICES = (
    "Devices\r\n1000\r\n,,Plate\r\nFrame,Sub Frame,Fx\r\n,,N\r\n695,0,1.5\r\n695,1,1.5\r\n\r\n"
)
OUTPUTS = "\r\nModel Outputs\r\n100\r\n,,Bob:LKnee\r\nFrame,Sub Frame,X\r\n,,deg\r\n695,0,1\r\n"


UNTITLED = "Title\r\nDate:\r\n\r\n"
TITLED = "Title,,,A walk\r\nDate:,2020-02-03\r\nComment:,Trajectories of a walk\r\n"


@pytest.mark.parametrize(
    "around",
    [
        *(("", ""), (DEVICES, ""), ("", OUTPUTS), (DEVICES, OUTPUTS)),
        *((UNTITLED, ""), (TITLED, OUTPUTS), (UNTITLED + DEVICES, OUTPUTS)),
    ],
)
def test_nexus(around):
    source = nexus(before=around[0], after=around[1])
    motion = read(source)
    assert (len(motion), motion.rate) == (12, 100)
    assert (motion.source.unit, motion.source.up, motion.warnings) == ("mm", "z", ())
    np.testing.assert_allclose(motion.markers.positions, marked(), atol=1e-3)
    clip = formats.cutter(formats.File("walk.csv", source))(Span(3, 7))
    again = read(clip)
    np.testing.assert_array_equal(again.markers.positions, motion.markers.positions[3:7])


def test_nexus_with_commas_in_its_numbers():
    data = nexus().replace(b",", b"\t").replace(b".", b",")
    np.testing.assert_array_equal(read(data).markers.positions, read(nexus()).markers.positions)


def test_two_of_one_name_are_told():
    named_twice = named().replace(b"left_elbow_", b"right_elbow_", 3)
    told = "several columns are called 'right_elbow_x', 'right_elbow_y', 'right_elbow_z': the first"
    assert read(named_twice).warnings[0] == f"{told} is read"
    marker = qualisys().replace(b"LELB", b"RELB")
    assert "several points are called 'RELB': the first is read" in read(marker).warnings


def test_nexus_of_two_people(tmp_path):
    path = tmp_path / "duet.csv"
    path.write_bytes(nexus(("Ada", "Bob")))
    motion = formats.read(path)
    assert motion.warnings == ("Ada is read; it holds also Bob",)
    bob = formats.read(f"{path}#Bob")
    assert {name.partition(":")[0] for name in bob.markers.names} == {"Bob"}
    assert bob.warnings == ()
    assert point_tables.subjects(formats.opened(path)) == ("Ada", "Bob")
    with pytest.raises(CaptureError, match="has no subject 'Cy' that makes a body, wanted Ada or"):
        formats.read(f"{path}#Cy")


def test_outputs_of_a_model_are_no_places():
    for data in (OUTPUTS.lstrip().encode(), DEVICES.encode()):
        with pytest.raises(CaptureError, match="without markers or segments"):
            read(data)


def test_segments_of_a_model_give_its_joints(captures):
    """The model's knees lie within, the markers outside; half the knee and the marker between."""
    found = formats.read(captures / "csv" / "vicon_nexus_Movement_trial.csv")
    marked = formats.read(captures / "c3d" / "vicon_pig_Movement_trial.c3d")
    assert (len(found), found.rate, found.warnings) == (323, 120, ())
    places = [
        {name: motion.positions[:, motion.skeleton.names.index(plays)]
         for name, plays in motion.skeleton.played().items()}
        for motion in (found, marked)
    ]  # fmt: skip
    assert len(places[0]) >= 19
    away = {
        name: np.median(np.linalg.norm(where - places[1][name], axis=1))
        for name, where in places[0].items()
    }
    assert max(away[side + "Hip"] for side in "RL") < 25
    assert max(away[side + "Shoulder"] for side in "RL") < 15
    assert max(away.values()) < 100
    lengths = np.linalg.norm(places[0]["RHip"] - places[0]["RKnee"], axis=1)
    assert lengths[0] == pytest.approx(414.159, abs=0.01)  # as the file says


BONES = ("Bob", "Ab", "Chest", "Neck", "Head", "LShoulder", "LUArm", "LFArm", "LHand", "RShoulder",
         "RUArm", "RFArm", "RHand", "LThigh", "LShin", "LFoot", "RThigh", "RShin",
         "RFoot")  # fmt: skip
AS_BONES = ("pelvis", "pelvis", "neck", "neck", "head", "neck", "left_shoulder", "left_elbow",
            "left_wrist", "neck", "right_shoulder", "right_elbow", "right_wrist", "left_hip",
            "left_knee", "left_ankle", "right_hip", "right_knee", "right_ankle")  # fmt: skip


def motive(declared: int = 12, bones: bool = True) -> bytes:
    """Return an export of Motive, with turns of bones and one marker besides."""
    places = person(12)[:, [NAMES.index(name) for name in AS_BONES]] / 1000
    names = [f"Bob:{name}" for name in BONES] if bones else [f"Bob:M{k}" for k in range(19)]
    kind = "Bone" if bones else "Marker"
    head = ["Format Version", "1.25", "Take Name", "walk", "Capture Frame Rate", "240.000000"]
    head += ["Export Frame Rate", "120.000000", "Total Exported Frames", declared]
    head += ["Rotation Type", "Quaternion", "Length Units", "Meters", "Coordinate Space", "Global"]
    types, called, moves, axes = (["", label] for label in ("Type", "Name", "", ""))
    for name in names:
        types += [kind] * 7
        called += [name] * 7
        moves += ["Rotation"] * 4 + ["Position"] * 3
        axes += ["X", "Y", "Z", "W", "X", "Y", "Z"]
    types += ["Marker"] * 3
    called += ["Unlabeled 1"] * 3
    moves += ["Position"] * 3
    axes += ["X", "Y", "Z"]
    axes[:2] = ["Frame", "Time (Seconds)"]
    rows = [head, [], types, called, ["", "ID"] + ["7"] * (len(called) - 2), moves, axes]
    for frame, points in enumerate(places):
        cells = [
            cell for point in points for cell in ("0", "0", "0", "1", *map("{:.6f}".format, point))
        ]
        rows.append([frame, f"{frame / 120:.6f}", *cells, "", "", ""])
    return ("\ufeff" + "\r\n".join(",".join(map(str, row)) for row in rows) + "\r\n").encode()


def test_motive():
    motion = read(motive())
    assert (motion.rate, motion.source.unit, motion.source.up, motion.warnings) == (
        120,
        "m",
        "y",
        (),
    )
    assert motion.skeleton.played()["LShoulder"] == "Bob:LUArm"
    assert motion.skeleton.played()["Pelvis"] == "Bob:Hip"
    wrist = at(motion, ("Bob:RHand",))[:, 0]
    np.testing.assert_allclose(wrist, person(12)[:, NAMES.index("right_wrist")], atol=1e-3)


def test_a_copy_of_motive_that_is_cut_short_is_told():
    assert read(motive(17263)).warnings == ("its header says '17263' frames, the file has 12",)
    with pytest.raises(BodyError):
        read(motive(bones=False))
    with pytest.raises(CaptureError, match="the header of Motive cut short"):
        read(motive()[:300])


def test_motive_of_before_names_its_rows_by_their_order():
    old = motive()
    for word in (b"Type", b"Name", b"ID"):
        old = old.replace(b"," + word + b",", b",,", 1)
    np.testing.assert_array_equal(at(read(old), ("Bob:RHand",)), at(read(motive()), ("Bob:RHand",)))


def test_places_in_the_axes_of_bones_are_refused():
    local = motive().replace(b"Coordinate Space,Global", b"Coordinate Space,Local")
    with pytest.raises(CaptureError, match=r"Space 'Local'\), wanted Global\. Export it with"):
        read(local)


def qualisys(header: bool = True, columns: bool = True, declared: int = 12) -> bytes:
    keys = {"NO_OF_FRAMES": declared, "NO_OF_CAMERAS": 9, "NO_OF_MARKERS": 15, "FREQUENCY": 100,
            "NO_OF_ANALOG": 0, "ANALOG_FREQUENCY": 0, "DESCRIPTION": "--",
            "TIME_STAMP": "2020-01-01, 10:00:00", "DATA_INCLUDED": "3D"}  # fmt: skip
    lines = [f"{key}\t{value}" for key, value in keys.items()]
    lines.append("\t".join(("MARKER_NAMES", *MARKERS)))
    lines.append("\t".join(("TRAJECTORY_TYPES", *["Measured"] * 15)))
    if header:
        axes = [f"{name} {axis}" for name in MARKERS for axis in "XYZ"]
        lines.append("\t".join((*(["Frame", "Time"] if columns else []), *axes)))
    for frame, row in enumerate(marked()[..., [0, 2, 1]] * [1, -1, 1]):
        first = [str(frame + 1), f"{frame / 100:.5f}"] if columns else []
        lines.append("\t".join((*first, *(f"{value:.3f}" for value in row.ravel()))) + "\t")
    return ("\r\n".join(lines) + "\r\n").encode()


@pytest.mark.parametrize(
    ("header", "columns"), [(True, True), (True, False), (False, True), (False, False)]
)
def test_qualisys(header, columns):
    motion = read(qualisys(header, columns), "walk.tsv")
    assert (motion.rate, motion.source.unit, motion.source.up) == (100, "mm", "z")
    assert motion.warnings == ()
    np.testing.assert_allclose(motion.markers.positions, marked(), atol=1e-3)
    told = "its header says '500' frames, the file has 12"
    assert read(qualisys(header, columns, 500)).warnings == (told,)


def test_qualisys_in_other_words():
    plain = read(qualisys(), "walk.tsv").markers.positions
    newer = b"FILE_VERSION\t2.0.0\r\n" + qualisys(header=False, columns=False)
    commas = qualisys().replace(b".", b",")
    for data in (newer, commas):
        assert sniff.table(data[:4096])
        np.testing.assert_array_equal(read(data, "walk.tsv").markers.positions, plain)


def test_qualisys_of_bodies_is_refused():
    with pytest.raises(CaptureError, match="data of the kind '6D', wanted 3D"):
        read(qualisys().replace(b"DATA_INCLUDED\t3D", b"DATA_INCLUDED\t6D"))


COLUMNS = """
separator = "space"
skip = 2
time = "t"
tick = 0.001
unit = "mm"
up = "y"

[joints]
"""


def columns(tmp_path, said: str):
    path = tmp_path / "columns.toml"
    path.write_text(said)
    return str(path)


def test_any_other_table(tmp_path):
    joints = {name: [f"{name[:9]}{name[-4:]}{axis}" for axis in "uvw"] for name in NAMES}
    lines = ["by hand", "t " + " ".join(cell for axes in joints.values() for cell in axes)]
    for frame, row in enumerate(person()):
        lines.append(f"  {frame * 40} " + "  ".join(f"{value:.3f}" for value in row.ravel()))
    said = COLUMNS + "".join(f"{name} = {axes}\n" for name, axes in joints.items())
    told = Reading(columns=columns(tmp_path, said))
    file = formats.File("odd.txt", "\n".join(lines).encode())
    motion = point_tables.read(file, told, formats.Wanted())
    assert (motion.rate, motion.source.unit, motion.source.up) == (25, "mm", "y")
    np.testing.assert_allclose(at(motion), person(), atol=1e-3)
    clip = formats.cutter(file, told)(Span(3, 9))
    cut = point_tables.read(formats.File("odd.txt", clip), told, formats.Wanted())
    np.testing.assert_array_equal(cut.positions, motion.positions[3:9])
    numbers = said
    for number, name in enumerate(NAMES):
        first = 2 + 3 * number
        numbers = numbers.replace(f"{joints[name]}", str([first, first + 1, first + 2]))
    told = Reading(columns=columns(tmp_path, numbers.replace('time = "t"', "time = 1")))
    again = point_tables.read(file, told, formats.Wanted())
    np.testing.assert_array_equal(again.positions, motion.positions)


WRONG = {
    "nothing": ("", "no .joints."),
    "no TOML": ("joints = ", "Invalid"),
    "another key": ("colour = 1", "colour = 1"),
    "a text for a number": ("tick = 'ms'", "tick = 'ms'"),
    "two axes": ("[joints]\nhead = [1, 2]", "of each joint its three columns"),
    "no such column": ("[joints]\nhead = ['u', 2, 3]", "column 'u'"),
    "a column of 0": ("[joints]\nhead = [0, 2, 3]", "column 0"),
    "twice": ("[joints]\nhead = [1, 2, 2]", "a column that is used twice"),
    "a long separator": ("separator = '::'\n[joints]\nhead = [1, 2, 3]", "separator"),
}


@pytest.mark.parametrize("kind", WRONG)
def test_what_is_said_of_columns_wrongly(kind, tmp_path):
    said, found = WRONG[kind]
    told = Reading(columns=columns(tmp_path, said))
    with pytest.raises(UsageError, match=found):
        point_tables.read(formats.File("odd.txt", b"a,b,c\n1,2,3\n"), told, formats.Wanted())
    with pytest.raises(UsageError, match=r"none\.toml"):
        point_tables.read(
            formats.File("odd.txt", b""), Reading(columns="none.toml"), formats.Wanted()
        )


def test_a_table_is_known_by_its_beginning():
    sources = (
        named(),
        named(separator=";", before="# x\n"),
        kinect(),
        nexus(),
        motive(),
        qualisys(),
        ",".join(f"p{k}_{a}" for k in range(34) for a in "xyz")[:-6].encode(),  # as Kinect's: 101
    )
    assert all(sniff.table(data[:4096]) for data in sources)
    for other in (
        b"",
        b"a,b,c\n1,2,3\n",
        b"1,2,3\n" * 99,
        b"x,y,z\n1,2,3\n",
        b"\0" * 99,
        b"#\n" * 99,
    ):
        assert not sniff.table(other)


def test_clips_are_rows_of_the_source():
    for source in (named(), named(separator=";", comma=True, end="\r\n"), kinect(), motive()):
        clip = formats.cutter(formats.File("walk.csv", source))(Span(4, 9))
        rows = len(read(source))
        lines = source.splitlines(keepends=True)
        head = len(lines) - rows
        assert clip == b"".join(lines[:head] + lines[head + 4 : head + 9])


def test_real_clips_read_back(captures):
    for path in sorted((captures / "csv").rglob("*.csv")):
        whole = formats.read(path)
        again = formats.read(path, data=formats.cutter(formats.opened(path))(Span(10, 70)))
        assert again.rate == whole.rate
        for one, other in ((again, whole), (again.markers, whole.markers)):
            if other is not None and (one is not again or whole.markers is None):
                np.testing.assert_array_equal(one.positions, other.positions[10:70])


def test_motions_write_back(captures):
    paths = ["corpus/compass.bvh", *sorted((captures / "csv").rglob("*.csv"))]
    for path in paths:
        whole = formats.read(path)
        again = read(point_tables.write(whole))
        assert (again.rate, again.source.up) == (whole.rate, "y")
        one, other = again.markers or again, whole.markers or whole
        names = one.names if again.markers else again.skeleton.names
        there = other.names if whole.markers else whole.skeleton.names
        order = [names.index(name) for name in there]
        np.testing.assert_allclose(one.positions[:, order], other.positions, atol=1e-3)


def test_the_same_markers_by_two_programs(captures):
    table_, c3d = (
        formats.read(captures / name).markers
        for name in ("csv/pyomeca_markers.csv", "c3d/vicon_upperbody_ezc3d.c3d")
    )
    bare = [name.rpartition(":")[2] for name in c3d.names]
    order = [bare.index(name.rpartition(":")[2]) for name in table_.names]
    np.testing.assert_allclose(table_.positions, c3d.positions[:, order], atol=0.01)


SOURCES = [named(frames=4), named(";", True, frames=4), kinect(3), nexus(), nexus(before=DEVICES),
           motive(), qualisys(), qualisys(False)]  # fmt: skip


def test_fuzzing():
    seen = fuzzed("walk.csv", SOURCES, 500, 1)
    assert min(seen.values()) > 50, seen


@pytest.mark.slow
@pytest.mark.timeout(3600)
def test_long_fuzzing(captures):
    real = [
        b"\n".join(path.read_bytes().split(b"\n")[:12]) + b"\n"
        for path in sorted((captures / "csv").rglob("*.csv"))
    ]
    seen = fuzzed("walk.csv", [*SOURCES, *real], 5_000, 2)
    assert min(seen.values()) > 200, seen
