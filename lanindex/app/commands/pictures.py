"""The verbs that draw or compare scores: score, play, diff."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from lanindex import records
from lanindex.app import options
from lanindex.app.options import argument, captures, exclusive, flag, option
from lanindex.app.output import Output, choice
from lanindex.errors import UsageError, counted
from lanindex.pipeline.files import refuse, safe_stem, write_all

if TYPE_CHECKING:
    from lanindex.compare import Timed
    from lanindex.model import Reading, Symbol
    from lanindex.pipeline.named import Named

TRACKS_NAMED = 6  # how many of the tracks that only one score has `diff` names


def score(
    capture: options.CaptureArgument,
    output: Path | None = options.output(
        "FILE.svg|png|pdf",
        "Where to draw (-: SVG on standard output); by default an .svg file here.",
    ),
    detail: str = option("plain", "plain|full", "What a reader expects, or all that is known."),
    parts: options.Parts = None,
    start: options.FromSeconds = None,
    stop: options.ToSeconds = None,
    bars: options.Bars = None,
    strip: bool = flag("--strip", "Draw one long staff."),
    scale: options.Scale = None,
    highlight: str | None = option(None, "PATTERN", "Lay a band over its hits' symbols."),
    legend: bool = flag("--legend", "Explain the signs."),
    words: options.Words = None,
    profile: options.FileProfile = None,
    *,
    reading: options.Reading,
    force: options.Force = False,
    db: options.Db = options.DB,
    out: options.PlainOut,
) -> None:
    """Draw a capture or a score as a staff of Labanotation, time upwards.

    Beats are counted if the tempo is known, else seconds. A plain score leaves out what its reader
    takes for granted, such as the legs of ordinary steps; tracks of --parts are drawn in full. A
    capture in the library is drawn as it was ingested; with an option for reading (--unit,
    --profile and so on), CAPTURE is a file and is read.
    """
    exclusive("--strip", strip, {"--bars": bars})
    choice("--detail", detail, ("plain", "full"))
    from lanindex.draw.plain import plain
    from lanindex.draw.staff import draw, settled
    from lanindex.draw.svg import FORMS, rendered
    from lanindex.encoding.profile import METHOD
    from lanindex.model.derived import SUPPORTS
    from lanindex.notation import NOTATIONS

    target = output or Path(f"{safe_stem('hit' if capture == '-' else capture)}.svg")
    form = "svg" if target == options.STDOUT else options.ending(target, FORMS)
    named = _read_argument(out, capture, db, profile, reading)
    marked = list(settled(named.score, _symbols_to_mark(out, named, highlight, words)))
    detail, meter = "full" if parts else detail, named.score.meter
    tempo = f"{meter.beats}/{meter.beat}, {float(meter.speed):g} beats a minute"
    scale_of_time = tempo if named.counted else "a tick a second"
    method = "" if named.format in NOTATIONS else f", method {METHOD.decode()}"
    shown = options.names(parts) or named.score.tracks
    weight = "" if {*SUPPORTS} & {*shown} else "; the weight is not told"
    picture = draw(
        named.score if detail == "full" else plain(named.score, marked),
        title=named.title,
        heading=(named.title, f"{scale_of_time}; {detail} score{method}{weight}"),
        parts=options.names(parts),
        start=named.seconds[0] if start is None else start,
        stop=named.seconds[1] if stop is None else stop,
        bars=None if strip else bars or FORMS[form][0],
        seconds=not named.counted,
        marked=marked,
        legend=legend,
    )
    out.notes(picture.warnings, named.title)
    content = rendered(picture, form, scale or FORMS[form][1])
    if target == options.STDOUT:
        out.content(content.decode())
    else:
        write_all([(target, content)], force=force, sources=[named.path])
        out.note(f"{target}: {sum(bool(it.marks) for it in picture.groups())} symbols")


def _read_argument(
    out: Output, text: str, db: str, profile: str | None, reading: Reading | None = None
) -> Named:
    """Return the capture, hit, stretch or file that an argument names; print a file's warnings."""
    from lanindex.library.store import Store
    from lanindex.pipeline.named import named

    library = partial(Store.open, db, readonly=True)
    result = named(options.one_line(text), library, reading, profile=profile)
    out.notes(() if result.capture else result.score.warnings, result.path)
    return result


def _symbols_to_mark(
    out: Output, named: Named, pattern: str | None, words: Path | None
) -> list[Symbol]:
    """Return the symbols to highlight: those that a pattern matches, or the hit that is named."""
    if pattern is None:
        return list(named.matched)
    from lanindex.pipeline.search import matched

    hits = matched(named.score, pattern, words)
    out.note(counted(len(hits), "hit"))
    return [symbol for hit in hits for symbol in hit]


def play(
    capture: options.CaptureArgument,
    output: Path | None = options.output(
        "FILE.webp|gif|mp4", "Where to write; by default a .webp file here."
    ),
    highlight: str | None = option(None, "PATTERN", "Colour the limbs of its hits."),
    words: options.Words = None,
    view: str = option(
        "auto", "auto|front|side|DEGREES", "Where to look from: auto sees most of the movement."
    ),
    parts: options.Parts = None,
    start: options.FromSeconds = None,
    stop: options.ToSeconds = None,
    film_fps: str | None = option(
        None, "RATE", "Frames a second of the film: MP4 25, WebP, GIF 20."
    ),
    size: str = option("640x480", "WIDTHxHEIGHT", "Size of the film in pixels."),
    profile: options.FileProfile = None,
    *,
    reading: options.Reading,
    force: options.Force = False,
    db: options.Db = options.DB,
    out: options.PlainOut,
) -> None:
    """Film a stick figure moving beside its staff of Labanotation, in real time.

    Parts that matched are coloured while they do, and the path over the floor is drawn. A score
    without a motion is performed by a standard body. Options for reading (--unit, --profile and
    so on) are for files.
    """
    from lanindex.film.figure import figure
    from lanindex.film.film import FORMS, RATE, RATES, Film
    from lanindex.library.store import Store
    from lanindex.pipeline.named import named as resolve
    from lanindex.pipeline.preview import motion_of

    target = output or Path(f"{safe_stem('hit' if capture == '-' else capture)}.webp")
    form = options.ending(target, FORMS)
    rate = RATES.get(form, RATE) if film_fps is None else options.rate(film_fps, "--film-fps")
    width, _, height = size.lower().partition("x")
    if not (width.isdecimal() and height.isdecimal()):
        raise UsageError(f'"{size}"', place="--size", wanted="WIDTHxHEIGHT, such as 640x480")
    refuse(target, force=force)
    library = partial(Store.open, db, readonly=True)
    named = resolve(options.one_line(capture), library, reading, profile=profile)
    motion = motion_of(named, library, reading, rate)
    if not named.capture:
        warnings = dict.fromkeys((*named.score.warnings, *motion.warnings))
        out.notes(warnings, named.path)
    film = Film(
        figure(motion),
        named.score,
        title=named.title,
        start=named.seconds[0] if start is None else start,
        stop=named.seconds[1] if stop is None else stop,
        rate=rate,
        size=(int(width), int(height)),
        view=view,
        parts=options.names(parts),
        marked=_symbols_to_mark(out, named, highlight, words),
        seconds=not named.counted,
    )
    shown = partial(out.progress, total=len(film), noun="frames")
    write_all([(target, film.written(form, shown))], force=force, sources=[named.path])
    out.notes(film.staff.warnings, named.title)
    seconds = float(len(film) / film.rate)
    out.note(f"{target}: {len(film)} frames at {float(rate):g} Hz, {seconds:.2f} s")


def diff(
    one: str = captures(..., "A", "A capture or file; A:FROM-TO for a stretch, in frames."),
    other: str = captures(..., "B", "What to compare it with."),
    output: Path | None = options.output("FILE.svg|png|pdf", "Draw both staves."),
    parts: options.Parts = None,
    tolerance: options.Tolerance = 0.1,
    bars: options.Bars = None,
    scale: options.Scale = None,
    profile: options.FileProfile = None,
    force: options.Force = False,
    db: options.Db = options.DB,
    *,
    out: options.Out,
) -> int:
    """Compare two captures or scores, symbol by symbol.

    The symbols of a track are aligned in order, so that as few as possible are left out, added or
    replaced. Symbols that are the same at another time have moved. A symbol is "not seen" where
    the other score does not know the part. Tracks that only one of the two has are named, and not
    compared. Exits with 0 if nothing differs, else 1.
    """
    if output is None and (bars or scale):
        raise UsageError("--bars and --scale", wanted="--output beside them")
    from lanindex.compare import compare
    from lanindex.notation.excerpt import excerpt

    named = [_read_argument(out, text, db, profile) for text in (one, other)]
    scores = [excerpt(it.score, it.span) for it in named]
    compared = compare(*scores, parts=options.names(parts), tolerance=tolerance)
    differences = compared.differences
    if output is not None:
        from lanindex.draw.staff import draw_pair
        from lanindex.draw.svg import FORMS, rendered

        form = options.ending(output, FORMS)
        beats = all(it.counted for it in named) and scores[0].meter == scores[1].meter
        picture = draw_pair(
            scores,
            [
                [it.one.symbol for it in differences if it.one],
                [it.other.symbol for it in differences if it.other],
            ],
            titles=[it.title for it in named],
            parts=options.names(parts),
            bars=bars or FORMS[form][0],
            seconds=not beats,
        )
        out.notes(picture.warnings)
        content = rendered(picture, form, scale or FORMS[form][1])
        write_all([(output, content)], force=force, sources=[it.path for it in named])
    if differences:
        rows = ((it.part, *_cells(it.one), *_cells(it.other), it.change) for it in differences)
        head = ("part", "A", "seconds", "B", "seconds", "B is")
        out.table(head, rows, map(records.of_difference, differences))
    for it, only in zip(named, compared.only, strict=True):
        if only:
            more = f" and {len(only) - TRACKS_NAMED} more" if len(only) > TRACKS_NAMED else ""
            out.note(f"only {it.title} tells of {', '.join(only[:TRACKS_NAMED])}{more}")
    tracks, same = counted(len(compared.parts), "track"), counted(compared.same, "symbol")
    out.note(f"{counted(len(differences), 'difference')} in {tracks}, {same} the same")
    return bool(differences)


def _cells(timed: Timed | None) -> tuple[str, str]:
    return (
        ("", "") if timed is None else (timed.symbol.words, f"{timed.start:.2f}-{timed.stop:.2f}")
    )


def read_score(
    picture: str = argument(..., "PICTURE", "A printed score: an image or a PDF."),
    output: Path | None = options.output(
        "FILE.lnd", "Where to write; by default an .lnd file here."
    ),
    speed: float = option(60.0, None, "Beats a minute.", min=1),
    doubts: Path | None = option(
        None, "FILE.html", "Show what is not known or doubtful on the picture."
    ),
    *,
    force: options.Force = False,
    out: options.PlainOut,
) -> int:
    """Read a printed score into LND.

    What is not known is told with its place and left out; what is doubtful is told and kept. A
    count is a beat. Exits with 1 if something is not known.
    """
    from fractions import Fraction

    from lanindex.notation import lnd
    from lanindex.reader.printed import open_printed

    target = output or Path(f"{safe_stem(picture)}.lnd")
    options.ending(target, ["lnd"])
    refuse(target, force=force)
    if doubts is not None:
        options.ending(doubts, ["html"], "--doubts")
        refuse(doubts, force=force)
    printed = open_printed(picture, watch=partial(out.watch, "pages"))
    score = printed.score(Fraction(speed).limit_denominator(1000))
    for what in score.warnings:
        out.note(what)
    files = [(target, lnd.write(score).encode())]
    if doubts is not None:
        from lanindex.reader.doubts import written

        files.append((doubts, written(printed).encode()))
    write_all(files, force=force, sources=[picture])
    known = sum(len(page.records) for page in printed.read.values())
    unknown = sum(len(page.unknown) for page in printed.read.values())
    out.note(f"{target}: {counted(known, 'sign')}, {unknown} more not known")
    return int(unknown > 0 or any(page.notes for page in printed.read.values()))
