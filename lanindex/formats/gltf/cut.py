"""A stretch of a glTF file: its animation cut to some frames, the rest as it is."""

from __future__ import annotations

import base64
import json
from collections.abc import Callable, Iterator
from copy import deepcopy
from typing import Any

import numpy as np

from lanindex.formats.file import File
from lanindex.formats.gltf.document import Document, Value
from lanindex.formats.gltf.read import Performance, chosen, extras, rate_of, unknown
from lanindex.formats.gltf.tracks import PATHS, Track, timed, tracks
from lanindex.formats.gltf.write import Pack, glb
from lanindex.model import Reading, Span


def cutter(file: File, options: Reading | None = None) -> Callable[[Span], bytes]:
    """Return what cuts clips out of a glTF or GLB file, which is looked through once.

    A clip holds the animation that is read, in keys for each of its frames from second 0 on, and
    everything else of the file but its other animations. A GLB makes a GLB, a glTF file a glTF
    file with its numbers in it.
    """
    found, _ = chosen(file, options.take if options else None)
    return _Source(found).cut


class _Source:
    """What is the same in all clips of a file."""

    def __init__(self, found: Performance) -> None:
        self.found = found
        self.document = found.document
        self.tracks = timed(tracks(self.document, found.take), found.clock)
        moving = {(track.node, track.path) for track in found.tracks}
        self.first = next(
            number for number, track in enumerate(self.tracks)
            if (track.node, track.path) in moving
        )  # fmt: skip
        root: dict[str, Any] = self.document.root.value
        self.other = {key: value for key, value in root.items() if key != "animations"}
        samplers = _samplers(self.document)
        elsewhere = set(_accessors(self.other))
        self.free = sorted(samplers - elsewhere)
        self.pack, self.free_views = self._rest(root)

    def _rest(self, root: dict[str, Any]) -> tuple[Pack, list[int]]:
        """Lay down what is not animation; return it, and which buffer views are free then."""
        accessors: list[Any] = deepcopy(root.get("accessors") or [])
        others = [one for number, one in enumerate(accessors) if number not in set(self.free)]
        used = set(_called(others, "bufferView"))
        used |= set(_called({**self.other, "accessors": None}, "bufferView"))
        views: list[Any] = deepcopy(root.get("bufferViews") or [])
        pack = Pack(views, accessors)
        for number in sorted(used):
            where = Value(number, "a bufferView", self.document.file.name)
            buffer, first, length, _ = self.document.view(where)
            views[number] |= pack.lay(self.document.bytes(buffer, first, first + length))
        return pack, [number for number in range(len(views)) if number not in used]

    def cut(self, span: Span) -> bytes:
        """Return the clip of some frames."""
        frames = np.arange(span.start, span.stop)
        pack = self.pack.copy(self.free, self.free_views)
        seconds = np.arange(len(span)) / float(rate_of(self.found))
        every = pack.accessor(seconds, bounds=True)
        once = pack.accessor(seconds[:1], bounds=True)
        take = deepcopy(self.found.take.value)
        samplers = []
        for number, track in enumerate(self.tracks):
            values = self._values(track, frames)
            still = number != self.first and not (values != values[0]).any()
            values = values[:1] if still else values
            width = PATHS.get(track.path, 1)
            output = pack.accessor(values.reshape(-1, width))
            sampler: dict[str, Any] = {"input": once if still else every, "output": output}
            samplers.append(
                sampler if track.kind != "STEP" else {**sampler, "interpolation": "STEP"}
            )
            take["channels"][number]["sampler"] = number
        take["samplers"] = samplers
        take["extras"] = self._extras(span)
        pack.fill(once)
        root = {
            **self.other,
            "animations": [take],
            "accessors": pack.accessors,
            "bufferViews": pack.views,
            "buffers": [{"byteLength": pack.size}],
        }
        if self.document.is_glb:
            return glb(root, pack.numbers())
        data = base64.b64encode(pack.numbers()).decode()
        root["buffers"][0]["uri"] = f"data:application/octet-stream;base64,{data}"
        return json.dumps(root, allow_nan=False).encode()

    def _values(self, track: Track, frames: Any) -> Any:
        values = track.at(frames, exactly=True)
        if track.path == "rotation":
            values = values[:, [1, 2, 3, 0]]
        return values.astype(np.float32)

    def _extras(self, span: Span) -> dict[str, Any]:
        """Return what stands beside the animation, of these frames."""
        old = self.found.take.get("extras").value
        beside = dict(old) if isinstance(old, dict) else {}
        beside |= {"frames": len(span), "rate": str(rate_of(self.found))}
        if "unknown" in extras(self.found):
            beside["unknown"] = {
                self.found.person.names[joint]: [
                    [max(start, span.start) - span.start, min(stop, span.stop) - span.start]
                    for start, stop in gaps
                    if start < span.stop and stop > span.start
                ]
                for joint, gaps in unknown(self.found).items()
            }
        return beside


def _samplers(document: Document) -> set[int]:
    """Return the accessors that animations use."""
    found = set()
    accessors = document.root.get("accessors")
    for take in document.root.get("animations"):
        for sampler in take.get("samplers"):
            found |= {sampler.get(end).one_of(accessors) for end in ("input", "output")}
    return found


def _called(value: Any, name: str) -> Iterator[int]:
    """Yield the whole numbers that have a name, anywhere in JSON."""
    waiting = [value]
    while waiting:
        one = waiting.pop()
        if isinstance(one, dict):
            waiting.extend(one.values())
            if isinstance(one.get(name), int):
                yield one[name]
        elif isinstance(one, list):
            waiting.extend(one)


def _accessors(value: Any) -> Iterator[int]:
    """Yield the accessors that meshes, skins and extensions use."""
    for name in ("indices", "inverseBindMatrices"):
        yield from _called(value, name)
    waiting = [value]
    while waiting:
        one = waiting.pop()
        if isinstance(one, dict):
            for name in ("attributes", "targets"):
                within = one.get(name)
                for part in within if isinstance(within, list) else [within]:
                    if isinstance(part, dict):
                        yield from (it for it in part.values() if isinstance(it, int))
            waiting.extend(one.values())
        elif isinstance(one, list):
            waiting.extend(one)
