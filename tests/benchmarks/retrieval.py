"""How well the eight patterns of bandai2.toml tell the labelled clips apart, by profile.

LANINDEX_CAPTURES=... python tests/benchmarks/retrieval.py
"""

import os
import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).parent
DEFAULT = HERE.parents[2] / "shared" / "captures"


def main() -> None:
    captures = Path(os.environ.get("LANINDEX_CAPTURES", DEFAULT))
    for profile in ("default", "paper"):
        print(f"profile {profile}")
        subprocess.run(
            [
                sys.executable,
                "-c",
                "from lanindex.app.cli import main; main()",
                "evaluate",
                str(captures / "bvh" / "bandai2"),
                "--labels",
                str(captures / "labels.csv"),
                "--patterns",
                str(HERE / "bandai2.toml"),
                "--profile",
                profile,
                "--misses",
            ],
            check=True,
        )


if __name__ == "__main__":
    main()
