"""What a plain score leaves out, and what it keeps."""

import pytest

import lanindex
from lanindex.draw import draw
from lanindex.draw.picture import Label, MarkGroup, Polyline
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


@pytest.mark.parametrize(
    ("leans", "left"),
    [
        ("forward 30 1 1.3, place 0 1.3 1.6", []),  # a pulse of a walk
        ("forward 50 1 1.3, place 0 1.3 1.6", ["forward 50", "place 0"]),  # too far
        ("forward 30 1 1.6, place 0 1.6 1.9", ["forward 30", "place 0"]),  # too slow, and here
        ("forward 30 3 3.3, place 0 3.3 3.6", ["forward 30", "place 0"]),  # nobody steps
        ("forward 30 3 3.2, place 0 3.2 3.6", []),
        ("forward 30 1 2, r_forward 25 2 3", ["forward 30"]),
        ("forward 40 1 2, r_forward 70 2 3", ["forward 40", "r_forward 70"]),
        ("forward 60 1 1.3, forward 30 1.3 1.6, forward 60 1.6 3", ["forward 60"]),
    ],
)
def test_heads_and_torsos_do_not_pulse_with_the_steps(leans: str, left: list[str]) -> None:
    lines = [f"incline head_incline {it.strip()}" for it in leans.split(",")]
    assert told(score("incline head_incline place 0 0 0", *lines), "head_incline") == left


@pytest.mark.parametrize(
    ("ways", "each", "left"),
    [
        (["left", "right"] * 4, 0.4, ["left mid", "right mid", ""]),
        (["left", "right"] * 4 + ["left"], 0.4, ["left mid", "right mid", "", "left mid"]),
        (
            ["left", "right"] * 2 + ["l_forward", "right", "left", "r_back"],
            0.4,
            ["left mid", "right mid", ""],
        ),
        (["left", "right"] * 4, 0.6, ["left mid", "right mid"] * 4),
        (["left", "right"] * 2, 0.4, ["left mid", "right mid"] * 2),
        (["left", "forward", "right"] * 2, 0.4, ["left mid", "forward mid", "right mid"] * 2),
    ],
)
def test_quick_movements_to_and_fro_are_drawn_once(
    ways: list[str], each: float, left: list[str]
) -> None:
    lines = [
        f"direction r_arm {way} mid {5 + each * at:.1f} {5 + each * (at + 1):.1f}"
        for at, way in enumerate(ways)
    ]
    assert told(score(*lines, walk="#unit1\n"), "r_arm") == left


def test_a_turn_is_a_pivot_a_circular_way_or_a_turn_in_the_air() -> None:
    lines = [
        f"rotation body_turn right 90 {at} {stop}" for at, stop in ((0.5, 2), (2.5, 3.5), (5, 6))
    ]
    third = "support r_support r_forward mid 1.5 2"
    landing = [f"support {side}_support place mid 5 6" for side in ("r", "l")]
    turned = score(
        *lines, third, *landing, "jump jump place spring 5 6", "travel body_travel forward 0 0 1"
    )
    picture = draw(plain(turned))
    way, spot, flown = (it for it in picture.groups() if it.data["part"] == "body_turn")
    foot = next(it for it in picture.groups() if it.data["part"] == "l_support")
    lefts, rights = zip(
        *((min(xs), max(xs)) for xs in map(across, (way, spot, flown))), strict=True
    )
    assert lefts[1] <= min(across(foot)) < rights[1] < min(lefts[0], lefts[2])
    assert [len(it.marks[0].lines[0]) for it in (way, spot, flown)] == [2, 4, 4]  # a bar, boxes
    assert "body_travel" not in {it.data["part"] for it in picture.groups()}  # the circle tells it
    assert "90" in [it.text for it in way.marks if isinstance(it, Label)]


@pytest.mark.parametrize(
    ("third", "degrees", "ends"),
    [
        ("forward", 90, 2),  # a bar of a circular way, or a box of a turn
        ("forward", 360, 4),
        ("back", 90, 4),
        ("place", 90, 4),
    ],
)
def test_a_turn_is_a_circular_way_where_three_steps_curve(third: str, degrees: int, ends: int):
    turn = f"rotation body_turn left {degrees} 0.5 2"
    turned = draw(plain(score(turn, f"support r_support {third} mid 1.5 2"))).groups()
    (told,) = (it for it in turned if it.data["part"] == "body_turn")
    assert len(told.marks[0].lines[0]) == ends


def across(group: MarkGroup) -> list[int]:
    return [it.x + x for it in group.marks if isinstance(it, Polyline) for x, _ in it.lines[0]]


def test_a_pivot_stands_for_the_weight_and_a_hold_is_told_behind_it() -> None:
    turns = score("rotation body_turn left 90 1 2", walk="#unit1\nstance r_stance mid 0 4\n")
    picture = draw(turns)
    before, after = (
        it.marks[0] for it in picture.marks if getattr(it, "title", "")[:6] == "stands"
    )
    pivot = next(it for it in picture.groups()).marks[0]
    assert after.y < pivot.y < pivot.y + pivot.lines[0][3][1] < before.y


RAISE = [
    f"direction r_arm {cell} {at / 10} {(at + 1) / 10}"
    for at, cell in enumerate(("forward low", "forward mid", "forward high", "r_forward mid"))
]


def test_what_lies_on_the_way_is_part_of_the_movement_that_it_leads_to() -> None:
    raised = score("direction r_arm place low 0 0", *RAISE, walk="#unit1\n")
    _, up, down = plain(raised).symbols("r_arm")
    assert [up.words, (up.start, up.stop)] == ["forward high", (0, round(0.3 * raised.rate))]
    assert (up.tick, up.tick + up.ticks) == (0, down.tick)
    marked = plain(raised, [raised.symbols("r_arm")[2]]).symbols("r_arm")
    assert [it.words for it in marked[1:4]] == ["forward low", "forward mid", "forward high"]


@pytest.mark.parametrize(
    ("ways", "drawn"),
    [
        ("forward l_forward forward l_forward", ["forward"]),
        ("forward l_forward left", ["forward", "left"]),
        ("forward back", ["forward", "back"]),
    ],
)
def test_a_way_that_swerves_is_one(ways: str, drawn: list[str]) -> None:
    starts = (0, 2, 3, 5, 6)
    lines = [
        f"travel body_travel {way} 0 {start} {starts[at + 1]}"
        for at, (way, start) in enumerate(zip(ways.split(), starts, strict=False))
    ]
    swerving = score(*lines, walk="#unit1\n")
    assert [it.split()[0] for it in told(swerving, "body_travel")] == drawn
    found = plain(swerving).symbols("body_travel")
    assert found[-1].stop == swerving.symbols("body_travel")[-1].stop


def test_swings_are_kept_however_short() -> None:
    cells = ["left high", "right high"] * 2
    waves = [f"direction r_arm {it} {at / 8} {(at + 1) / 8}" for at, it in enumerate(cells)]
    assert told(score(*waves, walk="#unit1\n"), "r_arm") == cells


@pytest.mark.parametrize(
    ("lines", "drawn"),
    [
        (["bend r_arm_bend bend3 0 0.2", "bend r_arm_bend stretch0 0.2 0.4"], []),
        (["bend r_arm_bend bend3 0 0.2", "bend r_arm_bend stretch0 1 1.2"], ["3", "7"]),
        (["incline torso_incline forward 20 0 1"], []),
        (
            ["incline torso_incline forward 40 0 1", "incline torso_incline place 0 2 3"],
            ["forward 40", "place 0"],
        ),
    ],
)
def test_what_is_undone_at_once_and_what_hardly_leans_is_left_out(
    lines: list[str], drawn: list[str]
) -> None:
    part = lines[0].split()[1]
    still = "direction r_leg place low 0 0"
    assert told(score(still, *lines, walk="#unit1\n"), part) == drawn


def test_what_a_runner_does_with_knees_arms_and_shoulders_is_taken_for_granted() -> None:
    flights = [f"jump jump forward leap {at} {at + 0.25}" for at in (0.5, 1)]
    lines = [
        *("direction r_thigh forward mid 0.5 0.75", "direction r_thigh forward high 0.75 1"),
        "direction r_thigh forward high 3.5 4",
        *("twist torso_twist left 40 0.5 1", "twist torso_twist left 60 1 1.5"),
        *("bend r_arm_bend bend4 0 0.25", "direction r_arm forward mid 0.5 1"),
    ]
    run = score(*flights, *lines, walk=WALK[: WALK.index("direction r_arm forward")])
    assert told(run, "r_thigh") == ["forward high"] * 2
    assert told(run, "torso_twist") == ["left 60"]
    assert told(run, "r_arm") == ["place low"]


def test_legs_that_open_together_are_drawn() -> None:
    lines = ["stance r_stance mid 0 1", "support r_support place mid 1 1.5"]
    lines += ["stance r_stance mid 1.5 2", "direction r_leg right low 1 1.5"]
    for feet, drawn in (([], []), (["support l_support place mid 1 1.5"], ["right low"])):
        assert told(score(*lines, *feet, walk="#unit1\n"), "r_leg") == drawn


def test_a_leg_that_may_carry_makes_no_low_gesture() -> None:
    lost = [
        "stance r_stance mid 0 1",
        "direction r_leg right low 2 3",
        "direction r_leg right mid 3 4",
    ]
    for foot, drawn in ((None, ["right mid"]), ("l", ["right low", "right mid"])):
        carried = [f"stance {foot}_stance mid 0 4"] if foot else []
        assert told(score(*lost, *carried, walk="#unit1\n"), "r_leg") == drawn


def test_a_finer_part_that_moves_more_often_or_hangs() -> None:
    def cells(part: str, level: str, count: int) -> list[str]:
        ways = ("left", "right") * count
        return [
            f"direction {part} {it} {level} {at} {at + 1}" for at, it in enumerate(ways[:count])
        ]

    slow = cells("r_arm", "mid", 2) + cells("r_upper_arm", "low", 8)
    waving = score(*slow, *cells("r_forearm", "high", 8), walk="#unit1\n")
    hanging = score(*slow, *cells("r_forearm", "low", 8), walk="#unit1\n")
    assert {*plain(waving).tracks} == {"r_upper_arm", "r_forearm"}
    assert {*plain(hanging).tracks} == {"r_arm"}
