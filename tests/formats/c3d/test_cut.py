"""Clips of C3D files hold the bytes and the counts of their frames."""

import numpy as np
import pytest
from made_c3d import c3d, standing

from lanindex import formats
from lanindex.formats.c3d import places, scan
from lanindex.model import Span

TRIAL = {"TRIAL:ACTUAL_START_FIELD": [7, 0], "TRIAL:ACTUAL_END_FIELD": [26, 0]}
EVENTS = {
    "EVENT:USED": 3,
    "EVENT:TIMES": np.array([[0.0, 0.12], [1.0, 2.5], [0.0, 0.2]]),
    "EVENT:LABELS": ["LHS", "LTO", "RTO"],
}


def cut(data: bytes, start: int, stop: int) -> bytes:
    return formats.cutter(formats.File("x.c3d", data))(Span(start, stop))


def layout(data: bytes):
    return scan(formats.File("x.c3d", data))


def frames(data: bytes) -> bytes:
    """Return the bytes of all frames."""
    where = layout(data)
    return data[where.start : where.start + where.frames * where.frame]


@pytest.mark.parametrize("processor", [84, 85, 86])
@pytest.mark.parametrize("scale", [-1.0, 0.5])
@pytest.mark.parametrize("span", [(0, 20), (0, 1), (19, 20), (4, 11), (4, 17)])
def test_a_clip_has_the_bytes_of_its_frames(processor, scale, span):
    analog = np.arange(20 * 6).reshape(20, 6)
    data = c3d(
        *(standing(20),),
        **dict(processor=processor, scale=scale, first=7, analog=analog, more={**TRIAL, **EVENTS}),
    )
    clip = cut(data, *span)
    one, other = layout(data), layout(clip)
    size = one.frame
    assert frames(clip) == frames(data)[span[0] * size : span[1] * size]
    assert (other.frames, other.first, other.doubts) == (span[1] - span[0], 7 + span[0], [])
    assert len(clip) % 512 == 0
    told = other.parameters
    for key, value in {
        "POINT:FRAMES": span[1] - span[0],
        "TRIAL:ACTUAL_START_FIELD": 7 + span[0],
        "TRIAL:ACTUAL_END_FIELD": 6 + span[1],
    }.items():
        assert told.count(key) == value
    whole = span == (0, 20)
    inside = [time for time in (0.12, 0.2) if 6 + span[0] <= time * 100 < 6 + span[1]]
    used = told.count("EVENT:USED")
    assert used == (3 if whole else len(inside))
    if not whole:  # events outside of it are gone, with what was said of them
        assert told.numbers("EVENT:TIMES")[1 : 2 * used : 2] == pytest.approx(inside)
        assert not any(told.numbers("EVENT:TIMES")[2 * used :])
        labels = [{0.12: "LHS", 0.2: "RTO"}[time] for time in inside]
        assert list(told.texts("EVENT:LABELS")) == labels + [""] * (3 - used)
    assert told.texts("POINT:LABELS") == one.parameters.texts("POINT:LABELS")


def test_a_clip_of_everything_is_the_file():
    data = c3d(standing(20), more={**TRIAL, **EVENTS}, first=7)
    assert cut(data, 0, 20) == data


@pytest.mark.parametrize(
    "lies",
    [
        dict(words={2: 27}),
        dict(words={3: 9}),
        dict(words={5: 900}, more={"POINT:FRAMES": 900}),
        dict(words={9: 5}),
        dict(more={"POINT:SCALE": 0.25}),
    ],
)
def test_a_clip_says_what_was_believed(lies):
    data = c3d(standing(12), **lies)
    clip = cut(data, 3, 4)
    assert layout(data).doubts
    assert layout(clip).doubts == []
    assert np.array_equal(places(clip, layout(clip)), places(data, layout(data))[3:4])


@pytest.mark.parametrize("trial", [True, False])
def test_frames_beyond_65535(trial):
    """Where their numbers have no room, they begin with 1, and the events move along."""
    points = np.ones((70_000, 2, 4))
    points[..., 0] += np.arange(70_000)[:, None]
    more = {"TRIAL:ACTUAL_START_FIELD": [1, 0], "TRIAL:ACTUAL_END_FIELD": [70_000 - 65536, 1]}
    events = {"EVENT:TIMES": np.array([[0.0, 12.5], [11.0, 30.0]])}
    told = {"POINT:LONG_FRAMES": 70_000.0, **events, **(more if trial else {})}
    data = c3d(points, ["a", "b"], more=told)
    clip = cut(data, 69_000, 70_000)
    where = layout(clip)
    assert (where.frames, where.first, where.doubts) == (1000, 69_001 if trial else 1, [])
    assert np.array_equal(places(clip, where)[:, 0, 0], points[69_000:, 0, 0])
    wanted = (0.0, 12.5, 11.0, 30.0) if trial else (0.0, 12.5 - 690, 0.0, 0.0)
    assert where.parameters.numbers("EVENT:TIMES") == wanted
    long = cut(data, 1000, 70_000)
    assert layout(long).frames == 69_000
    assert frames(long) == frames(data)[-69_000 * where.frame :]


def test_events_of_the_header_move_along():
    points = np.ones((66_000, 1, 4))
    data = bytearray(c3d(points, ["a"], more={"POINT:LONG_FRAMES": 66_000.0}))
    data[300:302] = 1, 0
    data[304:308] = np.float32(657.5).tobytes()
    clip = cut(bytes(data), 65_600, 65_900)
    assert np.frombuffer(clip, "<f4", 1, 304)[0] == 1.5
    assert clip[300] == 1
    data[304:308] = np.float32(900.5).tobytes()
    gone = cut(bytes(data), 65_600, 65_900)
    assert (gone[300], gone[304:308]) == (0, bytes(4))
