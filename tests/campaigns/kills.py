"""Kill the program at any moment: what it has said is done is there, nothing is half there.

A verb is run in a process that is killed (``kill -9``) before one of its system calls, mostly one
that writes. Then ``db check`` finds nothing, each capture is whole or absent, all that the command
had printed is in the library, searches find what they find in a library that is made anew, and the
same command, given again, ends well; one in four times it is killed once more before.
"""

from __future__ import annotations

import csv
import hashlib
import os
import shutil
import sqlite3
import sys
import tempfile
from collections.abc import Callable
from contextlib import chdir, closing
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from random import Random
from typing import Any
from unittest import mock

import common
import schemas
from common import called, errors_of
from schemas import Schemas

from lanindex.encoding.profile import load
from lanindex.errors import AbsentError, LibraryError, LibraryVersionError
from lanindex.library import cache, migrate
from lanindex.pipeline.library import Library

LIBRARY, JOURNAL, COLUMNS = "some.db", "some.db-journal", "some.db-columns"
PATTERNS = ("r_arm low -> mid", "r_arm any with l_arm high", "l_arm right ... low", "arms back")
DUMP = common.TESTS / "library" / "revision_0001.sql"

Held = tuple[str, str, str, tuple[tuple[str, str], ...]]
"""Of a capture the sha256, the digest of its profile, its label and its metadata."""

State = dict[str, Held]
"""What is in a library, by the path of the file."""

FILES = common.files(24, 6)
SHA256 = [hashlib.sha256(content).hexdigest() for _, content in FILES]
DIGESTS = {name: load(name).digest for name in ("default", "paper")}
ANSWERS: dict[tuple[str, str], Any] = {}
"""What a library that nothing has happened to says of each file, by sha256 and profile."""

EMPTY = "this file is empty", "there is no library here"

SCHEMAS: Schemas | None = None
"""Where libraries are, if they are no files."""

OLD = Path()
"""A library of the first revision."""

BEFORE: State = {"": ("", "", "", ())}
AFTER: State = {}
"""What stands for what it holds, and what it holds after an upgrade."""


def dumped(place: str | Path) -> list[str]:
    """Return all that an SQLite library holds, as SQL."""
    with closing(sqlite3.connect(place)) as connection:
        return list(connection.iterdump())


def answers(named: str | Path) -> dict[str, tuple[Held, Any]]:
    """Return what a library says of each capture, by its path: of its rows and of its columns."""
    with Library.open(named, readonly=True) as library:
        known, told = library.store.known(), {}
        found: dict[int, list[Any]] = {}
        for pattern in PATTERNS:
            for hit in library.search(pattern):
                found.setdefault(hit.capture.id, []).append((pattern, hit.span, round(hit.fit, 6)))
        for capture, tracks in library.tracks():
            sha256, encoding = known[capture.location]
            score = library.score(capture.id)
            rows = {part: (one.symbols.tolist(), one.known) for part, one in tracks.items()}
            facts = capture.frames, capture.rate, score.heading.tolist(), score.other
            held = sha256, encoding.digest, capture.label, tuple(sorted(capture.metadata.items()))
            told[capture.location] = held, (facts, rows, found.get(capture.id, []))
        assert library.stats().captures == len(told) == len(known)
    return told


@dataclass
class Verb:
    """What is done in a scene that is prepared for it, and what the library may be meanwhile.

    The first of `steps` is what it was before, each other one what it is while a line is made that
    the command then prints; the last state of a step is what its line says.
    """

    work: Callable[[int], int]  # Given where to print
    steps: list[list[State]]
    ends: tuple[int, ...] = (0,)  # Codes with which it ends well, given once more, too
    prints: bool = False

    @property
    def states(self) -> list[State]:
        return [state for step in self.steps for state in step]

    def said(self, lines: int) -> int:
        """Return the place in `states` of what so many lines say."""
        return sum(map(len, self.steps[: lines + 1])) - 1


class Scene:
    """A folder of files, and a library that holds some."""

    def __init__(self, choice: Random, folder: Path) -> None:
        self.choice, self.folder = choice, folder
        self.files: dict[str, int] = {}
        self.spare = choice.sample(range(len(FILES)), len(FILES))
        self.held: State = {}
        self.profile = choice.choice(("default", "paper"))
        self.in_files = choice.random() < 0.3 and not SCHEMAS
        (folder / "in").mkdir()

    def put(self, before: str = "") -> None:
        """Write a file: in place of one, if it has the same ending, or a new one."""
        number = self.spare.pop()
        ending, content = FILES[number]
        name = before if before.endswith(ending) else self.new_name(ending)
        self.files[name] = number
        Path("in", name).write_bytes(content)

    def new_name(self, ending: str) -> str:
        return f"{self.choice.choice('abcdefghij')}{self.choice.randrange(10_000):04}{ending}"

    def move(self, name: str) -> None:
        after = self.new_name(Path(name).suffix)
        Path("in", name).rename(Path("in", after))
        self.files[after] = self.files.pop(name)

    def fill(self) -> None:
        """Ingest some files, then others, so that there are several segments."""
        for _ in range(self.choice.randint(1, 3)):
            for _ in range(self.choice.randint(1, 3)):
                self.put()
            verb = self.ingest()
            assert printing(verb) == 0, errors_of()
            self.held = verb.states[-1]
            if self.in_files:
                assert called("db", "segments", COLUMNS, "--db", LIBRARY) == 0

    def ingest(self, *how: str | int) -> Verb:
        """Return an ingest of all files that there are, and what it does file by file."""
        words: list[Any] = ["ingest", "in", "--json", *(how or ("--jobs", 1))]
        words += ["--profile", self.profile]
        table: dict[str, tuple[str, str]] = {}
        if self.choice.random() < 0.6:
            table = self.label()
            words += ["--labels", "labels.csv"]
        state, steps = self.held, [[self.held]]
        gone = {held[:2]: place for place, held in state.items() if not Path(place).exists()}
        for name, number in sorted(self.files.items()):
            place, step = str(self.folder / "in" / name), list[State]()
            new = SHA256[number], "" if name.endswith(".lnd") else DIGESTS[self.profile]
            if place not in state and new in gone:
                before = gone.pop(new)
                state = {place if it == before else it: held for it, held in state.items()}
                step.append(state)
            _, _, label, metadata = state.get(place, ("", "", "", ()))
            if name in table:
                label = table[name][0] or label
                metadata = (("who", table[name][1]),) if table[name][1] else metadata
            state = state | {place: (*new, label, metadata)}
            steps.append([*step, state])
        return Verb(partial(called, *words, "--db", LIBRARY), steps, prints=True)

    def label(self) -> dict[str, tuple[str, str]]:
        """Write a table that says something of some files, and return it."""
        names = self.choice.sample(sorted(self.files), self.choice.randint(1, len(self.files)))
        labels, people = ("", "walk", "bow", "wave"), ("", "Ada", "Rudolf")
        table = {name: (self.choice.choice(labels), self.choice.choice(people)) for name in names}
        with open("labels.csv", "w", newline="") as file:
            rows = [(f"in/{name}", *row) for name, row in table.items()]
            csv.writer(file).writerows([("file", "label", "who"), *rows])
        return table

    def without_columns(self, *more: str) -> None:
        """Make the columns of no use, in one of several ways."""
        changes = (
            *more,
            "UPDATE state SET columns = -1",
            "UPDATE segment SET listing = 'x'",
            "DELETE FROM segment_column; DELETE FROM segment; DELETE FROM segment_dead; "
            "INSERT INTO segment_pending SELECT id FROM capture WHERE true ON CONFLICT DO NOTHING",
        )
        sql(LIBRARY, self.choice.choice(changes))


def sql(path: str | Path, script: str) -> None:
    if SCHEMAS:
        return SCHEMAS.run(script, path)
    with closing(sqlite3.connect(path)) as connection, connection:
        connection.executescript(script)


def printing(verb: Verb, end: Callable[[Callable[[], int]], Any] = lambda work: work()) -> Any:
    """Run a verb, which prints into a file, in this process or as `end` does."""
    with open("printed", "w") as lines:
        return end(lambda: verb.work(lines=lines.fileno()))


def first_ingest(scene: Scene) -> Verb:
    for _ in range(scene.choice.randint(1, 5)):
        scene.put()
    return scene.ingest()


def later_ingest(scene: Scene) -> Verb:
    scene.fill()
    for name in list(scene.files):
        if scene.choice.random() < 0.3:
            scene.put(name)
    for _ in range(scene.choice.randint(0, 3)):
        scene.put()
    return scene.ingest("--jobs", 2 if scene.choice.random() < 0.05 else 1)


def move(scene: Scene) -> Verb:
    scene.fill()
    for name in list(scene.files):
        if scene.choice.random() < 0.7:
            scene.move(name)
    return scene.ingest()


def write_anew(scene: Scene) -> Verb:
    """Ingest the same files with another profile."""
    scene.fill()
    scene.profile = "paper" if scene.profile == "default" else "default"
    return scene.ingest()


def label(scene: Scene) -> Verb:
    """Label many captures at once, as the page does."""
    scene.fill()
    after = {
        place: (*held[:2], "said", (("who", "Ida"),)) if scene.choice.random() < 0.7 else held
        for place, held in scene.held.items()
    }

    def work(lines: int) -> int:
        with Library.open(LIBRARY) as library:
            library.store.describe((place, it[2], dict(it[3])) for place, it in after.items())
        return 0

    return Verb(work, [[scene.held], [after]])


def remove(scene: Scene) -> Verb:
    scene.fill()
    for name in scene.choice.sample(sorted(scene.files), scene.choice.randint(1, len(scene.files))):
        Path("in", name).unlink()
        del scene.files[name]
    after = {place: held for place, held in scene.held.items() if Path(place).exists()}
    work = partial(called, "remove", "--missing", "--db", LIBRARY)
    return Verb(work, [[scene.held], [after]], ends=(0, 1))  # 1: nothing is missing any more


def search(scene: Scene) -> Verb:
    """Search a library of which the columns must be written first."""
    scene.fill()
    scene.without_columns()
    return Verb(partial(called, "search", "arms any", "--db", LIBRARY), [[scene.held]], ends=(0, 1))


def join(scene: Scene) -> Verb:
    """Ingest what is there already, which writes segments, and joins them."""
    scene.fill()
    scene.without_columns()
    return scene.ingest()


def mend(scene: Scene) -> Verb:
    """Have columns and the view made anew."""
    scene.fill()
    scene.without_columns("DELETE FROM segment_column WHERE name = 'cell'")
    sql(LIBRARY, "DROP VIEW symbol")
    return Verb(partial(called, "db", "upgrade", "--db", LIBRARY), [[scene.held]])


def segments(scene: Scene) -> Verb:
    """Move the columns into files, or back."""
    scene.fill()
    where = scene.choice.choice((COLUMNS, "other", "--inside"))
    return Verb(partial(called, "db", "segments", where, "--db", LIBRARY), [[scene.held]])


def upgrade(scene: Scene) -> Verb:
    """Bring a library of the first revision to the newest."""
    shutil.copy(OLD, LIBRARY)
    return Verb(partial(called, "db", "upgrade", "--db", LIBRARY), [[BEFORE], [AFTER]])


VERBS = (
    *(first_ingest, first_ingest, later_ingest, later_ingest, later_ingest, move, move),
    *(write_anew, label, label, remove, remove, search, join, join, mend, segments, segments),
    *(upgrade, upgrade),
)


OF_FILES = segments, upgrade
"""What is about files, or about a revision that no other database has had."""


def look() -> tuple[State, list[str]]:
    """Return what is in the library, and what ``db check`` says of it.

    A copy is looked at, with its journal, for a look undoes what was broken off, and mends columns.
    """
    if SCHEMAS:
        SCHEMAS.wait(LIBRARY)
        with mock.patch.object(cache.ColumnCache, "_mend", return_value=None):
            wrong = faults(LIBRARY)
            return content(LIBRARY), wrong
    with tempfile.TemporaryDirectory(dir=".") as name:
        for path in (Path(LIBRARY), Path(JOURNAL)):
            if path.exists():
                shutil.copy(path, name)
        for folder in (COLUMNS, "other"):
            if os.path.exists(folder):
                shutil.copytree(folder, f"{name}/{folder}")
        place = f"{name}/{LIBRARY}"
        wrong = faults(place)
        return content(place), wrong


def content(place: str) -> State:
    """Return what is in a library, if all its answers are those of one that was made anew."""
    if not (SCHEMAS or os.path.exists(place)):
        return {}
    try:
        told = answers(place)
    except LibraryVersionError:
        assert dumped(place) == dumped(OLD)
        return BEFORE
    except LibraryError as error:
        if not any(words in str(error) for words in EMPTY):
            raise
        return {}
    for held, answer in told.values():
        assert answer == ANSWERS[held[:2]]
    return {place: held for place, (held, _) in told.items()}


def faults(place: str) -> list[str]:
    try:
        return migrate.check(place)
    except (AbsentError, LibraryVersionError):
        return []
    except LibraryError as error:
        return [] if any(words in str(error) for words in EMPTY) else [str(error)]


def trial(choice: Random, folder: Path) -> dict[str, int]:
    """Kill a verb once or twice, and look at what is left."""
    cache.CHUNK, cache.MOST_PENDING = choice.choice((1, 40, 1 << 20)), choice.choice((0, 256))
    make = choice.choice([one for one in VERBS if not (SCHEMAS and one in OF_FILES)])
    begun = choice.getstate()
    verb = make(Scene(choice, folder))
    states, wrong_before = verb.states, look()[1]
    shutil.copytree(folder, kept := folder.with_name(f"{folder.name}-kept"))
    try:
        writes = choice.random() < 0.7
        code, calls = killed(verb, writes=writes)
        assert code in verb.ends, (code, errors_of())
        assert look() == (states[-1], []), (make.__name__, look(), states[-1])
        Path(LIBRARY).unlink(missing_ok=True)
        for name in (COLUMNS, "other"):
            shutil.rmtree(name, ignore_errors=True)
        if SCHEMAS:  # a library cannot be copied as a file can: it is made once more
            SCHEMAS.drop(LIBRARY)
            after = Random()
            after.setstate(begun)
            shutil.rmtree("in")
            verb = make(Scene(after, folder))
        else:
            shutil.copytree(kept, folder, dirs_exist_ok=True)
    finally:
        shutil.rmtree(kept)
    least = kills = 0
    for _ in range(choice.choice((1, 1, 1, 2))):
        code, _ = killed(verb, choice.randint(1, calls or 1), writes=writes)
        kills += code == -9
        said = Path("printed").read_text().count("\n") if verb.prints else 0
        most = max(least, verb.said(said + 1))
        least = max(least, verb.said(said)) if code == -9 else len(states) - 1
        held, wrong = look()
        may = [at for at in range(least, most + 1) if states[at] == held]
        assert may, (make.__name__, said, held, states)
        assert {*wrong} <= {*wrong_before}
        least = may[0]
    code, _ = killed(verb)
    assert code in verb.ends, (code, errors_of())
    assert look() == (states[-1], [])
    left = {it.name for it in folder.iterdir()}
    left -= {LIBRARY, "in", "labels.csv", "stdout", "stderr", "printed", COLUMNS, "other"}
    # a journal that was left goes with the next change; if it begins with zeros, it is none
    assert left <= {JOURNAL}, left
    assert JOURNAL not in left or not any(Path(JOURNAL).read_bytes()[:8])
    if SCHEMAS:
        SCHEMAS.drop(LIBRARY)
    else:
        check_files()
    return {"kills": kills, make.__name__.replace("_", " "): 1}


def check_files() -> None:
    """Check that in an hour all files of columns are gone that no segment names."""
    place, _, _ = migrate.files_of_columns(LIBRARY)
    files = [it for it in Path(place).iterdir() if place]
    for file in files:
        os.utime(file, (0, 0))
    with Library.open(LIBRARY) as library:
        library.store.cache._mend("")
    with closing(sqlite3.connect(LIBRARY)) as connection:
        named = {name for (name,) in connection.execute("SELECT file FROM segment")}
    assert {it.name for it in Path(place).iterdir() if place} == named - {None}


def killed(verb: Verb, last: int = 0, *, writes: bool = False) -> tuple[int, int]:
    """Run a verb, killed at a call or not at all; return how it ended, and its calls."""
    done: tuple[int, int] = printing(verb, lambda work: common.stopped(work, last, writes=writes))
    errors_of()
    return done


def main() -> int:
    global SCHEMAS
    parser = common.arguments(__doc__.split("\n")[0], 1000)
    parser.add_argument("--db", metavar=f"URL|{schemas.WORD}", help="a server for the libraries")
    options = parser.parse_args()
    with schemas.served(options.db) as SCHEMAS, tempfile.TemporaryDirectory() as name:
        with chdir(name):
            prepare(Path(name))
        return common.run(trial, options)


def prepare(folder: Path) -> None:
    """Fill what is compared with, which imports all that trials need, too."""
    global OLD, AFTER
    for number, (ending, file) in enumerate(FILES):
        (folder / f"{number}{ending}").write_bytes(file)
    for name in DIGESTS:
        library = f"{name}.db"
        assert called("ingest", folder, "--profile", name, "--jobs", 1, "--db", library) == 0
        ANSWERS.update({held[:2]: answer for held, answer in answers(library).values()})
    if SCHEMAS:
        return
    OLD = folder / "old.db"
    sql(OLD, DUMP.read_text(encoding="utf-8"))
    shutil.copy(OLD, "new.db")
    migrate.upgrade("new.db")
    new = answers("new.db")
    ANSWERS.update({held[:2]: answer for held, answer in new.values()})
    AFTER = {place: held for place, (held, _) in new.items()}


if __name__ == "__main__":
    sys.exit(main())
