"""C3D files of all processors, integers and floats; unknown points; trusted parameters."""

from fractions import Fraction

import numpy as np
import pytest
from made_c3d import STANDING, c3d, standing, vax

from lanindex import formats
from lanindex.errors import BodyError, CaptureError
from lanindex.formats import c3d as c3d_format
from lanindex.formats.c3d import (
    PROCESSORS,
    Parameters,
    from_dec,
    names_of,
    places,
    scan,
    subjects,
    to_dec,
)
from lanindex.model import Reading, Span

NAMES = list(STANDING)


def there(data: bytes) -> np.ndarray:
    """Return the places in a file, in its units."""
    return places(data, scan(formats.File("x.c3d", data)))


def stated(data: bytes):
    return scan(formats.File("x.c3d", data))


@pytest.mark.parametrize("processor", [84, 85, 86])
@pytest.mark.parametrize("scale", [-1.0, -0.05, 0.5, 0.1])
def test_numbers_of_all_processors(processor, scale):
    points = standing(7)
    steps = points.copy()
    if scale > 0:
        steps = np.round(points / scale)
        points = np.float32(steps) * np.float32(scale)
    data = c3d(steps, processor=processor, scale=scale, analog=np.ones((7, 3)))
    assert np.array_equal(there(data), np.float32(points[..., :3]))
    motion = formats.read("x.c3d", data=data)
    assert (motion.rate, motion.source.unit, motion.source.up) == (100, "mm", "z")
    assert motion.warnings == ()
    assert len(motion) == 7


def test_dec_floats():
    values = np.array([0, 1, -1, 50, 0.1, -1e-30, 1e30, 123456.789], np.float32)
    words = np.frombuffer(b"".join(vax(float(it)) for it in values), "<u4")
    assert np.array_equal(from_dec(words), values)
    assert np.array_equal(to_dec(values), words)


def test_rows_that_are_chosen_are_those_of_all():
    data = c3d(standing(9), analog=np.ones((9, 5)))
    chosen = np.array([3, 7, 20])
    some = places(data, stated(data), chosen)
    assert np.array_equal(some, there(data)[:, chosen])


@pytest.mark.parametrize("piece", [1, 1000, 1 << 20])
def test_places_are_read_a_piece_at_a_time(monkeypatch, piece):
    data = c3d(standing(9))
    whole = there(data)
    monkeypatch.setattr(c3d_format, "PIECE", piece)
    assert np.array_equal(there(data), whole)


@pytest.mark.parametrize("scale", [-1.0, 1.0])
def test_what_is_unknown(scale):
    points = standing(6)
    points[1, 3, 3] = -1  # a place that is not to be believed
    points[2, 4] = 0, 0, 0, -1
    points[3, 5] = 0, 0, 0, 0  # as some programs write a gap
    points[4, 6] = 0, 0, 0, 5  # a marker at the origin, seen by a camera
    if scale < 0:
        points[5, 7, 1] = np.nan
        points[5, 8, 1] = 1e20
    found = there(c3d(points, scale=scale))
    unknown = np.isnan(found)
    assert np.array_equal(unknown.all(axis=2), unknown.any(axis=2))
    wanted = {(1, 3), (2, 4), (3, 5)} | ({(5, 7), (5, 8)} if scale < 0 else set())
    assert set(zip(*map(np.ndarray.tolist, np.nonzero(unknown[..., 0])), strict=True)) == wanted
    assert found[4, 6].tolist() == [0, 0, 0]


def test_gaps_stay_gaps():
    points = standing(50)
    points[10:30, NAMES.index("RKNE"), 3] = -1
    motion = formats.read("x.c3d", data=c3d(points))
    knee = motion.positions[:, motion.skeleton.names.index("RKnee")]
    assert np.isnan(knee[10:30]).all()
    assert np.isfinite(knee[:10]).all()
    assert np.isfinite(knee[30:]).all()


def test_many_frames():
    points = np.zeros((70_000, 3, 4))
    points[..., 0] = np.arange(70_000)[:, None] + 1
    trial = {"TRIAL:ACTUAL_START_FIELD": [1, 0], "TRIAL:ACTUAL_END_FIELD": [70_000 - 65536, 1]}
    for more in ({"POINT:LONG_FRAMES": 70_000.0}, {"POINT:FRAMES": 70_000.0}, trial, {}):
        data = c3d(points, ["a", "b", "c"], more=more)
        layout = stated(data)
        assert layout.doubts == [], more
        assert np.array_equal(there(data)[:70_000, 0, 0], points[:, 0, 0]), more
        assert layout.frames == (70_000 if more else 70_005), more  # till the file ends


def test_a_single_integer_may_mean_a_number_above_32767():
    data = c3d(np.ones((40_000, 1, 4)), ["a"])
    assert (stated(data).frames, stated(data).doubts) == (40_000, [])


DOUBTS = {
    "POINT:FRAMES": (dict(more={"POINT:FRAMES": 4}), "POINT:FRAMES: 4, header: 8): 8 believed"),
    "the header": (dict(words={5: 4}), "POINT:FRAMES: 8, header: 4): 8 believed"),
    "both": (dict(words={5: 900}, more={"POINT:FRAMES": 900}), "header: 900): 8 believed"),
    "TRIAL": (
        dict(more={"TRIAL:ACTUAL_START_FIELD": [1, 0], "TRIAL:ACTUAL_END_FIELD": [1, 1]}),
        "TRIAL: 65537, POINT:FRAMES: 8, header: 8): 8 believed",
    ),
    "too few": (dict(behind=bytes(4096)), "bytes behind its last frame are not read"),
    "points": (dict(words={2: 27}), "says points in a frame 27 or 28: 28 believed"),
    "other points": (dict(more={"POINT:USED": 30}), "points in a frame 28 or 30: 28 believed"),
    "data start": (dict(words={9: 5}), "that its data begin at byte"),
    "analog numbers": (dict(words={3: 7}), "analog numbers in a frame 7 or 0: 0 believed"),
    "rate": (dict(more={"POINT:RATE": 50.0}), "POINT:RATE says 50 frames a second, the header 100"),
    "up": (dict(more={"POINT:Y_SCREEN": ["+Y"]}), "says that y is up, but the body stands along z"),
    "unit": (dict(more={"POINT:UNITS": ["m"]}), "says m, in which its leg is"),
}


@pytest.mark.parametrize("case", DOUBTS)
def test_contradictions_are_told_and_what_fills_the_file_is_believed(case):
    lies, doubt = DOUBTS[case]
    points = standing(8, 40.0)
    data = c3d(points, **lies)
    motion = formats.read("x.c3d", data=data)
    assert len(motion) == 8
    assert np.array_equal(there(data), np.float32(points[..., :3]))
    assert any(doubt in warning for warning in motion.warnings), motion.warnings


def test_a_pointer_to_the_parameters_may_lie():
    data = bytearray(c3d(standing(4)))
    data[0] = 77
    assert len(formats.read("x.c3d", data=bytes(data))) == 4


def test_damaged_parameters():
    data = bytearray(c3d(standing(4)))
    at = data.index(b"LABELS") + 10
    data[at : at + 2] = 255, 255
    layout = stated(bytes(data))
    assert list(names_of(layout).values())[:2] == ["*1", "*2"]
    assert layout.parameters.doubts == ["its parameter POINT:LABELS is damaged"]
    with pytest.raises(BodyError):
        formats.read("x.c3d", data=bytes(data))


def test_parameters_that_break_off():
    data = c3d(standing(4))
    section = data[512 : data.index(b"UNITS") + 3]
    told = Parameters(section, PROCESSORS[84])
    assert told.doubts == ["its parameters break off at 'UNI'"]
    assert told.find("POINT:UNITS") is None
    assert told.find("POINT:USED") is None  # the name of its group comes later


def test_names_in_several_lists_and_beyond_the_points():
    points = np.ones((2, 300, 4))
    labels = [f"M{it}" for it in range(400)]
    data = c3d(points, labels[:255], more={"POINT:LABELS2": labels[255:]})
    assert list(names_of(stated(data)).values()) == labels[:300]


def test_points_without_names():
    data = c3d(np.ones((2, 4, 4)), ["a", "", "b"])
    assert list(names_of(stated(data)).values()) == ["a", "*2", "b", "*4"]


def test_of_two_points_of_one_name_the_first_is_taken():
    points = np.concatenate([standing(3), standing(3)[:, :1] + 500], axis=1)
    motion = formats.read("x.c3d", data=c3d(points, [*NAMES, "LFHD"]))
    plain = formats.read("x.c3d", data=c3d(standing(3)))
    assert np.array_equal(motion.positions, plain.positions)
    assert len(motion.markers.names) == 29


def test_what_a_model_tells_is_no_place():
    points = np.concatenate([standing(3), np.full((3, 3, 4), 1e6)], axis=1)
    more = {
        "POINT:ANGLES": ["LKneeAngles"],
        "POINT:STRANGE": ["LOther"],
        "POINT:MODELED_MARKERS": ["CentreOfMass"],
        "POINT:TYPE_GROUPS": ["STRANGE", "OTHER", "MODELED_MARKERS", "MODELED_MARKER"],
    }
    data = c3d(points, [*NAMES, "LKneeAngles", "LOther", "CentreOfMass"], more=more)
    motion = formats.read("x.c3d", data=data)
    assert motion.markers.names == (*NAMES, "CentreOfMass")
    assert motion.source.joints == motion.markers.names


def test_the_body_alone_is_the_same_body():
    data = c3d(standing(30))
    whole, body = formats.read("x.c3d", data=data), formats.read("x.c3d", data=data, body_only=True)
    assert body.markers is None
    assert body.source.joints == whole.source.joints
    assert body.source.made == whole.source.made
    for name in body.skeleton.names:
        one, other = (it.positions[:, it.skeleton.names.index(name)] for it in (whole, body))
        assert np.array_equal(one, other)


def test_what_the_user_says_is_taken():
    data = c3d(standing(30), rate=0.0)
    assert formats.read("x.c3d", data=data, rate=60).rate == 60
    data = c3d(standing(30), rate=29.97)
    assert formats.read("x.c3d", data=data).rate == Fraction(30000, 1001)


def prefixed(*subjects: str) -> tuple[np.ndarray, list[str]]:
    points = [standing(5) + np.array([0, 800 * number, 0, 0]) for number in range(len(subjects))]
    return np.concatenate(points, axis=1), [f"{it}:{name}" for it in subjects for name in NAMES]


def test_two_people():
    points, labels = prefixed("Anna", "Bob")
    data = c3d(points, labels)
    assert subjects(formats.File("x.c3d", data)) == ("Anna", "Bob")
    motion = formats.read("x.c3d", data=data)
    assert "Anna is read; it holds also Bob" in motion.warnings
    assert motion.markers.names == tuple(labels[:28])
    assert motion.source.made["RElbow"] == "Anna:RELB"


def test_a_subject_that_is_named():

    points, labels = prefixed("Anna", "Bob")
    file = formats.File("x.c3d#Bob", c3d(points, labels), "Bob")
    motion = formats.read_file(file, Reading(), formats.Wanted())
    assert motion.warnings == ()
    assert motion.markers.names == tuple(labels[28:])
    file = formats.File("x.c3d#Bob", c3d(points[:, :28], labels[:28]), "Bob")
    with pytest.raises(CaptureError, match=r"no subject 'Bob'.*Anna"):
        formats.read_file(file, Reading(), formats.Wanted())


def test_subjects_by_parameters():
    points, labels = prefixed("A_", "B_")
    labels = [label.replace("_:", "_") for label in labels]
    more = {"SUBJECTS:NAMES": ["Anna", "Bob"], "SUBJECTS:LABEL_PREFIXES": ["A_", "B_"]}
    file = formats.File("x.c3d", c3d(points, labels, more=more))
    assert subjects(file) == ("Anna", "Bob")
    one = formats.File("x.c3d", c3d(standing(3), more={"SUBJECTS:NAMES": ["Jong"]}))
    assert subjects(one) == ("Jong",)
    assert subjects(formats.File("x.c3d", c3d(standing(3)))) == ()


def test_a_thing_beside_a_person_is_left_out():
    points, labels = prefixed("Anna")
    points = np.concatenate([np.full((5, 2, 4), 9.0), points], axis=1)
    data = c3d(points, ["box:left", "box:right", *labels])
    motion = formats.read("x.c3d", data=data)
    assert motion.markers.names == tuple(labels)
    assert subjects(formats.File("x.c3d", data)) == ("Anna",)


SEGMENTS = {
    "worldbody": (0, 0, 0), "pelvis": (0, 0, 950), "torso": (0, 0, 1100), "neck": (0, 0, 1450),
    "head": (0, 0, 1550),
    **{f"{s}_{part}": (x, y * (-1 if s == "r" else 1), z)
       for s in "lr" for part, x, y, z in (
           ("thigh", 0, 90, 930), ("shank", 0, 100, 500), ("foot", 0, 100, 90),
           ("toes", 150, 100, 30), ("uarm", 0, 180, 1400), ("larm", 0, 250, 1130),
           ("hand", 0, 280, 880))},
}  # fmt: skip


@pytest.mark.parametrize("ratio", [1, 2])
def test_a_file_of_rotations_alone(ratio):
    frames = 6
    turns = np.zeros((frames * ratio, len(SEGMENTS), 17), "<f4")
    turns[..., [0, 5, 10, 15]] = 1
    turns[..., 12:15] = list(SEGMENTS.values())
    turns[..., 12] += 40 * np.arange(frames * ratio)[:, None] // ratio
    turns[3 * ratio, 5, 16] = -1
    more = {
        "POINT:LABELS": None,
        "POINT:FRAMES": frames,
        "ROTATION:USED": len(SEGMENTS),
        "ROTATION:RATIO": ratio,
        "ROTATION:LABELS": [f"{it}_4X4" for it in SEGMENTS],
    }
    start = c3d(np.zeros((frames, 0, 4)), more={**more, "ROTATION:DATA_START": 9})[16]
    more["ROTATION:DATA_START"] = start
    data = c3d(np.zeros((frames, 0, 4)), more=more, behind=turns.tobytes())
    motion = formats.read("x.c3d", data=data)
    assert (len(motion), motion.source.set, motion.source.up) == (frames, "Theia", "z")
    assert motion.markers.names == tuple(SEGMENTS)
    found = there(data)
    assert np.isnan(found[3, 5]).all()
    assert np.array_equal(found[4, 1], [160, 0, 950])
    clip = formats.cutter(formats.File("x.c3d", data))(Span(2, 5))
    assert np.array_equal(there(clip), found[2:5], equal_nan=True)
