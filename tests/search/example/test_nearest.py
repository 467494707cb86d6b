"""The best stretch of a long clip, and a bounded search through many."""

import numpy as np
import pytest
from made_clips import clips_of, dance, source_of

from lanindex.search.example import likeness as module
from lanindex.search.example.likeness import ClipSource, nearest

RATE = 30.0


def noise(seed, count):
    random = np.random.default_rng(seed)
    return [(int(random.integers(8)), 0) for _ in range(count)]


WAVE = [(0, 2), (8, 2), (4, 2), (8, 2), (0, 2)]


def laid_out(*clips):
    return clips_of(clips, [RATE] * len(clips), ["r_arm"])


def among(frames, *clips):
    return source_of(clips, [RATE] * len(clips), ["r_arm"], [frames] * len(clips))


def test_the_stretch_of_a_long_clip_is_found() -> None:
    long = dance([*noise(1, 40), *WAVE, *noise(2, 40)])
    example = laid_out(dance([(0, 0), *WAVE]))
    found = nearest(example, 2.5, among(1350, dance(noise(3, 90)), long), 2)
    best = found.near[0]
    assert best.clip == 1
    assert best.likeness > 0.8
    assert abs(best.begin - 40 * 15) <= 15
    assert abs(best.end - 45 * 15) <= 15


def test_a_clip_of_like_length_is_compared_as_a_whole() -> None:
    clip = dance([(0, 0), *WAVE])
    (near,) = nearest(laid_out(clip), 2.5, among(75, clip), 5).near
    assert (near.begin, near.end) == (0, 75)


def test_what_was_not_looked_at_is_told() -> None:
    many = among(135, *(dance(noise(seed, 9)) for seed in range(300)))
    example = laid_out(dance(noise(1000, 9)))
    bounded = nearest(example, 1e6, many, 300, most=256)
    assert (bounded.aligned, bounded.sure) == (256, False)
    assert nearest(example, 1e6, many, 300).sure


def test_few_are_aligned_where_few_are_wanted() -> None:
    random = [dance(noise(seed, 9)) for seed in range(2000)]
    many = among(135, *random, dance([(0, 0), *WAVE]))
    found = nearest(laid_out(dance([(0, 0), *WAVE])), 1e6, many, 1)
    assert found.near[0].clip == 2000
    assert found.sure
    assert found.aligned <= 512


def test_few_clips_are_laid_out_at_a_time(monkeypatch: pytest.MonkeyPatch) -> None:
    many = among(525, *(dance([*noise(seed, 30), *WAVE]) for seed in range(60)))
    example = laid_out(dance([(0, 0), *WAVE]))
    asked = example, 2.5, many, 20
    wanted = nearest(*asked)
    sizes, seen, plain = [], [], ClipSource.clips

    def clips(self, places):
        sizes.append(len(places))
        return plain(self, places)

    monkeypatch.setattr(ClipSource, "clips", clips)
    monkeypatch.setattr(module, "_LAID_OUT", 140)
    found = nearest(*asked, watch=lambda noun, done, total: seen.append((noun, done, total)))
    assert max(sizes) <= 5  # of 35 rows each
    assert [one[:3] for one in found.near] == [one[:3] for one in wanted.near]
    assert [near.likeness for near in found.near] == pytest.approx(
        [near.likeness for near in wanted.near], abs=1e-6
    )
    assert seen[0] == ("captures", 0, 60)
    assert len(seen) == len(sizes)  # whoever waits is told before each piece of work
