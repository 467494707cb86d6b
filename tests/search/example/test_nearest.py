"""The best stretch of a long clip, and a bounded search through many."""

import numpy as np
from made_clips import dance

from lanindex.search.example.moves import clips_of
from lanindex.search.example.nearest import nearest

RATE = 30.0


def noise(seed, count):
    random = np.random.default_rng(seed)
    return [(int(random.integers(8)), 0) for _ in range(count)]


WAVE = [(0, 2), (8, 2), (4, 2), (8, 2), (0, 2)]


def laid_out(*clips):
    return clips_of(clips, [RATE] * len(clips), ["r_arm"])


def test_the_stretch_of_a_long_clip_is_found() -> None:
    long = dance([*noise(1, 40), *WAVE, *noise(2, 40)])
    example = laid_out(dance([(0, 0), *WAVE]))
    found = nearest(example, 2.5, laid_out(dance(noise(3, 90)), long), [1350] * 2, [RATE] * 2, 2)
    best = found.near[0]
    assert best.clip == 1
    assert best.likeness > 0.8
    assert abs(best.begin - 40 * 15) <= 15
    assert abs(best.end - 45 * 15) <= 15


def test_a_clip_of_like_length_is_compared_as_a_whole() -> None:
    example = laid_out(dance([(0, 0), *WAVE]))
    (near,) = nearest(example, 2.5, example, [75], [RATE], 5).near
    assert (near.begin, near.end) == (0, 75)


def test_what_was_not_looked_at_is_told() -> None:
    many = laid_out(*(dance(noise(seed, 9)) for seed in range(300)))
    example = laid_out(dance(noise(1000, 9)))
    bounded = nearest(example, 1e6, many, [135] * 300, [RATE] * 300, 300, most=256)
    assert (bounded.aligned, bounded.sure) == (256, False)
    assert nearest(example, 1e6, many, [135] * 300, [RATE] * 300, 300).sure


def test_few_are_aligned_where_few_are_wanted() -> None:
    random = [dance(noise(seed, 9)) for seed in range(2000)]
    many = laid_out(*random, dance([(0, 0), *WAVE]))
    found = nearest(laid_out(dance([(0, 0), *WAVE])), 1e6, many, [135] * 2001, [RATE] * 2001, 1)
    assert found.near[0].clip == 2000
    assert found.sure
    assert found.aligned <= 512
