"""Joints between clusters of markers, on legs whose joints are known."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from lanindex.body.markers import Clusters, clusters_of, marker_set_of, shape_of, turns_of

NAMES = [f"PV{it}" for it in range(1, 5)] + [
    f"{side}{segment}{it}" for side in "RL" for segment in ("TH", "SK", "FT") for it in range(1, 5)
]
OUT = {"R": 1.0, "L": -1.0}


def plate(numbers: np.random.Generator, middle: tuple[float, float, float]) -> np.ndarray:
    """Return four markers about a place, no three of them in a line."""
    square = np.array([(0, 60, 60), (10, -60, 50), (-10, 50, -60), (5, -55, -55)], float)
    return square + numbers.normal(0, 5, (4, 3)) + middle


def legs(frames: int = 200, hinge: bool = False) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Return markers (T, 28, 3) and the joints, y up, of legs that swing, and all of it turns."""
    numbers = np.random.default_rng(5)
    phase = np.linspace(0, 4 * np.pi, frames)
    world = Rotation.from_euler("yx", np.stack([phase / 9, np.sin(phase) / 20], axis=1))
    ground = np.stack([10 * phase, 950 + 20 * np.sin(2 * phase), 40 * phase], axis=1)
    held = {"PV": (world, ground, plate(numbers, (0, 60, -120)))}
    joints = {}
    for side, out in OUT.items():
        turn, place = world, ground
        for segment, joint, offset, size in (
            ("TH", "Hip", (90 * out, -80, 0), 0.5),
            ("SK", "Knee", (0, -400, 0), 0.6),
            ("FT", "Ankle", (0, -390, 0), 0.3),
        ):
            place = place + turn.apply(offset)
            joints[side + joint] = place
            bend = np.stack([
                size * np.sin(phase + out),
                0.3 * size * np.cos(1.7 * phase + out),
                0.3 * size * np.sin(2.3 * phase),
            ], axis=1)  # fmt: skip
            if hinge and joint == "Knee":
                bend[:, 1:] = 0
            turn = turn * Rotation.from_euler("xyz", bend)
            held[side + segment] = turn, place, plate(numbers, (70 * out, -150, 10))
    order = ["PV", *(side + segment for side in "RL" for segment in ("TH", "SK", "FT"))]
    markers = [
        turn.apply(point) + place
        for turn, place, points in (held[name] for name in order)
        for point in points
    ]
    return np.stack(markers, axis=1), joints


def places(markers: np.ndarray, scale: float = 1.0) -> dict[str, np.ndarray]:
    """Return where the joints are, (T, 3) each."""
    made = marker_set_of(NAMES)
    _, at = made.over(markers, scale, 4096)
    return dict(zip(made.joints, at(slice(None)).swapaxes(0, 1), strict=True))


def off(markers: np.ndarray, joints: dict[str, np.ndarray], scale: float = 1.0) -> dict[str, float]:
    """Return how far the joints that are found lie from the true ones, at most."""
    found = places(markers, scale)
    return {
        name: float(np.linalg.norm(found[name] - place, axis=1).max())
        for name, place in joints.items()
    }


@pytest.mark.parametrize("block", [50, 4096])
def test_joints_that_turn_about_all_axes_are_found(monkeypatch, block):
    monkeypatch.setattr("lanindex.body.markers.BLOCK", block)
    markers, joints = legs()
    assert max(off(markers, joints).values()) < 1e-6


def test_joints_of_some_frames():
    markers, _ = legs()
    markers[5, :4] = np.nan
    made = marker_set_of(NAMES)
    whole = np.stack([*places(markers).values()], axis=1)
    known, at = made.over(markers, 1.0, 50)
    np.testing.assert_array_equal(at(slice(3, 9)), whole[3:9])
    np.testing.assert_array_equal(known, np.isfinite(whole).all(axis=2))


def test_markers_that_tremble():
    markers, joints = legs(600)
    trembling = markers + np.random.default_rng(3).normal(0, 1, markers.shape)
    errors = off(trembling, joints)
    assert max(errors.values()) < 12, errors
    assert np.median(list(errors.values())) < 6, errors


def test_of_a_hinge_a_point_of_its_axis_is_taken():
    markers, joints = legs(hinge=True)
    found = places(markers)
    for side, out in OUT.items():
        thigh = Rotation.from_matrix(turns_of_thigh(markers, side))
        away = thigh.inv().apply(found[f"{side}Knee"] - joints[f"{side}Knee"])
        np.testing.assert_allclose(away[:, 1:], 0, atol=1e-6)  # the axis is x
        assert 40 < away[0, 0] * out < 100  # where the clusters are


def turns_of_thigh(markers: np.ndarray, side: str) -> np.ndarray:
    """Return how a thigh is turned from how it would stand upright."""
    way = [NAMES.index(f"{side}TH{it}") for it in range(1, 5)]
    numbers = np.random.default_rng(5)
    plate(numbers, (0, 0, 0))
    plates = {s: [plate(numbers, (70 * OUT[s], -150, 10)) for _ in range(3)] for s in "RL"}
    shape = plates[side][0]
    return turns_of(markers[:, way], shape - shape.mean(axis=0))[0]


def test_gaps():
    """Three markers of four tell a cluster; of a joint either cluster does."""
    markers, joints = legs()
    index = NAMES.index("RTH1")
    markers[20:40, index] = np.nan
    markers[60:80, index : index + 2] = np.nan
    markers[90:95, index : index + 2] = np.nan
    markers[90:95, NAMES.index("RSK1") : NAMES.index("RSK3")] = np.nan
    found = places(markers)
    unknown = np.isnan(found["RKnee"][:, 0])
    assert np.flatnonzero(unknown).tolist() == list(range(90, 95))
    known = found["RKnee"][~unknown]
    np.testing.assert_allclose(known, joints["RKnee"][~unknown], atol=1e-6)


def test_segments_that_hold_no_point_in_common_have_no_joint():
    markers, _ = legs()
    index = NAMES.index("RSK1")
    markers[:, index : index + 4] += 300 * np.sin(np.linspace(0, 20, len(markers)))[:, None, None]
    found = places(markers)
    assert np.isnan(found["RKnee"]).all()
    assert np.isfinite(found["LKnee"]).all()
    metres = places(markers / 1000, 1000.0)
    for joint, place in found.items():
        np.testing.assert_allclose(metres[joint] * 1000, place, atol=1e-6)


def test_markers_in_a_line_tell_no_turn():
    markers, _ = legs()
    index = NAMES.index("RFT1")
    line = np.linspace(0, 1, 4)[:, None] * [0, 30, 100]
    markers[:, index : index + 4] = markers[:, index, None] + line
    assert np.isnan(shape_of(markers, tuple(range(index, index + 4)))).all()
    found = places(markers)
    assert np.isnan(found["RAnkle"]).all()
    assert np.isfinite(found["RKnee"]).all()


def test_what_is_told_of_them():
    made = marker_set_of(NAMES)
    assert isinstance(made, Clusters)
    assert made.sources(NAMES)["RKnee"] == "between RTH1 RTH2 RTH3 RTH4 and RSK1 RSK2 RSK3 RSK4"
    assert made.joints[0] == "Pelvis"
    assert made.used == frozenset(range(28))
    assert "sideways" in made.doubts[0]


def test_a_segment_without_three_markers():
    short = [name for name in NAMES if name not in ("LFT1", "LFT2")]
    assert marker_set_of(short) is None
    assert clusters_of([], []) is None
