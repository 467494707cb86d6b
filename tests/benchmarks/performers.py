"""How well the patterns of mae.toml tell gestures apart on performers nobody has seen.

    python tests/benchmarks/performers.py [PERFORMERS]

Five people did the gestures, and the patterns were written with all five in view. So others are
made up: each has habits of their own, drawn at random and kept through all fourteen gestures, and
does each gesture as one of the clips does it, changed by these habits, joint by joint, before
anything is written down. A second company performs the literal scores of the gestures, so that no
clip plays a part at all. Printed are the mean F1 over the gestures, all performers together, and of
performers by themselves mean, standard deviation and the worst tenth; by strength of the habits,
and for one habit at a time. The captures are those of LANINDEX_CAPTURES.

Mean F1 of all performers together; of each alone the mean, its spread and the worst tenth (200 at
strength 1, else 50, of one habit 20; a quarter and what stood there before: 30):

    clips               today                     before     scores  today  before
    strength 0.25       .989   .988 ± .029  .969    .977             .999    .973
    strength 0.5        .975   .965 ± .048  .902    .931             .998    .961
    strength 1          .919   .896 ± .079  .786    .807             .947    .826
    strength 1.5        .812   .760 ± .117  .629
    aim alone .921; size .977, noise .977, overshoot .982, width .985, tempo .995, others 1.000

With --near .981, .965, .919 at strengths of a quarter, a half, one: it wins nothing. The scores of
strength 1 were performed by 30. --fuzzy refuses patterns with lines beside each other in brackets.
"""

import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields, replace
from fractions import Fraction
from itertools import compress, pairwise
from pathlib import Path

import numpy as np
from fuzzy import lnd
from places import CAPTURES, HERE, changed

from lanindex.alphabet import JOINTS
from lanindex.encoding import encode
from lanindex.evaluate import Clip, evaluate, read_patterns
from lanindex.formats import read
from lanindex.model import Capture, Motion
from lanindex.notation import lnd as notation
from lanindex.perform import perform

PERFORMERS = 200

FIRST = 1000
"""The first performer that is tried; those before were looked at while patterns were written."""

FOLDER = CAPTURES / "bvh" / "mae_openni"
SCORES = CAPTURES / "laban" / "mae"

EITHER_HAND = {"clap", "pinch", "raise"}
"""Gestures that a left-handed performer does the other way round and are the same."""

BOTH_ARMS = {"clap", "pinch", "raise", "indi", "sequential"}
LEFT = {"hammer"}
"""Which arms a gesture is made of; the other one does what the performer is used to."""

SAME = {"cut"}
"""Gestures whose score is that of another one: drawn, a cut is a swipe."""

IDLE = {
    "as it was": None,
    "hanging": ((0, -88), (0, -80)),
    "a little out": ((80, -70), (60, -65)),
    "bent": ((30, -75), (0, -10)),
    "on the hip": ((70, -50), (-60, -40)),
    "behind": ((140, -70), (200, -50)),
    "on the belly": ((30, -75), (-60, -5)),
}
"""Where upper arm and forearm are meanwhile: degrees from forward to the own side, and up."""


@dataclass(frozen=True)
class Habits:
    """What a performer does in their own way; of nothing but defaults is as the clip was.

    Attributes
    ----------
    aim : tuple of float
        By which both arms, right and left, point higher and more outward, and their forearms
        besides: (up, out, up, out) of each, degrees.
    size, width : float
        By which elevations and swings to the side are larger.
    tempo : float
        By which all is faster.
    before, after : float
        Seconds of waiting.
    home : float
        Seconds in which the arms sink until they hang, when all is over; 0: they stay.
    overshoot : float
        By which a movement goes on beyond its aim.
    settling : tuple of float
        Where each arm sinks to at the end: (up, out) of each, degrees.
    noise, trembling : float
        Standard deviations, mm, of each coordinate: slow (a fifth of a second) and by the frame.
    idle : str
        What an arm that is not needed does.
    left : bool
        Whether left-handed.
    """

    aim: tuple[float, ...] = (0.0,) * 8
    size: float = 1.0
    width: float = 1.0
    tempo: float = 1.0
    before: float = 0.0
    after: float = 0.0
    home: float = 0.0
    overshoot: float = 0.0
    settling: tuple[float, ...] = (0.0,) * 4
    noise: float = 0.0
    trembling: float = 0.0
    idle: str = "as it was"
    left: bool = False


def drawn(seed: int, strength: float) -> Habits:
    """Return the habits of a performer; at strength 1 the whole of what is to be expected."""
    random = np.random.default_rng([seed, 7])

    def between(low: float, high: float, middle: float = 1.0) -> float:
        return float(middle + strength * (random.uniform(low, high) - middle))

    whole = random.uniform(-15, 15, 4) * strength
    more = random.uniform(-8, 8, 4) * strength
    return Habits(
        aim=(*whole[:2], *more[:2], *whole[2:], *more[2:]),
        size=between(0.75, 1.15),
        width=between(0.8, 1.15),
        tempo=float(np.exp(random.uniform(np.log(0.6), np.log(1.6)) * strength)),
        before=between(0, 1.5, 0),
        after=between(0, 1.5, 0),
        home=float(random.uniform(0.6, 1.2)) if random.random() < 0.3 * strength else 0.0,
        overshoot=between(0, 0.4, 0),
        settling=tuple(random.uniform((-25, -15, -25, -15), (0, 15, 0, 15)) * strength),
        noise=between(0, 20, 0),
        trembling=between(0, 4, 0),
        idle=str(random.choice(list(IDLE))) if random.random() < strength else "as it was",
        left=bool(random.random() < 0.1 * strength),
    )


def done(motion: Motion, gesture: str, habits: Habits, seed: int) -> Motion:
    """Return a gesture as a performer of other habits does it."""
    random = np.random.default_rng(seed)
    if habits.left and gesture in EITHER_HAND:
        motion = changed.mirrored(motion)
    rate = float(motion.rate) * habits.tempo
    positions = motion.positions[motion.first :].astype(np.float64)
    positions = waited(positions, habits, rate)
    free = () if gesture in BOTH_ARMS else ("R",) if gesture in LEFT else ("L",)
    for number, side in enumerate("RL"):
        aim = np.array(habits.aim[4 * number : 4 * number + 4])
        settling = np.array(habits.settling[2 * number : 2 * number + 2])
        idle = IDLE[habits.idle] if side in free else None
        moved(positions, motion.skeleton.body, side, habits, aim, settling, idle, rate, random)
    positions += wandering(positions.shape, habits.noise, 0.2 * rate, random)
    positions += random.normal(0, habits.trembling, positions.shape) if habits.trembling else 0
    exact = motion.rate * Fraction(habits.tempo).limit_denominator(100)
    return replace(
        motion, rate=exact, positions=positions.astype(np.float32), first=0, rotations=None
    )


def waited(positions: np.ndarray, habits: Habits, rate: float) -> np.ndarray:
    counts = np.ones(len(positions), np.int64)
    counts[0] += round(habits.before * rate)
    counts[-1] += round((habits.after + habits.home) * rate)
    return np.repeat(positions, counts, axis=0)


def wandering(
    shape: tuple[int, ...], size: float, frames: float, random: np.random.Generator
) -> np.ndarray:
    """Return noise that is about the same for so many frames."""
    knots = random.normal(0, size, (int(shape[0] / frames) + 3, *shape[1:])) if size else 0
    if not size:
        return np.zeros(shape)
    places = np.arange(shape[0]) / frames
    low = places.astype(np.int64)
    share = (places - low)[:, None, None]
    share = eased(share)
    # between two knots a mean is calmer than either
    spread = np.sqrt(share**2 + (1 - share) ** 2)
    return (knots[low] * (1 - share) + knots[low + 1] * share) / spread


def moved(positions, body, side, habits, aim, settling, idle, rate, random) -> None:
    """Change the bones of one arm, and put its joints where they lead."""
    sign = 1.0 if side == "R" else -1.0
    across = positions[:, body[JOINTS.index("RHip")]] - positions[:, body[JOINTS.index("LHip")]]
    across = sign * across
    outward = np.arctan2(across[:, 2], across[:, 0])
    chain = [body[JOINTS.index(side + name)] for name in ("Shoulder", "Elbow", "Wrist", "Hand")]
    chain = [joint for joint in chain if joint >= 0]
    old = positions[:, chain].copy()
    wander = [wandering((len(old), 1, 1), 6.0, rate, random)[:, 0, 0] for _ in range(2)]
    rest = min(len(old), max(1, round(0.4 * rate)))
    sinking = np.minimum(1, np.arange(len(old) - 1, -1, -1) / rest)
    sinking = 1 - eased(sinking)
    home = min(len(old), round(habits.home * rate))
    hanging = np.zeros(len(old))
    hanging[len(old) - home :] = eased(np.linspace(0, 1, home))
    for bone, (near, far) in enumerate(pairwise(chain)):
        x, y, z = (old[:, bone + 1] - old[:, bone]).T
        length, flat = np.sqrt(x * x + y * y + z * z), np.hypot(x, z)
        # from forward to the own side, whichever that is
        way = np.degrees(turned(np.pi / 2 - sign * (np.arctan2(z, x) - outward)))
        rise = np.degrees(np.arctan2(y, flat))
        if idle is not None:
            way, rise = (value + own for value, own in zip(idle[min(bone, 1)], wander, strict=True))
        else:
            lower = np.array([aim[2], aim[3]]) if bone else np.zeros(2)
            way, rise = aimed(way, rise, habits, aim[:2] + lower, sinking, settling)
        rise, way = np.radians(np.clip(rise, -90, 90)), np.radians(way)
        angle = outward + sign * (np.pi / 2 - way)
        flat = length * np.cos(rise)
        bone_now = np.stack((flat * np.cos(angle), length * np.sin(rise), flat * np.sin(angle)), 1)
        if idle is None:
            down = length[:, None] * np.array([0.0, -1.0, 0.0])
            bone_now = led(bone_now, down, hanging)
        if idle is None and habits.overshoot:
            bone_now = beyond(bone_now, habits.overshoot, max(1, round(0.15 * rate)))
        positions[:, far] = positions[:, near] + bone_now


def led(bone, there, share):
    """Return a bone led towards where it points at last, by a share for each frame."""
    way = bone + share[:, None] * (there - bone)
    length = np.linalg.norm(bone, axis=1, keepdims=True)
    return way * length / np.maximum(np.linalg.norm(way, axis=1, keepdims=True), 1e-6)


def eased(share):
    """Return how far a movement has come, from still to still."""
    return share * share * (3 - 2 * share)


def turned(angle):
    """Return an angle from minus to plus half a turn."""
    return (angle + np.pi) % (2 * np.pi) - np.pi


def aimed(way, rise, habits: Habits, aim, sinking, settling):
    """Return where a bone points, degrees outward and up; what hangs goes on hanging."""
    lifted = np.clip((rise + 90) / 45, 0, 1)
    larger = rise * (1 + (habits.size - 1) * lifted)
    up = larger + lifted * (aim[0] + sinking * settling[0])
    before = np.abs(way) < 135
    wider = np.where(before, 22.5 + (way - 22.5) * habits.width, way)
    out = wider + lifted * (aim[1] + sinking * settling[1])
    return out, up


def beyond(bone, share: float, frames: int):
    """Return a bone that goes on beyond where it is led, by a share of its last movement."""
    last = np.concatenate([np.repeat(bone[:1], frames, axis=0), bone])[: len(bone)]
    return led(bone, 2 * bone - last, np.full(len(bone), share))


def recorded() -> dict[str, list[Motion]]:
    """Return the clips, by gesture."""
    found: dict[str, list[Motion]] = {}
    for path in sorted(FOLDER.rglob("*.bvh")):
        found.setdefault(path.parent.name, []).append(read(path))
    return found


def written() -> dict[str, list[Motion]]:
    """Return the scores as the standard body carries them out, by gesture."""
    found: dict[str, list[Motion]] = {}
    for path in sorted(SCORES.rglob("*.laban")):
        if path.parent.name in SAME:
            continue
        motion = perform(notation.read(in_units(lnd(path)).encode()), rate=30)
        found.setdefault(path.parent.name, []).append(motion)
    return found


def in_units(text: str) -> str:
    """Return a score whose starting positions stand before the first beat; a beat is half a second.

    Where one symbol was drawn a little into the next of its part, it ends there.
    """
    shown = text.replace(" right_", " r_").replace(" left_", " l_").replace("middle", "mid")
    lines = [line.split() for line in shown.splitlines()]
    begun = [" ".join(line) for line in lines if line[4] == line[5]]
    later = [(part, float(start), float(stop), way) for _, part, *way, start, stop in lines]
    later = sorted(it for it in later if it[1] < it[2])
    first = min(start for _, start, *_ in later)
    told = []
    for (part, start, stop, way), after in zip(later, [*later[1:], ("", 0.0)], strict=True):
        stop = min(stop, after[1]) if after[0] == part else stop
        told.append(f"direction {part} {' '.join(way)} {start - first:g} {stop - first:g}")
    return "\n".join(["#speed=120", "#rhythm 4/4", "#unit0", *begun, "#unit1", *told, ""])


def company(
    motions: dict[str, list[Motion]], habits: Sequence[Habits], seed: int = 0
) -> list[list[Clip]]:
    """Return the clips of performers, each with one of every gesture, written down."""
    found: list[list[Clip]] = []
    for performer, own in enumerate(habits):
        random = np.random.default_rng([seed, performer])
        clips = []
        for gesture, choice in motions.items():
            motion = done(choice[random.integers(len(choice))], gesture, own, performer)
            score = encode(motion)
            number = len(found) * len(motions) + len(clips) + 1
            path = f"{performer}/{gesture}"
            capture = Capture(number, path, "bvh", "", gesture, score.rate, score.frames)
            clips.append(Clip(capture, score.tracks, None))
        found.append(clips)
    return found


@dataclass(frozen=True)
class Figures:
    """Mean F1 over gestures: of all performers together, and of each alone; by gesture."""

    together: float
    alone: np.ndarray
    by_gesture: dict[str, float]
    by_error: dict[tuple[str, str], int]


def judged(clips: list[list[Clip]], patterns: Path) -> Figures:
    expectations = read_patterns(patterns)
    flat = [clip for own in clips for clip in own]
    results = evaluate(flat, expectations)
    found = np.array([it.found for it in results]).reshape(len(results), len(clips), -1)
    wanted = np.array([it.wanted for it in results]).reshape(found.shape)

    def f1(axes):
        either = (found.sum(axis=axes) + wanted.sum(axis=axes)).astype(float)
        return 2 * (found & wanted).sum(axis=axes) / np.maximum(either, 1)

    names = [it.name for it in expectations]
    gestures = [clip.capture.label for clip in clips[0]]
    there = wanted.any(axis=(1, 2))
    found, wanted, names = found[there], wanted[there], list(compress(names, there))
    errors = {
        (name, gesture): int((found[one, :, place] != wanted[one, :, place]).sum())
        for one, name in enumerate(names)
        for place, gesture in enumerate(gestures)
    }
    whole = f1((1, 2))
    return Figures(
        float(whole.mean()), f1(2).mean(axis=0), dict(zip(names, whole, strict=True)), errors
    )


def told(name: str, figures: Figures) -> None:
    alone = figures.alone
    low = [f"{it} {f1:.2f}" for it, f1 in figures.by_gesture.items() if f1 < 0.95]
    print(
        f"{name:24} {figures.together:.3f}   {alone.mean():.3f} ± {alone.std():.3f}"
        f"  {np.quantile(alone, 0.1):.3f}   {', '.join(low)}",
        flush=True,
    )


def one_at_a_time(seed: int) -> dict[str, Habits]:
    """Return a performer of one habit alone, by habit."""
    whole = drawn(seed, 1.0)
    return {it.name: Habits(**{it.name: getattr(whole, it.name)}) for it in fields(Habits)}


def main() -> None:
    count = int((sys.argv[1:] or [str(PERFORMERS)])[0])
    patterns = HERE / "mae.toml"
    companies: dict[str, Callable[[], dict[str, list[Motion]]]] = {
        "clips": recorded,
        "scores": written,
    }
    for name, made in companies.items():
        motions = made()
        print(f"{name:24} together  each alone  a tenth below   gestures below .95")
        for strength in (0.0, 0.5, 1.0, 1.5):
            size = count if strength == 1 else count // 4
            habits = [drawn(FIRST + seed, strength) for seed in range(size)]
            told(f"strength {strength:g}", judged(company(motions, habits), patterns))
        for habit in (it.name for it in fields(Habits)):
            habits = [one_at_a_time(FIRST + seed)[habit] for seed in range(count // 10)]
            told(f"{habit} alone", judged(company(motions, habits), patterns))


if __name__ == "__main__":
    main()
