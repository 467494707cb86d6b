"""How much memory a large capture takes, verb by verb.

    python tests/benchmarks/memory.py [MEGABYTES ...] [--digits N ...] [--few MEGABYTES ...]

Makes a BVH file of each size (50 and 500) for each number of decimals (0, about 170 bytes a frame,
and 6, some 500): a minute's dance of the standard body that goes round and drifts. So it does with
3 decimals of `FEW` joints' channels alone (300: 2.0 million frames of 150 bytes). Runs each verb on
it in a process of its own and prints the largest memory that it held, and the processor's seconds.
"""

import argparse
import json
import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from made import captures

SECONDS = 60
FEW = ("Hips", *(f"{side}{it}" for side in ("Left", "Right") for it in ("Arm", "UpLeg")), "Spine")
"""Joints that turn in files with few channels."""
RUN = (sys.executable, "-c", "from lanindex.app.cli import main; main()")


def enlarge(
    source: Path, target: Path, megabytes: float, decimals: int, rate: int, few: bool
) -> int:
    """Write the frames of a BVH file round and round, with a drift, and return how many."""
    head, _, frames = source.read_text().partition("MOTION\n")
    values = np.array([line.split() for line in frames.splitlines()[2:]], float)
    if few:
        head, kept = thinned(head)
        values = values[:, kept]
    values += np.random.default_rng(0).normal(0, 0.3, values.shape)
    values = values.round(decimals) + 0.0  # no -0
    number = f"%.{decimals}f"
    lines = [" ".join(number % value for value in row) for row in values.tolist()]
    each = sum(map(len, lines)) / len(lines) + 1
    count = int(megabytes * 1e6 / each)
    with target.open("w") as file:
        file.write(f"{head}MOTION\nFrames: {count}\nFrame Time: {1 / rate:.7f}\n")
        for start in range(0, count, len(lines)):
            part = lines[: count - start]
            drift = f"{number} " % (start / 1000)
            file.write("".join(f"{drift}{line.partition(' ')[2]}\n" for line in part))
    return count


def thinned(head: str) -> tuple[str, list[int]]:
    """Return a hierarchy in which few joints have channels, and which columns stay."""
    lines, kept, joint, column = list[str](), list[int](), "", 0
    for line in head.splitlines():
        if named := re.match(r"\s*(?:ROOT|JOINT) (\S+)", line):
            joint = named[1]
        if told := re.match(r"(\s*CHANNELS) (\d+)", line):
            columns = range(column, column + int(told[2]))
            column = columns.stop
            line = line if joint in FEW else f"{told[1]} 0"
            kept += columns if joint in FEW else ()
        lines.append(line)
    return "\n".join(lines) + "\n", kept


def peak(words: list[str], folder: Path, given: str = "") -> tuple[float, float]:
    """Run a command and return its largest memory in MB and its seconds of a processor."""
    with (
        (folder / "out").open("w") as out,
        subprocess.Popen(
            [*RUN, *words], cwd=folder, stdout=out, stdin=subprocess.PIPE, text=True
        ) as process,
    ):
        assert process.stdin is not None
        process.stdin.write(given)
        process.stdin.close()
        _, status, usage = os.wait4(process.pid, 0)
        process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode:
        print(f"  {words[0]} ended with {process.returncode}")
    return usage.ru_maxrss / 1024, usage.ru_utime + usage.ru_stime


def verbs(folder: Path, name: str, count: int) -> None:
    """Run each verb that touches the file."""
    (folder / "labels.csv").write_text(f"file,label\n{name},dance\n")
    (folder / "patterns.toml").write_text('up = {pattern = "r_arm high", positives = ["dance"]}\n')
    hit = {"capture": name, "capture_id": 1, "start_frame": count // 2, "end_frame": count // 2 + 9}
    runs = {
        "inspect": ["inspect", name],
        "convert": ["convert", name, "-o", "score.lnd", "--force"],
        "ingest": ["ingest", name],
        "evaluate": ["evaluate", ".", "--patterns", "patterns.toml", "--labels", "labels.csv"],
        "export a hit": ["export", "-", "-o", "clips"],
        "export it all": ["export", "--capture", name, "-o", "all"],
    }
    for verb, words in runs.items():
        given = json.dumps(hit) + "\n" if "-" in words[:2] else ""
        megabytes, seconds = peak(words, folder, given)
        each = f"{megabytes * 2**20 / count:5.0f} bytes a frame"
        print(f"  {verb:14} {megabytes:7.0f} MB  {each}  {seconds:6.1f} s", flush=True)


def main() -> None:
    parser = argparse.ArgumentParser()
    parser.add_argument("megabytes", nargs="*", type=float, default=[50.0, 500.0])
    parser.add_argument("--digits", nargs="*", type=int, default=[0, 6])
    parser.add_argument("--rate", type=int, default=60)
    parser.add_argument("--few", nargs="*", type=float, default=[300.0])
    told = parser.parse_args()
    files = [(it, decimals, False) for decimals in told.digits for it in told.megabytes]
    for megabytes, decimals, few in [*files, *((it, 3, True) for it in told.few)]:
        with tempfile.TemporaryDirectory() as place:
            folder, target = Path(place), Path(place) / "large.bvh"
            (dance,) = captures(folder / "made", 1, SECONDS)
            count = enlarge(dance, target, megabytes, decimals, told.rate, few)
            dance.unlink()
            size = target.stat().st_size
            print(f"{size / 1e6:.0f} MB, {count} frames of {size / count:.0f} bytes")
            verbs(folder, "large.bvh", count)


if __name__ == "__main__":
    main()
