"""Real captures: beside the BVH that another program made of one of them."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import lanindex
from lanindex import formats
from lanindex.alphabet import JOINTS, kind_of
from lanindex.formats import amc
from lanindex.model import Motion, Span
from lanindex.pipeline.convert import stretch

LEG = ("Hip", "Knee", "Ankle", "Toe")
TAKES = ("01_01", "02_01", "02_03", "02_04", "02_05", "02_06", "11_01")


def joint(motion: Motion, name: str) -> np.ndarray:
    places: np.ndarray = motion.positions[:, motion.skeleton.body[JOINTS.index(name)]]
    return places.astype(float)


@pytest.fixture(scope="module")
def both(captures: Path) -> tuple[Motion, Motion]:
    """Return the same take as AMC, and as BVH without its T-pose."""
    amc_motion = formats.read(captures / "amc" / "cmu" / "01_01.amc")
    bvh = formats.read(captures / "bvh" / "cmu_cgspeed" / "01_01.bvh")
    assert len(amc_motion) == len(bvh) - 1 == 2751
    return amc_motion, bvh


@pytest.mark.parametrize("name", JOINTS)
def test_joints_are_where_the_conversion_has_them(both: tuple[Motion, Motion], name: str) -> None:
    ours, theirs = joint(both[0], name), joint(both[1], name)[1:]
    apart = np.linalg.norm(ours - theirs, axis=1)
    if name in ("Pelvis", "Chest") or name[1:] in LEG:
        assert apart.max() < 0.01
    elif name[1:] in ("Wrist", "Hand"):
        elbow, wrist = (joint(both[0], name[0] + it) for it in ("Elbow", "Wrist"))
        third = (wrist - elbow) / 3  # left out as the thorax is: a bone that is called the wrist
        shoulder = joint(both[0], "Neck") - joint(both[1], "Neck")[1:]
        assert np.linalg.norm(ours - theirs - shoulder - third, axis=1).max() < 0.1
    else:
        assert np.abs(apart - 116.55).max() < 0.01


@pytest.mark.parametrize("take", TAKES)
def test_a_clip_with_its_skeleton_reads_back_equal(
    captures: Path, tmp_path: Path, take: str
) -> None:
    path = captures / "amc" / "cmu" / f"{take}.amc"
    file, whole = formats.opened(path), formats.read(path)
    assert whole.source.unit == "inch/0.45"
    assert whole.source.up == "y"
    assert set(whole.skeleton.played()) == set(JOINTS)
    cut = formats.cutter(file)
    for ending, data in amc.beside(file):
        (tmp_path / f"clip{ending}").write_bytes(data)
    for start, stop in ((0, len(whole)), (7, 100), (len(whole) - 1, len(whole))):
        (tmp_path / "clip.amc").write_bytes(cut(Span(start, stop)))
        clip = formats.read(tmp_path / "clip.amc")
        assert np.array_equal(clip.positions, whole.positions[start:stop])
        assert whole.rotations is not None
        assert np.array_equal(clip.rotations, whole.rotations[start:stop])
        assert clip.warnings == whole.warnings


def test_symbols_are_those_of_the_conversion(both: tuple[Motion, Motion]) -> None:
    """Of legs, forearms, upper arms and hands: the whole arms differ with the forearm's length."""
    ours = lanindex.encode(both[0])
    theirs = lanindex.encode(replace(stretch(both[1], Span(1, len(both[1]))), first=0))
    for part in ours.tracks:
        if part in ("r_arm", "l_arm", "torso", "head") or kind_of(part) in ("twist", "incline"):
            continue
        symbols, wanted = ours.symbols(part), theirs.symbols(part)
        assert [it.words for it in symbols] == [it.words for it in wanted], part
        late = [abs(it.start - that.start) for it, that in zip(symbols, wanted, strict=True)]
        assert max(late, default=0) <= 2, part
