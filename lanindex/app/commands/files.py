"""The verbs that read files: ingest, inspect, convert, animate."""

from __future__ import annotations

import os
import time
from collections import Counter
from contextlib import nullcontext, suppress
from itertools import groupby
from pathlib import Path
from typing import TYPE_CHECKING, Any

from lanindex.app import options
from lanindex.app.options import argument, exclusive, flag, option
from lanindex.app.output import Output, duration, say_error
from lanindex.errors import LibraryError, UsageError, counted
from lanindex.pipeline.files import write_all

if TYPE_CHECKING:
    from lanindex.model import Motion
    from lanindex.pipeline.prepare import Outcome


def ingest(
    paths: list[str] = argument(..., "PATH...", "Captures, scores, folders, or their URLs."),
    jobs: options.Jobs = None,
    cluster: options.Cluster = None,
    profile: options.Profile = "default",
    labels: str | None = option(None, "CSV", "A table with columns file, label and any others."),
    *,
    reading: options.Reading,
    force: bool = flag("--force", "Read unchanged files again."),
    dry_run: bool = flag("--dry-run", "Read and say what would be done; store nothing."),
    db: options.Db = options.DB,
    out: options.Out,
) -> int:
    """Read captures and scores into the library.

    Folders are searched through; unchanged files are skipped. A file that cannot be read is
    reported, the others go in, and the exit code is 2.
    """
    from lanindex.encoding.profile import load
    from lanindex.formats import check, parted
    from lanindex.library.store import Store
    from lanindex.pipeline.ingest import check_writable, discover, ingest, read_labels, unfitting

    exclusive("--jobs", jobs, {"--cluster": cluster})
    chosen = load(profile)
    check(reading)
    others: list[str] = []
    files = list(discover(paths, others, apart=False))
    if not files:
        left_out = _left_out(others, labels, db)
        but = f", but {left_out}" if left_out else ""
        out.note(f"no capture or score in {' '.join(paths)}{but}")
        return 1
    table = {} if labels is None else read_labels(labels, files)
    jobs = _processes(out, files, jobs)
    tally, read, beside = Counter[str](), list[str](), set[str]()
    start, division = time.monotonic(), chosen.meter.division
    is_new = not os.path.exists(db)
    no_library = dry_run and is_new
    if cluster is not None and not dry_run:
        _check_writable(db, files, force=force)
    with (
        options.spread(cluster, out) as spread,  # before a library is made
        nullcontext()
        if no_library
        else Store.open(
            db, create=True, readonly=dry_run, note=out.note, progress=out.watch
        ) as store,
    ):
        if store and not dry_run:
            check_writable(store, files, force=force)
        how: dict[str, Any] = {"force": force, "dry_run": dry_run, "labels": table, "jobs": jobs}
        outcomes = ingest(store, files, chosen, reading=reading, spread=spread, **how)
        by_file = groupby(outcomes, key=lambda outcome: parted(outcome.path)[0])
        for _, of_file in out.progress(by_file, len(files), "files"):
            for outcome in of_file:
                _count(tally, outcome, division)
                _report(out, outcome)
                read.append(outcome.path)
                beside.update(outcome.beside)
    if is_new and tally["failed"] == len(read):  # an empty library would hide that it failed
        with suppress(OSError):
            os.remove(db)
    if unused := unfitting(table, read):
        out.note(f"{labels}: {unused}")
    _summary(out, tally, len(read), time.monotonic() - start, dry_run)
    if rest := _left_out(others, labels, db, *beside):
        out.note(f"left out: {rest}")
    if tally["warnings"] and not (out.verbose or out.json):
        more = "-v shows" if dry_run else "lanindex list --doubts tells"
        out.note(f"{counted(tally['warnings'], 'warning')}: {more} more")
    if tally["finer"]:
        out.detail(f"grid finer than 1/{division} of a unit: {counted(tally['finer'], 'score')}")
    return 2 if tally["failed"] else 0


def _check_writable(db: str, files: list[str], *, force: bool) -> None:
    """Refuse a library that may not be written; one that cannot be opened may have to be made."""
    from lanindex.library.store import Store
    from lanindex.pipeline.ingest import check_writable

    try:
        store = Store.open(db)
    except LibraryError:
        return
    with store:
        check_writable(store, files, force=force)


def _processes(out: Output, files: list[str], requested: int | None) -> int:
    """Return how many processes are worth their start and have room in memory."""
    from lanindex.pipeline.prepare import affordable, processes, size_of

    wanted = processes(len(files), requested)
    possible = affordable(map(size_of, files), wanted)
    if possible < wanted:
        out.detail(f"{possible} of {wanted} processes: the largest files leave no room for more")
    return possible


def _left_out(paths: list[str], *read_paths: str | None) -> str:
    """Say which files were passed over, but for the library, the labels and what was read."""
    from lanindex.locations import located
    from lanindex.pipeline.ingest import left_out

    known = {located(path) + end for path in read_paths if path for end in ("", "-wal", "-shm")}
    return left_out(path for path in paths if located(path) not in known)


def _count(tally: Counter[str], outcome: Outcome, division: int) -> None:
    tally.update({outcome.status: 1, "symbols": outcome.symbols})
    tally["milliseconds"] += round(1000 * outcome.seconds)
    tally["warnings"] += len(outcome.warnings)
    tally["anew"] += outcome.was_stored and outcome.status == "added"
    tally["moved"] += bool(outcome.moved) and outcome.status == "unchanged"
    tally["labelled"] += outcome.labelled
    tally["finer"] += outcome.division > division


def _report(out: Output, outcome: Outcome) -> None:
    if out.json:
        tempo = {"tempo": outcome.tempo} if outcome.tempo else {}
        counts = {"frames": outcome.frames, "symbols": outcome.symbols, **tempo}
        rest = {"warnings": list(outcome.warnings), "error": outcome.error}
        out.record({"capture": outcome.path, "status": outcome.status, **counts, **rest})
    if outcome.error:
        say_error(outcome.error)
    if outcome.tempo:
        out.detail(f"{outcome.path}: {outcome.tempo}")
    if outcome.moved:
        out.detail(f"{outcome.path}: was {outcome.moved} before")
    for warning in outcome.warnings:
        out.detail(f"{outcome.path}: {warning}")


def _summary(out: Output, tally: Counter[str], files: int, elapsed: float, dry_run: bool) -> None:
    if tally["unchanged"] == files and not (tally["labelled"] or tally["moved"]):
        out.note(f"nothing new: {counted(files, 'file')} unchanged")
        return
    would = "would be " if dry_run else ""
    counts = {
        f"{would}added": tally["added"] - tally["anew"],
        f"{would}written anew": tally["anew"],
        "unchanged": tally["unchanged"] - tally["moved"],
        "moved": tally["moved"],
        "labelled anew": tally["labelled"],
        "failed": tally["failed"],
    }
    changes = ", ".join(f"{number} {word}" for word, number in counts.items() if number)
    out.note(
        f"{counted(files, 'file')}: {changes or 'nothing to do'}; "
        f"{duration(tally['milliseconds'] / 1000)} of movement, "
        f"{counted(tally['symbols'], 'symbol')}, in {elapsed:.1f} s"
    )


def animate(
    score: str = argument(..., "SCORE", "An .lnd file or another score."),
    output: Path | None = options.output(
        "FILE", "Where to write (-: standard output); by default beside the score."
    ),
    fps: str = option("30", "RATE", "Frames per second."),
    noise: float = option(0.0, "MM", "Shake every joint by this standard deviation.", min=0.0),
    seed: int = option(0, None, "Seed of the noise.", min=0),
    force: options.Force = False,
    *,
    out: options.PlainOut,
) -> None:
    """Turn a score into motion of a standard body, as a BVH file."""
    from lanindex import notation
    from lanindex.formats import bvh
    from lanindex.locations import is_url, plain
    from lanindex.perform import perform

    rate, score = options.rate(fps), plain(score)
    motion = perform(notation.read(score), rate=rate, noise=noise, seed=seed)
    target = output or Path(Path(score).name if is_url(score) else score).with_suffix(".bvh")
    content = bvh.write(motion)
    if target == options.STDOUT:
        out.content(content.decode())
    else:
        write_all([(target, content)], force=force, sources=[score])
    out.notes(motion.warnings, score)
    out.note(f"{target}: {len(motion)} frames at {float(rate):g} Hz, {motion.seconds:.2f} s")


def convert(
    file: str = argument(..., "FILE", "A capture or score."),
    to: Path | None = argument(None, "[OUT]", "The file to write; its ending gives the format."),
    output: Path = options.output("FILE", "The same; - is standard output.", options.STDOUT),
    form: str | None = option(None, "lnd|bvh|c3d|...", "The format, whatever the ending.", "--to"),
    into: Path | None = option(None, "FILE", "Add tiers to an existing .eaf file."),
    media: Path | None = option(None, "FILE", "A recording that the .eaf opens with."),
    origin: options.Origin = False,
    profile: options.Profile = "default",
    *,
    reading: options.Reading,
    force: options.Force = False,
    out: options.PlainOut,
) -> None:
    """Write a capture as LND or in another notation or format, without a library.

    Joints keep their positions. Where only positions are known, bones are turned by the rule of
    lanindex.rotation, starting from a body that stands with its arms to the sides.
    """
    from lanindex import formats
    from lanindex.locations import plain
    from lanindex.notation import NOTATIONS, WRITTEN, left_out
    from lanindex.pipeline import convert

    file = plain(file)
    target = to or (into if into and output == options.STDOUT else output)
    if form is None and target == options.STDOUT:
        form = "lnd"
    form = convert.target_of(str(target), form)
    if target == options.STDOUT and (form not in WRITTEN or not NOTATIONS[form].text):
        raise UsageError(f"{form} on standard output", wanted="a file to write it to")
    if form != "lnd" and reading.tempo is not None:
        raise UsageError(f"beats in {form}", place="--tempo", wanted="--to lnd, which counts them")
    if form in WRITTEN:
        score = convert.score_of(file, reading, profile, origin=origin)
        out.notes(score.warnings, file)
        if lost := left_out(score, form):
            out.note(f"{NOTATIONS[form].title} has no room for {' '.join(lost)}")
        content = convert.notated(score, form, into, force=force, media=media)
        files = [(target, content)]
    else:
        motion = convert.motion_of(file, reading, origin=origin)
        source = formats.opened(file)
        unkept = formats.unkept(source, reading, motion)
        if unkept and form == motion.source.format and not (origin or reading.given()):
            files, unkept = [(target, source.content[:])], Counter()
        else:
            files, notes = convert.files_of(motion, form, target)
            out.notes((*motion.warnings, *notes), file)
        if unkept:
            out.note(f"{file}: not written: {', '.join(map(counted, unkept.values(), unkept))}")
    if target == options.STDOUT:
        out.content(content.decode())
        return
    write_all(files, force=force or target == into, sources=[file])
    out.notes(str(path) for path, _ in files)


def inspect(
    file: str = argument(..., "FILE", "A capture."),
    *,
    reading: options.Reading,
    out: options.Out,
) -> None:
    """Show what a reader sees in a capture file.

    Joints and the body they map to, rate, unit, up axis, facing, and what is doubtful.
    """
    from lanindex.formats import Wanted, opened, read_file

    motion = read_file(opened(file), reading, Wanted(body_only=True))
    facts = _facts(motion)
    if reading.tempo is not None:
        from lanindex.encoding import encode
        from lanindex.notation.beats import describe_tempo

        score = encode(motion, tempo=reading.tempo)
        facts["tempo"] = describe_tempo(score.meter, score.other)
        facts["warnings"] += score.warnings
    if out.json:
        rest = {key.replace(" ", "_"): facts[key] for key in facts if key not in ("file", "rate")}
        out.record({"capture": facts["file"], "fps": round(float(motion.rate), 6), **rest})
        return
    body, warnings, joints = (facts.pop(key) for key in ("body", "warnings", "joints"))
    for key, value in facts.items():
        out.line(f"{key:12} {value}")
    kind = "markers" if motion.source.set else "joints"
    out.line(f"{kind:12} {len(joints)}: {' '.join(joints)}")
    out.line("body")
    for joint, name in body.items():
        out.line(f"  {joint:10} {name or '(absent)'}")
    for warning in warnings:
        out.line(out.paint(f"warning      {warning}", "warn"))


def _facts(motion: Motion) -> dict[str, Any]:
    import numpy as np

    from lanindex.alphabet import JOINTS
    from lanindex.encoding.joints import Body
    from lanindex.encoding.limbs import heading
    from lanindex.encoding.profile import load

    turn = float(np.degrees(heading(motion, motion.rate)[motion.first]))
    names = motion.source.made or motion.skeleton.played()
    limbs = zip(
        ("leg", "arm"), Body(motion, load("default")).lengths(["r_leg", "r_arm"]), strict=True
    )
    guessed = " (by a unit that is a guess)" if "guessed" in motion.source.unit else ""
    first = motion.first
    before = "frame 0 is" if first == 1 else f"frames 0 to {first - 1} are"
    return {
        "file": motion.source.path,
        "format": motion.source.format,
        "frames": len(motion),
        "rate": f"{float(motion.rate):g} Hz ({motion.rate})",
        "seconds": round(motion.seconds, 3),
        "unit": f"{motion.source.unit}: {motion.source.scale:g} mm",
        "up": motion.source.up,
        "compose": motion.source.compose or "the format leaves no choice",
        "height": f"{_height(motion):.0f} mm{guessed}",
        "limbs": ", ".join(f"{it} {size:.0f} mm" if size > 0 else f"no {it}" for it, size in limbs),
        "facing": f"{(turn + 90) % 360:.0f} degrees from +z towards +x, in the first frame",
        **({"marker set": motion.source.set} if motion.source.set else {}),
        "palms": _palms(motion),
        "calibration": f"{before} a pose, frame {first} stands in" if first else "none",
        "joints": list(motion.source.joints),
        "body": {joint: names.get(joint) for joint in JOINTS},
        "warnings": list(motion.warnings),
    }


def _height(motion: Motion) -> float:
    """Return the median height, mm; one joint at a time, because long captures need much memory."""
    import numpy as np

    from lanindex.alphabet import JOINTS
    from lanindex.encoding.joints import body

    highest, lowest = np.full(len(motion), -np.inf), np.full(len(motion), np.inf)
    for joint in JOINTS:
        level = body(motion, [joint])[joint][:, 1]
        if not np.isnan(level).all():
            np.maximum(highest, level, out=highest)
            np.minimum(lowest, level, out=lowest)
    return float(np.nanmedian(highest - lowest))


def _palms(motion: Motion) -> str:
    """Say which palms are known, and why others are not."""
    from lanindex.alphabet import FACING, PALMS, PARTS

    known = [part for part in FACING if PALMS[PARTS[part].child] in motion.axes]
    if known:
        return f"{' and '.join(known)} {'are' if len(known) > 1 else 'is'} told"
    if any(warning.startswith(FACING) for warning in motion.warnings):
        return "not told: nobody measured how the hands are turned"
    return "not told: neither fingers nor markers say how the hands are turned"
