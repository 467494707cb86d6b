"""How long a data set takes, and how much memory: of more and more clips, and of longer captures.

python tests/benchmarks/datasets.py
"""

from __future__ import annotations

import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from made import captures

MADE = ((10, 5), (100, 5), (1000, 5), (2, 60), (2, 600))
"""How many captures, and how many seconds each lasts."""


def work(folder: str, layout: str) -> None:
    """Write a data set and print what it cost."""
    from lanindex.pipeline.library import open_library

    with open_library(f"{folder}/l.db", readonly=True) as library:
        began = time.process_time()
        hits = library.search("r_arm any")
        card = library.dataset({"moves": hits}, f"{folder}/{layout}", layout=layout)
        spent = time.process_time() - began
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss // 1024
    size = sum(path.stat().st_size for path in Path(folder, layout).rglob("*") if path.is_file())
    print(f"{layout:10} {card['clips']:6} clips, {card['hours'] * 3600:6.0f} s,", end=" ")
    print(f"{spent:6.2f} s of CPU, {spent / card['clips'] * 1000:5.2f} ms a clip,", end=" ")
    print(f"{size / 1e6:6.1f} MB written, peak {peak} MB", flush=True)


def main() -> None:
    """Print all, each in a process of its own."""
    if len(sys.argv) > 1:
        work(*sys.argv[1:])
        return
    from lanindex.pipeline.library import open_library

    for count, seconds in MADE:
        with tempfile.TemporaryDirectory() as folder:
            paths = captures(Path(folder), count, seconds)
            with open_library(f"{folder}/l.db", create=True) as library:
                library.ingest(paths)
            print(f"{count} captures of {seconds} s", flush=True)
            for layout in ("npz", "humanml3d"):
                subprocess.run([sys.executable, __file__, folder, layout], check=True)


if __name__ == "__main__":
    main()
