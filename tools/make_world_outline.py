"""Write the coarse world of the map from Natural Earth's 1:110m data (public domain).

.venv/bin/python tools/make_world_outline.py

Read from the npm package world-atlas, which ships that data as TopoJSON. Kept are places to a tenth
of a degree: rings of land, and lines that two countries share.
"""

from __future__ import annotations

import json
from collections import Counter
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from collections.abc import Iterator

ROOT = Path(__file__).resolve().parent.parent
ATLAS = ROOT / "web" / "node_modules" / "world-atlas"
TARGET = ROOT / "web" / "src" / "elements" / "map" / "world-outline.ts"
STEPS = 10  # Of a degree.
HEAD = """\
/**
 * The coarse world: land and borders of Natural Earth at 1:110 million, in the public domain.
 * Made by tools/make_world_outline.py; do not edit it. Each line is a ring or a line: longitude and
 * latitude of its first place in tenths of a degree, then the steps to each next one.
 */

"""


def decode_arcs(topology: dict[str, Any]) -> list[list[tuple[int, int]]]:
    """Give the arcs of a topology, in tenths of a degree, without places that are the same."""
    (scale_x, scale_y), (shift_x, shift_y) = (
        topology["transform"]["scale"],
        topology["transform"]["translate"],
    )
    arcs = []
    for arc in topology["arcs"]:
        x = y = 0
        places: list[tuple[int, int]] = []
        for step_x, step_y in arc:
            x, y = x + step_x, y + step_y
            place = (
                round((x * scale_x + shift_x) * STEPS),
                round((y * scale_y + shift_y) * STEPS),
            )
            if not places or places[-1] != place:
                places.append(place)
        arcs.append(places)
    return arcs


def arcs_of(geometry: dict[str, Any]) -> Iterator[list[int]]:
    """Give the rings of a geometry, each as numbers of arcs; ``~n`` is arc n backwards."""
    kind = geometry["type"]
    if kind == "GeometryCollection":
        for part in geometry["geometries"]:
            yield from arcs_of(part)
    elif kind == "Polygon":
        yield from geometry["arcs"]
    elif kind == "MultiPolygon":
        for polygon in geometry["arcs"]:
            yield from polygon


def joined(arcs: list[list[tuple[int, int]]], ring: list[int]) -> list[tuple[int, int]]:
    """Put the arcs of a ring together."""
    places: list[tuple[int, int]] = []
    for number in ring:
        part = arcs[number] if number >= 0 else arcs[~number][::-1]
        places += part[1:] if places and places[-1] == part[0] else part
    return places


def write_line(places: list[tuple[int, int]]) -> str:
    """Write a ring or line as its first place and the steps from there."""
    steps = [places[0], *((b[0] - a[0], b[1] - a[1]) for a, b in pairwise(places))]
    return " ".join(f"{x} {y}" for x, y in steps)


def main() -> None:
    """Write the file."""
    land = json.loads((ATLAS / "land-110m.json").read_text(encoding="utf-8"))
    arcs = decode_arcs(land)
    rings = [joined(arcs, ring) for ring in arcs_of(land["objects"]["land"])]
    countries = json.loads((ATLAS / "countries-110m.json").read_text(encoding="utf-8"))
    arcs = decode_arcs(countries)
    used = Counter(
        number if number >= 0 else ~number
        for ring in arcs_of(countries["objects"]["countries"])
        for number in ring
    )
    borders = [arcs[number] for number, times in used.items() if times > 1]
    parts = [HEAD]
    for name, lines in (("LAND", rings), ("BORDERS", borders)):
        # A line of one place says nothing at this scale.
        text = ";".join(write_line(line) for line in lines if len(line) > 1)
        parts.append(f'export const {name} =\n  "{text}";\n')
    TARGET.write_text("".join(parts), encoding="utf-8")
    print(f"{TARGET.relative_to(ROOT)}: {len(rings)} rings, {len(borders)} borders")


if __name__ == "__main__":
    main()
