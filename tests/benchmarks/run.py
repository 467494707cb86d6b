"""Run the benchmarks, one after the other: ``python tests/benchmarks/run.py [NAME ...]``.

Without names it runs all that need nothing besides `LANINDEX_CAPTURES`; README.md says which do.
The machine is printed first, and the benchmarks that failed are printed last. All take several
hours on two cores; leave the machine alone meanwhile.
"""

import os
import platform
import subprocess
import sys
import tempfile
from importlib.metadata import version
from pathlib import Path

HERE = Path(__file__).parent
LEFT_OUT = ("blender", "suite", "synthetic", "run")
"""Two that need Blender and LabanotationSuite's scores, what makes libraries for others, this."""


def processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        return platform.processor()
    return next((line.split(":")[1].strip() for line in lines if "model name" in line), "?")


def benchmarks() -> list[str]:
    """Return the names of the scripts that need no arguments, or a folder to work in at most."""
    scripts = sorted(path for path in HERE.glob("*.py") if path.stem not in LEFT_OUT)
    return [path.stem for path in scripts if '__name__ == "__main__"' in path.read_text("utf-8")]


def main(names: list[str]) -> int:
    packages = ("numpy", "numba", "sqlalchemy", "typer", "pybvh")
    print(f"{processor()}, {os.cpu_count()} cores; Python {platform.python_version()}")
    print(", ".join(f"{name} {version(name)}" for name in packages))
    failed = []
    with tempfile.TemporaryDirectory() as folder:
        for name in names or benchmarks():
            print(f"\n== {name}", flush=True)
            arguments = [folder] if name == "verbs" else []
            command = [sys.executable, str(HERE / f"{name}.py"), *arguments]
            if subprocess.run(command, check=False).returncode:
                failed.append(name)
    if failed:
        print(f"\nfailed: {', '.join(failed)}")
    return len(failed)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
