"""How long the command takes to start, against what it must import anyway.

    python tests/benchmarks/startup.py

Pairs of processes in turn; the median of their ratios.
"""

import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from statistics import median

sys.path.insert(0, str(Path(__file__).parents[1]))
from dances import dance

ROUNDS = 21
RUN = "from lanindex.app.cli import main; main()"


ENVIRONMENT = {key: value for key, value in os.environ.items() if key != "PYTHONDONTWRITEBYTECODE"}
"""Users' modules are compiled once, so they are here."""


def timed(*words: str) -> float:
    begun = time.perf_counter()
    subprocess.run([sys.executable, *words], check=True, capture_output=True, env=ENVIRONMENT)
    return time.perf_counter() - begun


def compare(name: str, words: list[str], baseline: str, limit: float) -> None:
    ratios, times = [], []
    for _ in range(ROUNDS):
        ours, theirs = timed(*words), timed("-c", baseline)
        ratios.append(ours / theirs)
        times.append(ours)
    print(
        f"{name:28} {median(times) * 1000:5.0f} ms, {median(ratios):.2f} x `{baseline}` "
        f"(wanted <= {limit})"
    )


def main() -> None:
    with tempfile.TemporaryDirectory() as folder:
        db = str(Path(folder) / "l.db")
        dance(Path(folder) / "a.bvh")
        timed("-c", RUN, "ingest", folder, "--db", db)
        compare("lanindex --help", ["-c", RUN, "--help"], "import typer", 1.5)
        search = ["-c", RUN, "search", "r_arm right mid -> high", "--db", db]
        compare("lanindex search", search, "import numpy, sqlalchemy, typer", 1.3)


if __name__ == "__main__":
    main()
