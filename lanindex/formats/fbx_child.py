"""What reads an FBX file by ``ufbx``, in a process of its own: a C library may crash.

It is run as a script, imports nothing of LanIndex, takes the file from its standard input behind a
line of JSON, and answers by a line of JSON and numbers (float64). Whatever ``ufbx`` returns it
keeps in a variable, for objects that hang on unnamed ones may be gone.
"""

from __future__ import annotations

import json
import sys
from array import array
from typing import Any

MOVED = ("Lcl Translation", "Lcl Rotation", "Lcl Scaling")
MARGIN = 512 << 20  # bytes of memory beside what the file needs
UNPACKED = 64  # times its size that a file may grow to


def main() -> None:
    """Answer one question."""
    query = json.loads(sys.stdin.buffer.readline())
    data = sys.stdin.buffer.read()
    _limit(MARGIN + UNPACKED * len(data))
    numbers = array("d")
    try:
        answer = _answer(data, query, numbers)
    except Exception as error:
        answer = {"error": f"{type(error).__name__}: {error}"[:300]}
    sys.stdout.buffer.write(json.dumps(answer).encode() + b"\n")
    sys.stdout.buffer.write(numbers.tobytes() if "error" not in answer else b"")


def _limit(size: int) -> None:
    try:
        import resource
    except ImportError:  # not a Unix
        return
    _, hard = resource.getrlimit(resource.RLIMIT_AS)
    resource.setrlimit(resource.RLIMIT_AS, (size, hard))


def _answer(data: bytes, query: dict[str, Any], numbers: array[float]) -> dict[str, Any]:
    import ufbx

    less = {"ignore_geometry": True, "ignore_embedded": True, "load_external_files": False}
    inherit = ufbx.InheritModeHandling.HELPER_NODES
    scene = ufbx.load_memory(data, inherit_mode_handling=inherit, **less)
    nodes, takes = _as_list(scene.nodes), _as_list(scene.anim_stacks)
    settings = scene.settings
    axes = settings.axes
    answer = {
        "rate": settings.frames_per_second,
        "metres": settings.unit_meters,
        "axes": [int(axes.right), int(axes.up), int(axes.front)],
        "nodes": [_node_record(node) for node in nodes],
    }
    answer["takes"] = [take.name for take in takes]
    moving = [_moving(ufbx, take, nodes) for take in takes]
    first = next((number for number, moved in enumerate(moving) if moved), -1)
    named = [number for number, name in enumerate(answer["takes"]) if name == query["take"]]
    answer["take"] = number = first if query["take"] is None else named[0] if named else -1
    if number < 0:
        return answer
    take, moved = takes[number], moving[number]
    begin, end, rate = take.time_begin, take.time_end, answer["rate"]
    if end <= begin:
        begin, end = _key_range(scene)
    if not rate > 0 or not end - begin < query["most"] / rate:
        return {**answer, "take": -1, "count": -1}
    count = max(round((end - begin) * rate), 0) + 1
    answer |= {"count": count, "moved": sorted(moved)}
    if count * len(moved) > query["most"]:
        return {**answer, "count": -1}
    times = [begin + frame / rate for frame in range(count)]
    for place, node in enumerate(nodes):
        _append_transform(numbers, node.local_transform)
        for moment in times if place in moved else ():
            _append_transform(numbers, ufbx.evaluate_transform(take.anim, node, moment))
    return answer


def _as_list(array: Any) -> list[Any]:
    return [array[number] for number in range(len(array))]


def _node_record(node: Any) -> list[Any]:
    """Return a node's name, its parent, and what it is."""
    parent = node.parent
    if node.is_scale_helper or node.is_geometry_transform_helper:
        kind = "helper"
    elif any(it is not None for it in (node.mesh, node.light, node.camera)):
        kind = "shown"
    else:
        kind = "node" if node.bone is None else "bone"
    return [node.name, -1 if parent is None else parent.typed_id, kind]


def _moving(ufbx: Any, take: Any, nodes: list[Any]) -> set[int]:
    """Return the nodes that a take moves."""
    layers = _as_list(take.layers)
    return {
        place
        for place, node in enumerate(nodes)
        if any(ufbx.find_anim_prop(layer, node, name) for layer in layers for name in MOVED)
    }


def _key_range(scene: Any) -> tuple[float, float]:
    """Return the times of the first and the last key, where a take does not say its own."""
    curves = _as_list(scene.anim_curves)
    times = [(curve.min_time, curve.max_time) for curve in curves if len(curve.keyframes)]
    return min(time for time, _ in times), max(time for _, time in times)


def _append_transform(numbers: array[float], transform: Any) -> None:
    shift, turn, scale = transform.translation, transform.rotation, transform.scale
    numbers.extend(
        (shift.x, shift.y, shift.z, turn.w, turn.x, turn.y, turn.z, scale.x, scale.y, scale.z)
    )


if __name__ == "__main__":
    main()
