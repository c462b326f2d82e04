"""The house: rooms, walls with doors, and what stands where.

Metres; the vehicle starts at the origin and looks along x. The rooms, seen from above::

    y=4   +-----------+-------+-------+
          |  bedroom  | study | bath  |
    y=1   +----  -----+--  ---+--  ---+
          |           :  hall         |
    y=-.5 |  living   +------  -------+
          |  room     :    kitchen    |
    y=-4  +-----------+---------------+
         x=-2        3 4      6       9
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from talaia.sim.vehicle import furniture, occupants
from talaia.sim.vehicle.scene import Finish, FloorPose, Hull, SceneBuilder
from talaia.sim.vehicle.textures import Picture, draw_parquet, draw_plaster, draw_tiles, shade_floor

if TYPE_CHECKING:
    from collections.abc import Callable

__all__ = ["CEILING", "DOOR", "LANE_X", "LANE_Y", "MARKING", "ROOMS", "Room", "build_house"]

CEILING = 2.5
DOOR = 2.08
"""Clear height of a door (m)."""
WALL = 0.06
"""Thickness of one room's half of a wall (m)."""
FLOOR_SCALE = 160
"""Pixels a metre of the floors."""
LANE_Y = (-0.15, 0.65)
"""Two markings along x, from the living room through the hall (m): a lane 0.8 m wide."""
LANE_X = (0.3, 8.7)
MARKING = 0.05
"""Width of a marking (m)."""

Colour = tuple[float, float, float]


@dataclass(frozen=True)
class Room:
    """A rectangular room.

    Attributes:
        paint: colour of its walls.
        floor: makes the floor for a size in metres.
        doors: (side, middle, width): side is ``w``, ``e``, ``s`` or ``n``; the middle is an x or y.

    """

    name: str
    low: tuple[float, float]
    high: tuple[float, float]
    paint: Colour
    floor: Callable[[np.random.Generator, tuple[float, float]], Picture]
    doors: tuple[tuple[str, float, float], ...]


def _oak_floor(rng: np.random.Generator, size: tuple[float, float]) -> Picture:
    return draw_parquet(rng, (0.66, 0.48, 0.31), size, FLOOR_SCALE)


def _clay_floor(rng: np.random.Generator, size: tuple[float, float]) -> Picture:
    return draw_tiles(rng, (0.70, 0.46, 0.35), metres=size, scale=FLOOR_SCALE, side=0.33)


def _slate_floor(rng: np.random.Generator, size: tuple[float, float]) -> Picture:
    return draw_tiles(rng, (0.55, 0.58, 0.60), metres=size, scale=FLOOR_SCALE, side=0.25)


ROOMS = (
    Room(
        "living room",
        (-2, -4),
        (4, 1),
        (0.93, 0.90, 0.83),
        _oak_floor,
        (("e", 0.25, 1.2), ("e", -2.25, 1.4), ("n", 0.9, 1.1)),
    ),
    Room(
        "kitchen",
        (4, -4),
        (9, -0.5),
        (0.90, 0.86, 0.74),
        _clay_floor,
        (("w", -2.25, 1.4), ("n", 7.6, 1.1)),
    ),
    Room(
        "hall",
        (4, -0.5),
        (9, 1),
        (0.82, 0.87, 0.86),
        _oak_floor,
        (("w", 0.25, 1.2), ("s", 7.6, 1.1), ("n", 5.1, 1.1), ("n", 7.3, 1.1)),
    ),
    Room("bedroom", (-2, 1), (3, 4), (0.78, 0.83, 0.88), _oak_floor, (("s", 0.9, 1.1),)),
    Room("study", (3, 1), (6, 4), (0.80, 0.85, 0.76), _oak_floor, (("s", 5.1, 1.1),)),
    Room("bath", (6, 1), (9, 4), (0.80, 0.88, 0.90), _slate_floor, (("s", 7.3, 1.1),)),
)


def build_house(stage: SceneBuilder, layout: np.random.Generator) -> None:
    """Build it all.

    Args:
        stage: what to build in.
        layout: decides how chairs and other light things stand; same seed, same house.

    """
    for room in ROOMS:
        _add_walls(stage, room)
    _furnish_living_room(stage, layout)
    _furnish_kitchen(stage, layout)
    _furnish_others(stage, layout)
    # Last: floors are darker where things stand, so all of them have to be there.
    if stage.looks:
        for room in ROOMS:
            _floor_and_ceiling(stage, room)


def _add_walls(stage: SceneBuilder, room: Room) -> None:
    """Four walls from the inside: for each a place in the corner whose y runs along the wall."""
    (x0, y0), (x1, y1) = room.low, room.high
    # Standing before each wall and looking into the room: where y starts, and which way it runs.
    sides = (
        ("w", stage.pose_at(x0, y0, 0.0), y1 - y0, y0, 1),
        ("n", stage.pose_at(x0, y1, -math.pi / 2), x1 - x0, x0, 1),
        ("e", stage.pose_at(x1, y1, math.pi), y1 - y0, y1, -1),
        ("s", stage.pose_at(x1, y0, math.pi / 2), x1 - x0, x1, -1),
    )
    for side, place, length, corner, way in sides:
        gaps = sorted(
            (way * (middle - corner) - width / 2, way * (middle - corner) + width / 2)
            for where, middle, width in room.doors
            if where == side
        )
        start = 0.0
        # The wall's end is a gap without width.
        for low, high in [*gaps, (length, length)]:
            if low - start > 0.01:
                corners = (start == 0.0, low == length)
                _add_wall(place, room, span=(start, low), height=(0.0, CEILING), corners=corners)
            if high > low:
                _add_wall(
                    place, room, span=(low, high), height=(DOOR, CEILING), corners=(False, False)
                )
                _door_frame(place, low, high)
            start = high


def _add_wall(
    place: FloorPose,
    room: Room,
    *,
    span: tuple[float, float],
    height: tuple[float, float],
    corners: tuple[bool, bool],
) -> None:
    low, high = (0.0, span[0], height[0]), (WALL, span[1], height[1])
    # Above a door there is nothing to run into.
    if height[0] == 0.0:
        place.add_solid(low, high)
    stage = place.stage
    if not stage.looks:
        return
    size = (span[1] - span[0], height[1] - height[0])
    name = stage.add_finish(
        f"wall {place.x:.2f} {place.y:.2f} {place.yaw:.2f} {span[0]:.2f} {height[0]:.2f}",
        Finish(lambda rng: draw_plaster(rng, room.paint, size, corners), repeat=0.0, shine=0.0),
    )
    place.add_box(name, low, high, 0.002)
    if height[0] == 0.0:
        place.add_box("white wood", (WALL, *span[:1], 0.0), (WALL + 0.014, span[1], 0.09), 0.004)


def _door_frame(place: FloorPose, low: float, high: float) -> None:
    for y in (low, high):
        place.add_box(
            "white wood", (-0.01, y - 0.035, 0.0), (WALL + 0.015, y + 0.035, DOOR + 0.03), 0.008
        )
    place.add_box("white wood", (-0.01, low, DOOR - 0.03), (WALL + 0.015, high, DOOR + 0.04), 0.008)


def _furnish_living_room(stage: SceneBuilder, layout: np.random.Generator) -> None:
    def near(x: float, y: float, yaw: float, by: float = 0.05) -> FloorPose:
        dx, dy, turn = layout.uniform(-by, by, 3)
        return stage.pose_at(x + dx, y + dy, yaw + 3 * turn)

    up = math.pi / 2
    furniture.add_sofa(stage.pose_at(0.9, -3.44, up))
    furniture.low_table(near(0.9, -2.2, up, 0.03))
    furniture.add_television(stage.pose_at(-1.69, -1.9, 0.0))
    furniture.add_lamp(stage.pose_at(-1.55, -3.55))
    furniture.add_armchair(near(2.75, -2.75, 2.3))
    furniture.add_bookshelf(stage.pose_at(3.76, -0.98, math.pi))
    furniture.add_plant(near(3.55, -3.5, 0.0), 1.25)
    furniture.add_plant(near(-1.6, 0.6, 0.0), 0.9)
    furniture.add_window(stage.pose_at(0.9, -4 + WALL, up), 2.0)
    furniture.add_window(stage.pose_at(-2 + WALL, -0.3, 0.0), 1.2)
    furniture.add_painting(stage.pose_at(2.4, 1 - WALL, -up), "cat", width=0.9, height=0.6, z=0.95)
    if stage.looks:
        stage.pose_at(0.9, -2.2).add_box("rug", (-1.35, -0.9, 0.0), (1.35, 0.9, 0.012), 0.004)
    occupants.add_person(near(3.3, 0.62, math.pi + 0.2, 0.02))
    # Where both are in sight of the vehicle's start, and a detector takes them for what they are.
    occupants.add_dog(near(2.3, -0.9, 1.13, 0.03))


def _furnish_kitchen(stage: SceneBuilder, layout: np.random.Generator) -> None:
    up = math.pi / 2
    furniture.add_counter(stage.pose_at(7.1, -3.62, up), 3.6)
    furniture.add_cupboards(stage.pose_at(7.1, -3.76, up), 3.6)
    furniture.add_fridge(stage.pose_at(4.6, -3.58, up))
    table = stage.pose_at(6.6, -1.9, 0.0)
    furniture.dining_table(table)
    for x, y, yaw in ((-0.38, -0.62, up), (0.38, -0.62, up), (-0.38, 0.62, -up), (0.38, 0.62, -up)):
        dx, dy, turn = layout.uniform(-0.04, 0.04, 3)
        furniture.add_chair(table.pose_on(x + dx, y + dy, yaw + 5 * turn), "teal cloth")
    furniture.add_painting(
        stage.pose_at(9 - WALL, -1.7, math.pi), "coffee", width=1.0, height=0.72, z=1.15
    )
    furniture.add_window(stage.pose_at(9 - WALL, -2.9, math.pi), 0.9, 1.6)
    furniture.add_plant(stage.pose_at(8.6, -0.9), 0.8)


def _furnish_others(stage: SceneBuilder, layout: np.random.Generator) -> None:
    up = math.pi / 2
    furniture.add_painting(
        stage.pose_at(9 - WALL, 0.25, math.pi), "astronaut", width=1.0, height=1.0, z=1.05
    )
    furniture.add_painting(
        stage.pose_at(5.6, -0.5 + WALL, up), "galaxies", width=1.1, height=0.6, z=1.3
    )
    furniture.add_plant(stage.pose_at(8.65, -0.15), 0.7)
    furniture.add_bed(stage.pose_at(-0.88, 3.0))
    for y in (1.85,):
        stage.pose_at(-1.7, y).add_box("oak", (-0.2, -0.2, 0.0), (0.2, 0.2, 0.5), 0.015, solid=True)
        stage.pose_at(-1.7, y).add_rod("clay", (0, 0, 0.5), (0, 0, 0.7), 0.06)
        stage.pose_at(-1.7, y).add_rod("shade", (0, 0, 0.7), (0, 0, 0.9), 0.13, blunt=True)
    furniture.add_wardrobe(stage.pose_at(2.62, 3.1, math.pi))
    furniture.add_window(stage.pose_at(1.2, 4 - WALL, -up), 1.3)
    furniture.add_painting(
        stage.pose_at(-2 + WALL, 3.0, 0.0), "rocket", width=0.6, height=0.8, z=1.65
    )
    if stage.looks:
        stage.pose_at(1.2, 2.3).add_box("blue rug", (-0.8, -0.55, 0.0), (0.8, 0.55, 0.012), 0.004)
    furniture.add_desk(stage.pose_at(4.4, 3.55, -up))
    dx, dy, turn = layout.uniform(-0.08, 0.08, 3)
    furniture.office_chair(stage.pose_at(4.4 + dx, 2.75 + dy, up + 6 * turn))
    furniture.add_bookshelf(stage.pose_at(3.24, 2.0, 0.0))
    furniture.add_painting(
        stage.pose_at(6 - WALL, 2.6, math.pi), "rocket", width=0.75, height=1.0, z=1.15
    )
    furniture.add_plant(stage.pose_at(5.6, 3.6), 1.1)
    furniture.add_bath(stage.pose_at(8.52, 2.9))
    furniture.add_washstand(stage.pose_at(6.29, 2.9, 0.0))
    furniture.add_window(stage.pose_at(7.3, 4 - WALL, -up), 0.9, 1.6)
    furniture.add_plant(stage.pose_at(8.6, 1.4), 0.6)


def _add_outline(hull: Hull) -> list[tuple[float, float]]:
    x, y, _ = hull.centre
    a, b, _ = hull.half
    corners: list[tuple[float, float]]
    if hull.round:
        corners = [(a * math.cos(t), a * math.sin(t)) for t in np.linspace(0, 2 * math.pi, 12)]
    else:
        corners = [(-a, -b), (a, -b), (a, b), (-a, b)]
    c, s = math.cos(hull.yaw), math.sin(hull.yaw)
    return [(x + c * u - s * v, y + s * u + c * v) for u, v in corners]


def _mark_lane(floor: Picture, room: Room) -> Picture:
    """Paint what of the lane is in a room; row 0 of the floor is at its largest y."""
    low, high = max(LANE_X[0], room.low[0]), min(LANE_X[1], room.high[0])
    for y in LANE_Y:
        if low < high and room.low[1] < y < room.high[1]:
            top = round((room.high[1] - y - MARKING / 2) * FLOOR_SCALE)
            left, right = (round((x - room.low[0]) * FLOOR_SCALE) for x in (low, high))
            floor[top : top + round(MARKING * FLOOR_SCALE), left:right] = (238, 226, 190)
    return floor


def _floor_and_ceiling(stage: SceneBuilder, room: Room) -> None:
    (x0, y0), (x1, y1) = room.low, room.high
    size = (x1 - x0, y1 - y0)
    # What stands on the floor and is no wall.
    standing = [
        h for h in stage.hulls if h.centre[2] - h.half[2] < 0.1 and h.half[2] < CEILING / 2 - 0.1
    ]
    outlines = [[(x - x0, y - y0) for x, y in _add_outline(hull)] for hull in standing]

    def picture(rng: np.random.Generator) -> Picture:
        floor = _mark_lane(room.floor(rng, size), room)
        return shade_floor(floor, outlines, FLOOR_SCALE)

    name = stage.add_finish(f"floor {room.name}", Finish(picture, repeat=0.0, shine=0.12))
    middle = stage.pose_at((x0 + x1) / 2, (y0 + y1) / 2)
    half = (size[0] / 2, size[1] / 2)
    middle.add_box(name, (-half[0], -half[1], -0.05), (*half, 0.0), 0.001)
    middle.add_box("white", (-half[0], -half[1], CEILING), (*half, CEILING + 0.05), 0.001)
    middle.add_rod("shade", (0, 0, CEILING - 0.06), (0, 0, CEILING), 0.22, blunt=True)
