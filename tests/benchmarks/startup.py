"""How long the command takes to start, against what it must import anyway.

    python tests/benchmarks/startup.py [LIBRARY]

Processes in turn; by the time that the processor spends on them, the median. Of a library of its
own, or of this one: `synthetic.py` makes one of any size.
"""

import os
import subprocess
import sys
import tempfile
from pathlib import Path
from statistics import median

sys.path.insert(0, str(Path(__file__).parents[1]))
from dances import dance

ROUNDS = 15
RUN = "from lanindex.app.cli import main; main()"
FLOOR = "import numpy, sqlalchemy, typer"
PATTERN = "r_arm right mid -> high"
COMMANDS = (
    ("--help",),
    ("search", PATTERN, "--limit", "5"),
    ("search", PATTERN, "--count"),
    ("search", PATTERN, "--in", "*a*", "--limit", "5"),
)
"""A search may find nothing, and exits with 1 then."""

ENVIRONMENT = {key: value for key, value in os.environ.items() if key != "PYTHONDONTWRITEBYTECODE"}
"""Users' modules are compiled once, so they are here."""


def spent(*words: str, **more: str) -> float:
    """Return the seconds that the processor spends on a process of Python."""
    begun = os.times()
    done = subprocess.run([sys.executable, *words], env=ENVIRONMENT | more, capture_output=True)
    ended = os.times()
    if done.returncode not in (0, 1):
        sys.exit(done.stderr.decode())
    return sum(ended[2:4]) - sum(begun[2:4])


def compare(db: str) -> None:
    """Say how long commands take, and a completion."""
    ways = {" ".join(words): ("-c", RUN, *words, "--db", db) for words in COMMANDS[1:]}
    ways["--help"] = ("-c", RUN, "--help")
    begun = {"_LANINDEX_COMPLETE": "complete_bash", "COMP_CWORD": "4"}
    captures = begun | {"COMP_WORDS": f"lanindex show --db {db} a"}
    parts = begun | {"COMP_WORDS": f"lanindex search --db {db} r_"}
    took: dict[str, list[float]] = {}
    for _ in range(ROUNDS):
        took.setdefault(FLOOR, []).append(spent("-c", FLOOR))
        for name, words in ways.items():
            took.setdefault(name, []).append(spent(*words))
        for name, asked in (("complete a capture", captures), ("complete a part", parts)):
            took.setdefault(name, []).append(spent("-c", RUN, **asked))
    for name, times in took.items():
        share = median(times) / median(took[FLOOR])
        print(f"{1000 * median(times):5.0f} ms, {share:.2f} x  {name}")


def main() -> None:
    if sys.argv[1:]:
        return compare(sys.argv[1])
    with tempfile.TemporaryDirectory() as folder:
        db = str(Path(folder) / "l.db")
        dance(Path(folder) / "a.bvh")
        spent("-c", RUN, "ingest", folder, "--db", db)
        compare(db)


if __name__ == "__main__":
    main()
