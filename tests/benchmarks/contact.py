"""What it takes to look at many hits: a search, its captures read, and a sheet or page of them.

python tests/benchmarks/contact.py [LIBRARY]

Each row is a command of its own, from its start; the processor's time. Without a library the real
captures are ingested first, which takes some minutes.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from pathlib import Path

MAIN = "from lanindex.app.cli import main; main()"
PATTERN = "arm high"
RUNS = (("png", 20), ("png", 200), ("svg", 200), ("html", 200), ("html", 1000), ("png", 1000))


def called(words: list[str], folder: str, fine: tuple[int, ...] = (0,)) -> tuple[float, float]:
    """Run a command; return the seconds of the processor, and the megabytes it took at most."""
    process = subprocess.Popen([sys.executable, "-c", MAIN, *words], cwd=folder)
    _, status, used = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    assert process.returncode in fine, words
    return used.ru_utime + used.ru_stime, used.ru_maxrss / 1024


def main() -> None:
    """Print all."""
    with tempfile.TemporaryDirectory() as folder:
        library = Path(sys.argv[1]).resolve() if sys.argv[1:] else Path(folder) / "real.db"
        if not library.exists():
            words = ["ingest", os.environ["LANINDEX_CAPTURES"], "-q", "--db", str(library)]
            called(words, folder, (0, 2))  # some files there are no captures: the rest is in
        print("form  hits  seconds  peak MB  kB  files")
        for form, hits in RUNS:
            name = f"{form}{hits}.{form}"
            words = ["search", PATTERN, "--overlaps", "all", "--preview", name, "-q"]
            spent, peak = called([*words, "--limit", str(hits), "--db", str(library)], folder)
            files = [*Path(folder).glob(f"{form}{hits}*.{form}")]
            size = sum(file.stat().st_size for file in files) / 1000
            print(f"{form:4}  {hits:4}  {spent:7.1f}  {peak:7.0f}  {size:,.0f}  {len(files)}")


if __name__ == "__main__":
    main()
