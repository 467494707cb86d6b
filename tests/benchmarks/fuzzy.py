"""How well the intended score of a gesture finds the gesture as people do it.

    python tests/benchmarks/fuzzy.py

The scores of fourteen gestures before a depth camera, as their makers drew them, are patterns as
they stand; a class is found where one of its scores has a hit. One allowance for all classes:
printed is the mean F1 over the fourteen, for exact search and for a row of allowances; then the
same but for hits in clips of a gesture whose score, itself searched, contains the pattern: a scroll
down is the middle of a rotation, and a swipe and a cut are drawn alike. For one allowance each
class is told. No clip was looked at to draw a score. The captures are those of LANINDEX_CAPTURES.

Then the time that `--fuzzy 2` takes over five million symbols of one part: the best fifty hits, and
all of them; the processor's, the median of five, once what is kept of columns is there. Beside it
the time that rapidfuzz takes for the edit distance between three symbols and each capture.
"""

import xml.etree.ElementTree as ElementTree
from collections import Counter, defaultdict
from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from itertools import pairwise
from pathlib import Path
from statistics import mean, median
from time import process_time

import synthetic
from places import CAPTURES
from rapidfuzz import process
from rapidfuzz.distance import Levenshtein

from lanindex.alphabet import PARTS
from lanindex.encoding import encode
from lanindex.formats import read
from lanindex.model import Capture, Track
from lanindex.model.columns import columns_of, roster_of
from lanindex.notation import read as read_score
from lanindex.search import fuzzy
from lanindex.search.language import parse
from lanindex.search.match import Finder

ALLOWED = ("0", "0.5", "1", "5%", "10%", "15%", "20%", "25%", "30%")
TIMED = (
    "r_arm right mid -> r_forward high -> place high",
    "r_arm forward low -> forward mid -> place high",
    "r_arm right mid ... place high",
)
TOLD = "15%"
"""The allowance for which each class is told."""
COLUMNS = {"4": "r_arm", "-4": "l_arm"}
LIMBS = {"lower_arm": "forearm", "upper_arm": "upper_arm"}


def said(element: ElementTree.Element, name: str) -> str:
    return next((it.text or "").strip() for it in element.iter() if it.tag.endswith(f"}}{name}"))


def lnd(path: Path) -> str:
    """Return a score as LND: what stands at its beginning are starting positions."""
    score = ElementTree.parse(path).getroot()
    columns, symbols = dict(COLUMNS), []
    for column in (it for it in score.iter() if it.tag.endswith("}columnDefinition")):
        limbs = [(it.text or "").strip() for it in column.iter() if it.tag.endswith("}limb")]
        side = said(column, "side")[0]
        columns[said(column, "index")] = f"{side}_{LIMBS[next(filter(None, limbs))]}"
    beats = int(said(score, "beats"))
    for movement in (it for it in score.iter() if it.tag.endswith("}movement")):
        start = Fraction(said(movement, "measure")) * beats + Fraction(said(movement, "beat"))
        stop = start + Fraction(said(movement, "duration")) if start else start
        flat = said(movement, "horizontal").replace("middle", "place").replace("backward", "back")
        where = f"{flat.replace('-', '_')} {said(movement, 'vertical')}"
        symbols.append((columns[said(movement, "column")], start, stop, where))
    return "\n".join(
        f"direction {part} {where} {float(start):g} {float(stop):g}"
        for part, start, stop, where in sorted(symbols)
    )


def f1(got: set[int], wanted: set[int]) -> float:
    return 2 * len(got & wanted) / (len(got) + len(wanted))


def speed(count: int = 400_000) -> None:
    """Print how long the best fifty hits take, and all."""
    roster, columns = synthetic.columns(count, parts=["r_arm"])
    print(f"{len(columns['r_arm'])} symbols of one part")
    bounds, cells = columns["r_arm"].bounds.tolist(), columns["r_arm"].cell.tobytes()
    captures = [cells[begin:end] for begin, end in pairwise(bounds)]
    taken = []
    for _ in range(6):
        begin = process_time()
        process.cdist([cells[:3]], captures, scorer=Levenshtein.distance)
        taken.append((process_time() - begin) * 1e3)
    print(f"rapidfuzz {median(taken[1:]):.1f} ms")
    for text in TIMED:
        query, said = parse(text), []
        for best, times in ((50, 6), (None, 1)):
            taken = []
            for _ in range(times):
                begin = process_time()
                allowance = fuzzy.Allowance.read("2")
                finder = Finder(query, roster, columns, lambda *_: [])
                found = fuzzy.find(finder, allowance, best=best)
                taken.append((process_time() - begin) * 1e3)
            said.append(f"{len(found)} hits {median(taken[1:] or taken):.1f} ms")
        print(f"{text}  best {said[0]}  all {said[1]}", flush=True)


def finder_of(recordings: Sequence[tuple[Capture, Mapping[str, Track]]]) -> Callable[..., Finder]:
    """Return what makes of a pattern its finder in some captures."""
    captures, tracks = zip(*recordings, strict=True)
    roster = roster_of(captures)
    columns = {part: columns_of(part, captures, [it.get(part) for it in tracks]) for part in PARTS}
    taken = lambda places, parts: [recordings[it] for it in places]  # noqa: E731
    return lambda query: Finder(query, roster, columns, taken)


def main() -> None:
    recordings, drawn, labels = [], [], []
    for number, path in enumerate(sorted((CAPTURES / "bvh" / "mae_openni").rglob("*.bvh"))):
        score = encode(read(path))
        capture = Capture(number, str(path), "bvh", "", "", score.rate, score.frames)
        recordings.append((capture, score.tracks))
        labels.append(path.parent.name)
    paths = sorted((CAPTURES / "laban" / "mae").rglob("*.laban"))
    queries = defaultdict(list)
    for number, path in enumerate(paths):
        score, query = read_score(str(path)), parse(lnd(path))
        capture = Capture(number, str(path), "mae", "", "", score.rate, score.frames)
        drawn.append((capture, score.tracks))
        queries[path.parent.name].append(query)
    print(f"{len(recordings)} clips, {len(paths)} scores, {len(queries)} classes")
    finder, in_scores = finder_of(recordings), finder_of(drawn)
    wanted = {name: {it for it, label in enumerate(labels) if label == name} for name in queries}
    contained = {}
    for name, some in queries.items():
        places = {it for query in some for it in in_scores(query).find().place.tolist()}
        others = {paths[it].parent.name for it in places} - {name}
        contained[name] = {it for it, label in enumerate(labels) if label in others}
    ways = {"exact": lambda query: finder(query).find()}
    for allowed in ALLOWED:
        allowance = fuzzy.Allowance.read(allowed)
        ways[f"--fuzzy {allowed}"] = lambda query, given=allowance: fuzzy.find(finder(query), given)
    for way, find in ways.items():
        found = {
            name: {it for query in queries[name] for it in find(query).place.tolist()}
            for name in queries
        }
        every = {name: f1(found[name], wanted[name]) for name in queries}
        excused = {name: f1(found[name] - contained[name], wanted[name]) for name in queries}
        print(f"{way:12}  {mean(every.values()):.3f}  {mean(excused.values()):.3f}", flush=True)
        if way.endswith(f" {TOLD}"):
            for name in queries:
                wrong = Counter(labels[it] for it in found[name] - contained[name] - wanted[name])
                missed = len(wanted[name] - found[name])
                print(
                    f"    {name:10}  {every[name]:.2f}  {excused[name]:.2f}  {missed} missed",
                    end="",
                )
                print(*(f", {count} {label}" for label, count in wrong.items()), sep="")
    speed()


if __name__ == "__main__":
    main()
