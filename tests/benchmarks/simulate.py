"""What a search would take on up to 1,000 machines and 10 billion symbols, from measured costs.

    python tests/benchmarks/simulate.py [--symbols 10e9] [--seed 1] [--most 1000]

No such cluster is at hand: the costs in `MEASURED` were measured on one machine (how, is said
beside each), those in `ASSUMED` are not measured, and everything in between is simulated. The
order of events is that of `lanindex.pipeline.cluster`: the client cuts the library, gives twice as
many tasks as it has, the scheduler passes them on one by one, workers open the library, read the
columns of their shard and search it, and the client joins the tables as they come, in order.
"""

from __future__ import annotations

import argparse
import heapq
from dataclasses import dataclass

import numpy as np

from lanindex.pipeline.shards import MOST

MEASURED = {
    # tests/benchmarks/synthetic.py, 100,000 captures of 22.3 million symbols; seconds of CPU
    "cut the library, a million captures": 0.10,  # shards.cut, r_arm, 8 shards: 10 ms
    "cut it again, a million captures": 0.025,  # the next time: 2.5 ms
    "search, a million symbols": 0.0009,  # "r_arm right mid -> high", warm: 20 ms
    "hard search, a million symbols": 0.044,  # "r_arm any -> l_arm any -> r_leg any": .98 s
    "read and check columns, a million symbols": 0.0025,  # cold: 77 ms, warm: 20
    "a shard beside its symbols": 0.010,  # 64 shards: .73 s in all
    "join a table": 0.0008,  # the rest of 64 shards: 78 ms, of 8: 18
    "join a million hits": 0.4,  # of the client in all, 62,000 hits: 65 ms, 625,000: 280
    "bytes of a hit": 84,  # 1.04 MB of 12,364 hits
    "hits, a million symbols": 560,
    "bytes of columns, a million symbols": 0.5e6,  # of the parts of one pattern, in a file
    "open the library": 0.013,  # PostgreSQL on a socket, of which the server works some 5 ms
    "a task of Dask": 0.0012,  # client and scheduler, 3,000 empty tasks
}

ASSUMED = {
    "threads of a machine": 8,
    "network of a machine, bytes a second": 1.25e9,
    "the database's network, bytes a second": 1.25e9,
    "a bucket's network, bytes a second": 50e9,
    "connections that the database opens at once": 16,
    "tasks for each thread": 4,  # cluster.TASKS
    "spread of a task's time (sigma of its logarithm)": 0.3,
    "machines that are slow": 0.01,
    "how much slower they are": 4.0,
    "symbols of a capture": 222,
}


@dataclass
class Case:
    """A search: how large, on how many machines, and where the columns are.

    Held columns are those of a second search by the same client.
    """

    symbols: float
    machines: int
    columns: str  # held: in the workers' memory; bucket; database
    hard: bool = False


def simulate(
    case: Case, random: np.random.Generator, most: float = MOST
) -> tuple[float, dict[str, float]]:
    """Return the seconds of a search, and those for which each stage keeps all others waiting."""
    cost, guess = MEASURED, ASSUMED
    millions = case.symbols / 1e6
    threads = int(case.machines * guess["threads of a machine"])
    tasks = int(min(most, threads * guess["tasks for each thread"]))
    shard, busy = millions / tasks, min(threads, tasks)
    cutting = "cut it again" if case.columns == "held" else "cut the library"
    cut = millions / guess["symbols of a capture"] * cost[f"{cutting}, a million captures"]

    slow = random.random(case.machines) < guess["machines that are slow"]
    pace = np.where(slow, guess["how much slower they are"], 1.0)
    word = "hard search" if case.hard else "search"
    work = cost["a shard beside its symbols"] + shard * cost[f"{word}, a million symbols"]
    first = 0.0
    if case.columns != "held":
        size = millions * cost["bytes of columns, a million symbols"]
        shared = "a bucket's" if case.columns == "bucket" else "the database's"
        ways = guess[f"{shared} network, bytes a second"]
        ways = min(ways, case.machines * guess["network of a machine, bytes a second"])
        work += shard * cost["read and check columns, a million symbols"]
        work += size / tasks / (ways / busy)
        # All machines come at once; the server opens so many connections side by side
        at_once = guess["connections that the database opens at once"]
        first = cost["open the library"] * np.ceil(busy / at_once)

    spread = guess["spread of a task's time (sigma of its logarithm)"]
    times = work * np.exp(random.normal(0, spread, tasks))
    hits = shard * cost["hits, a million symbols"]
    join = cost["join a table"] + hits / 1e6 * cost["join a million hits"]
    join += hits * cost["bytes of a hit"] / guess["network of a machine, bytes a second"]

    free = [(cut + first, int(it) % case.machines) for it in range(threads)]
    heapq.heapify(free)
    given, done = cut, np.empty(tasks)
    for task in range(tasks):
        given += cost["a task of Dask"]  # client and scheduler give one after the other
        at, machine = heapq.heappop(free)
        done[task] = max(at, given) + times[task] * pace[machine]
        heapq.heappush(free, (done[task], machine))
    joined = cut
    for end in done:  # in order
        joined = max(joined, float(end)) + join
    stages = {
        "cutting": cut,
        "connections": first,
        "giving out tasks": tasks * cost["a task of Dask"],
        "workers": float(times.sum()) / busy,
        "joining": tasks * join,
    }
    return joined, stages


def main() -> None:
    """Print the table of the README."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    parser.add_argument("--symbols", type=float, default=10e9)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--most", type=float, default=MOST, help="shards at the most")
    asked = parser.parse_args()
    print("| columns | search | machines | seconds | beside one machine | what takes longest |")
    print("|---|---|---|---|---|---|")
    for columns in ("held", "bucket", "database"):
        for hard in (False, True):
            alone = 0.0
            for machines in (1, 10, 100, 1000):
                case = Case(asked.symbols, machines, columns, hard)
                random = np.random.default_rng(asked.seed)
                seconds, stages = simulate(case, random, asked.most)
                alone = alone or seconds
                most = max(stages, key=lambda name: stages[name])
                kind = "hard" if hard else "plain"
                gain = f"{alone / seconds:.1f}"
                cells = (columns, kind, f"{machines:,}", f"{seconds:.1f}", gain)
                print(f"| {' | '.join(cells)} | {most}: {stages[most]:.1f} s |")


if __name__ == "__main__":
    main()
