"""Run all benchmarks, one after the other: ``python tests/benchmarks/run.py``.

Says the machine first. About an hour on two cores; leave the machine alone meanwhile.
"""

import os
import platform
import subprocess
import sys
from importlib.metadata import version
from pathlib import Path

HERE = Path(__file__).parent
ALL = (
    *(
        "startup",
        "read_speed",
        "encode_speed",
        "ingest_speed",
        "first_ingest",
        "memory",
        "columns",
        "retrieval",
    ),
    *("fuzzy", "laws", "performers", "dictionary", "example", "search", "peers", "agreement"),
)


def processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        return platform.processor()
    return next((line.split(":")[1].strip() for line in lines if "model name" in line), "?")


def main() -> None:
    packages = ("numpy", "numba", "sqlalchemy", "typer", "pybvh")
    print(f"{processor()}, {os.cpu_count()} cores; Python {platform.python_version()}")
    print(", ".join(f"{name} {version(name)}" for name in packages))
    for name in ALL:
        print(f"\n== {name}", flush=True)
        subprocess.run([sys.executable, str(HERE / f"{name}.py")], check=True)


if __name__ == "__main__":
    main()
