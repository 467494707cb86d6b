"""What a plain score leaves out, and what it keeps."""

import pytest

import lanindex
from lanindex.draw import draw
from lanindex.draw.picture import MarkGroup
from lanindex.draw.plain import plain
from lanindex.model import Score

WALK = """\
#unit0
support r_support place mid 0 0
support l_support place mid 0 0
direction r_leg place low 0 0
direction r_arm place low 0 0
#unit1
stance l_stance mid 0 1
stance r_stance mid 0 0.5
support r_support forward mid 0.5 1
stance r_stance mid 1 3
support l_support forward mid 1 1.5
stance l_stance mid 1.5 4
direction r_arm forward low 0.5 1
direction r_arm back low 1 1.5
"""


def score(*lines: str, walk: str = WALK) -> Score:
    return lanindex.read_lnd(walk + "".join(f"{line}\n" for line in lines))


def told(score: Score, part: str) -> list[str]:
    """Return what a plain score says of a part."""
    groups = draw(plain(score), seconds=True).groups()
    return [
        " ".join(it.data[name] for name in ("direction", "level", "amount") if name in it.data)
        for it in groups
        if it.data["part"] == part
    ]


def test_a_walk_is_its_steps() -> None:
    walk = score("direction r_leg back low 0.5 0.75", "direction r_leg forward low 0.75 1")
    assert {it.data["part"] for it in draw(plain(walk)).groups()} == {
        *("r_support", "l_support", "r_arm")
    }
    assert told(walk, "r_arm") == ["place low"]  # it swings low with the walk
    assert told(walk, "r_support") == ["place mid", "forward mid"]


@pytest.mark.parametrize(
    ("line", "drawn"),
    [
        ("direction r_leg back low 1.5 2.5", []),  # it carries
        ("direction r_leg forward mid 0.5 1", ["forward mid"]),  # lifted
        ("direction r_leg right low 0.5 1", ["right low"]),  # not where the step goes
        ("direction r_leg back mid 0.5 1", []),  # the heel of a runner
        ("direction r_leg forward low 3 4", ["forward low"]),  # free, and no step follows
    ],
)
def test_a_leg_gestures_while_it_is_free(line: str, drawn: list[str]) -> None:
    assert told(score(line), "r_leg") == drawn


def test_a_gesture_is_over_where_the_foot_has_taken_the_weight() -> None:
    kick = score("direction r_leg forward mid 0.5 0.75")
    for start, drawn in ((0.8, 1), (1.5, 0)):
        groups = draw(plain(kick), seconds=True, start=start).groups()
        assert sum(it.data["part"] == "r_leg" for it in groups) == drawn


def test_a_knee_that_straightens_in_a_walk_is_drawn_once() -> None:
    lines = ["bend r_leg_bend bend4 0 0.25", "bend r_leg_bend stretch0 0.75 1"]
    knee = score(*lines, "bend r_leg_bend bend4 1 1.25", "bend r_leg_bend stretch0 1.25 1.5")
    assert told(knee, "r_leg_bend") == ["4", "7"]


def test_knees_that_are_lifted_stand_for_the_leg() -> None:
    lines = [f"direction r_thigh forward mid {at} {at + 0.25}" for at in (0.5, 0.75, 3.5)]
    lifted = score("direction r_leg forward low 0.5 1", *lines)
    assert (told(lifted, "r_leg"), told(lifted, "r_thigh")) == ([], ["forward mid"] * 3)


def test_who_tells_no_weight_means_every_gesture() -> None:
    written = score("direction r_leg forward low 0 1", walk="#unit1\n")
    assert told(written, "r_leg") == ["forward low"]


def test_a_forearm_that_moves_alone_has_a_column() -> None:
    waves = [
        f"direction {part} {way} high {at} {at + 1}"
        for at, way in enumerate(("left", "right", "left"))
        for part in ("r_forearm", "r_arm")
    ]
    alone = score(*waves, "direction r_upper_arm right mid 0 0.25", walk="#unit1\n")
    assert {*plain(alone).tracks} == {"r_forearm", "r_upper_arm"}
    both = [it.replace("r_arm", "r_upper_arm") for it in waves if "r_arm" in it]
    assert {*plain(score(*waves, *both, walk="#unit1\n")).tracks} == {"r_arm"}


def test_torso_and_head_are_told_once_and_rest_is_silent() -> None:
    bow = score(
        *("direction torso place high 0 1", "direction torso forward high 1 2"),
        *("direction torso forward mid 2 3", "incline torso_incline forward 60 1 3"),
        *("direction head place high 0 1", "twist head_turn place 0 0 1"),
        *("travel body_travel place 0 0 3", "bend r_arm_bend bend1 0 1"),
        walk="#unit1\n",
    )
    assert {*plain(bow).tracks} == {"torso_incline"}


def test_weight_is_held_from_the_starting_position_on_and_on_every_staff() -> None:
    still = score(walk="#unit1\nstance r_stance mid 0 12\nstance l_stance mid 0 12\n")
    held = [it for it in draw(still, bars=1).marks if isinstance(it, MarkGroup) and not it.data]
    assert [it.title for it in held] == ["stands on both feet"] * 3
    assert len({it.marks[0].y for it in held}) == 1


def test_who_turns_on_the_spot_turns_across_the_supports() -> None:
    lines = ["rotation body_turn right 90 {} {}".format(*it) for it in ((0.5, 1.5), (2, 3))]
    way, spot = (
        it.marks[0] for it in draw(score(*lines)).groups() if it.data["part"] == "body_turn"
    )
    (left, right), (begin, end) = (
        (it.x + min(x for x, _ in it.lines[0]), it.x + max(x for x, _ in it.lines[0]))
        for it in (spot, way)
    )
    assert right < begin
    assert right - left > end - begin
