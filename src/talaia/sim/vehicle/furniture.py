"""The things that stand in the house. Each function builds one, facing the place's own x axis.

Longer than other files because it is a list: one short function for each thing, none calls many.
"""

from __future__ import annotations

import math

from talaia.sim.vehicle.scene import Finish, FloorPose
from talaia.sim.vehicle.textures import (
    book_row,
    draw_cloth,
    draw_fur,
    draw_rug,
    draw_tiles,
    draw_view,
    draw_wood,
    load_photograph,
)

__all__ = [
    "FINISHES",
    "add_armchair",
    "add_bath",
    "add_bed",
    "add_bookshelf",
    "add_chair",
    "add_counter",
    "add_cupboards",
    "add_desk",
    "add_fridge",
    "add_lamp",
    "add_painting",
    "add_plant",
    "add_sofa",
    "add_television",
    "add_wardrobe",
    "add_washstand",
    "add_window",
    "dining_table",
    "low_table",
    "office_chair",
]

# By the names that the things below are made of; house and occupants add their own.
FINISHES: dict[str, Finish] = {
    "oak": Finish(lambda r: draw_wood(r, (0.74, 0.56, 0.36)), repeat=1.0, shine=0.15),
    "walnut": Finish(lambda r: draw_wood(r, (0.43, 0.29, 0.19)), repeat=1.0, shine=0.2),
    "white wood": Finish(colour=(0.93, 0.92, 0.89), shine=0.2),
    "sage": Finish(colour=(0.53, 0.62, 0.54), shine=0.25),
    "teal cloth": Finish(lambda r: draw_cloth(r, (0.16, 0.42, 0.45)), repeat=4.0, shine=0.0),
    "mustard cloth": Finish(lambda r: draw_cloth(r, (0.84, 0.62, 0.20)), repeat=4.0, shine=0.0),
    "grey cloth": Finish(lambda r: draw_cloth(r, (0.46, 0.48, 0.52)), repeat=4.0, shine=0.0),
    "linen": Finish(lambda r: draw_cloth(r, (0.94, 0.92, 0.88)), repeat=5.0, shine=0.0),
    "blue cloth": Finish(lambda r: draw_cloth(r, (0.28, 0.40, 0.62)), repeat=5.0, shine=0.0),
    "stone": Finish(lambda r: draw_wood(r, (0.30, 0.31, 0.33)), repeat=1.4, shine=0.5),
    "wall tiles": Finish(
        lambda r: draw_tiles(r, (0.84, 0.89, 0.88), metres=(1.0, 1.0), scale=128, side=0.125),
        repeat=1.0,
        shine=0.4,
    ),
    "steel": Finish(colour=(0.70, 0.72, 0.75), shine=0.8),
    "black": Finish(colour=(0.07, 0.07, 0.08), shine=0.4),
    "white": Finish(colour=(0.93, 0.93, 0.92), shine=0.4),
    "red": Finish(colour=(0.80, 0.17, 0.13), shine=0.4),
    "green": Finish(colour=(0.42, 0.62, 0.20), shine=0.3),
    "orange": Finish(colour=(0.95, 0.55, 0.12), shine=0.3),
    "bottle": Finish(colour=(0.10, 0.32, 0.20), shine=0.9),
    "clay": Finish(colour=(0.72, 0.40, 0.27), shine=0.1),
    "leaf": Finish(lambda r: draw_fur(r, (0.20, 0.44, 0.18)), cube=True, shine=0.1),
    "dark leaf": Finish(lambda r: draw_fur(r, (0.12, 0.32, 0.16)), cube=True, shine=0.1),
    "shade": Finish(colour=(0.98, 0.90, 0.72), glow=0.6),
    "books": Finish(book_row, repeat=0.0),
    "window": Finish(draw_view, repeat=0.0, glow=0.55),
    "galaxies": Finish(lambda _: load_photograph("galaxies", frame=None), repeat=0.0, glow=0.45),
    "astronaut": Finish(lambda _: load_photograph("astronaut"), repeat=0.0, glow=0.15),
    "cat": Finish(lambda _: load_photograph("cat"), repeat=0.0, glow=0.15),
    "coffee": Finish(lambda _: load_photograph("coffee"), repeat=0.0, glow=0.15),
    "rocket": Finish(lambda _: load_photograph("rocket"), repeat=0.0, glow=0.15),
    "rug": Finish(
        lambda r: draw_rug(r, ((0.72, 0.33, 0.24), (0.93, 0.86, 0.72)), 512, 340), repeat=0.0
    ),
    "blue rug": Finish(
        lambda r: draw_rug(r, ((0.30, 0.42, 0.56), (0.88, 0.88, 0.84)), 448, 300), repeat=0.0
    ),
}


def add_sofa(at: FloorPose, cloth_name: str = "teal cloth") -> None:
    """Three seats, 2.1 m wide, 0.9 m deep."""
    at.add_solid((-0.45, -1.05, 0.0), (0.45, 1.05, 0.8))
    at.add_box(cloth_name, (-0.45, -1.0, 0.08), (0.43, 1.0, 0.32), 0.05)
    at.add_box(cloth_name, (-0.45, -1.0, 0.2), (-0.2, 1.0, 0.82), 0.09)
    for side in (-1, 1):
        low, high = sorted((side * 0.84, side * 1.05))
        at.add_box(cloth_name, (-0.45, low, 0.08), (0.45, high, 0.60), 0.09)
    for seat in (-1, 0, 1):
        at.add_box(
            cloth_name, (-0.24, seat * 0.56 - 0.275, 0.30), (0.45, seat * 0.56 + 0.275, 0.46), 0.06
        )
    for y, colour in ((0.62, "mustard cloth"), (-0.6, "linen"), (0.3, "linen")):
        at.pose_on(-0.1, y, 0.12 * y).add_box(
            colour, (-0.09, -0.21, 0.45), (0.07, 0.21, 0.80), 0.07
        )
    for x in (-0.4, 0.38):
        for y in (-0.95, 0.95):
            at.add_rod("walnut", (x, y, 0.0), (x, y, 0.1), 0.025, blunt=True)


def add_armchair(at: FloorPose, cloth_name: str = "mustard cloth") -> None:
    """One seat, 0.85 m wide."""
    at.add_solid((-0.4, -0.42, 0.0), (0.4, 0.42, 0.8))
    at.add_box(cloth_name, (-0.38, -0.38, 0.12), (0.38, 0.38, 0.44), 0.09)
    at.add_box(cloth_name, (-0.42, -0.4, 0.2), (-0.2, 0.4, 0.86), 0.10)
    for side in (-1, 1):
        low, high = sorted((side * 0.28, side * 0.43))
        at.add_box(cloth_name, (-0.4, low, 0.12), (0.36, high, 0.58), 0.07)
    for x in (-0.33, 0.33):
        for y in (-0.35, 0.35):
            at.add_rod("walnut", (x, y, 0.0), (x, y, 0.14), 0.02, blunt=True)


def low_table(at: FloorPose) -> None:
    """A chest table, 1.1 m by 0.6 m, with a book and a cup."""
    at.add_box("walnut", (-0.3, -0.55, 0.36), (0.3, 0.55, 0.41), 0.015)
    at.add_box("oak", (-0.26, -0.5, 0.04), (0.26, 0.5, 0.36), 0.01)
    at.add_solid((-0.3, -0.55, 0.0), (0.3, 0.55, 0.41))
    at.pose_on(0.05, 0.22, 0.4).add_box("red", (-0.12, -0.09, 0.41), (0.12, 0.09, 0.44), 0.006)
    at.pose_on(0.05, 0.22, 0.2).add_box("linen", (-0.11, -0.085, 0.44), (0.11, 0.085, 0.46), 0.006)
    add_cup(at.pose_on(-0.05, -0.2), 0.41)


def add_cup(at: FloorPose, height: float) -> None:
    """A cup on a saucer on something ``height`` metres high."""
    at.add_rod("white", (0, 0, height), (0, 0, height + 0.01), 0.075, blunt=True)
    at.add_rod("white", (0, 0, height), (0, 0, height + 0.085), 0.042, blunt=True)
    at.add_rod("walnut", (0, 0, height), (0, 0, height + 0.087), 0.036, blunt=True)
    at.add_rod("white", (0.05, 0, height + 0.03), (0.05, 0, height + 0.06), 0.012)


def add_television(at: FloorPose) -> None:
    """A bench with a screen that shows galaxies."""
    at.add_box("oak", (-0.22, -0.85, 0.06), (0.22, 0.85, 0.45), 0.012, solid=True)
    for door in (-0.56, 0.0, 0.56):
        at.add_box("white wood", (0.215, door - 0.27, 0.09), (0.232, door + 0.27, 0.42), 0.006)
    at.add_box("black", (-0.06, -0.2, 0.45), (0.06, 0.2, 0.49), 0.01)
    at.add_box("black", (-0.03, -0.68, 0.53), (0.03, 0.68, 1.31), 0.012)
    at.add_box("galaxies", (0.026, -0.65, 0.56), (0.034, 0.65, 1.28), 0.002)
    add_plant(at.pose_on(-0.02, 0.76), 0.25, base=0.45)


def add_bookshelf(at: FloorPose) -> None:
    """1.0 m wide, 1.9 m high, full of books."""
    at.add_solid((-0.16, -0.5, 0.0), (0.16, 0.5, 1.9))
    for side in (-1, 1):
        low, high = sorted((side * 0.46, side * 0.5))
        at.add_box("oak", (-0.16, low, 0.0), (0.16, high, 1.9), 0.008)
    for shelf in range(6):
        z = 0.04 + shelf * 0.365
        at.add_box("oak", (-0.16, -0.48, z), (0.16, 0.48, z + 0.035), 0.006)
        if shelf < 5:
            at.add_box("books", (-0.15, -0.46, z + 0.035), (0.08, 0.46, z + 0.34), 0.003)
    at.add_ball("clay", (0.1, 0.3, 1.07), (0.05, 0.05, 0.05))
    add_plant(at.pose_on(0.0, -0.25), 0.3, base=1.9)


def add_plant(at: FloorPose, size: float = 1.0, *, base: float = 0.0) -> None:
    """A pot with leaves, ``size`` metres high; solid when it stands on the floor."""
    # On a table it stands in nobody's way.
    if base == 0.0:
        at.add_post(0, 0, 0.22 * size, 0.36 * size)
    pot = 0.17 * size
    at.add_rod("clay", (0, 0, base), (0, 0, base + 0.30 * size), pot, blunt=True)
    at.add_rod(
        "clay", (0, 0, base + 0.27 * size), (0, 0, base + 0.33 * size), pot * 1.12, blunt=True
    )
    for leaf in range(14):
        # The golden angle (rad): leaves spread all round.
        turn = leaf * 2.399
        rise = 0.35 + 0.60 * ((leaf * 5) % 14) / 14
        reach = 0.10 + 0.22 * (1.15 - rise)
        tip = (reach * size * math.cos(turn), reach * size * math.sin(turn), base + rise * size)
        at.add_rod("dark leaf", (0, 0, base + 0.3 * size), tip, 0.008 * size)
        name = "leaf" if leaf % 3 else "dark leaf"
        at.pose_on(tip[0], tip[1], turn).add_ball(
            name, (0.05 * size, 0, tip[2]), (0.17 * size, 0.07 * size, 0.025 * size), 0.5 * rise
        )


def add_lamp(at: FloorPose) -> None:
    """A standard lamp, 1.6 m."""
    at.add_post(0, 0, 0.16, 0.3)
    at.add_rod("black", (0, 0, 0), (0, 0, 0.03), 0.16, blunt=True)
    at.add_rod("black", (0, 0, 0), (0, 0, 1.4), 0.014)
    at.add_rod("shade", (0, 0, 1.32), (0, 0, 1.62), 0.2, blunt=True)


def add_chair(at: FloorPose, seat: str = "linen") -> None:
    """A kitchen chair with four legs; its place's x points to the table."""
    for x in (-0.19, 0.19):
        for y in (-0.19, 0.19):
            at.add_post(x, y, 0.025, 0.44)
            at.add_rod("oak", (x, y, 0.0), (x * 0.95, y * 0.95, 0.45), 0.019)
    at.add_box("oak", (-0.22, -0.22, 0.43), (0.22, 0.22, 0.46), 0.012)
    at.add_box(seat, (-0.20, -0.20, 0.455), (0.20, 0.20, 0.49), 0.016)
    for y in (-0.18, 0.18):
        at.add_rod("oak", (-0.2, y, 0.45), (-0.25, y, 0.92), 0.017)
    at.add_box("oak", (-0.26, -0.2, 0.76), (-0.225, 0.2, 0.93), 0.012)
    at.add_box("oak", (-0.25, -0.2, 0.60), (-0.22, 0.2, 0.66), 0.012)


def dining_table(at: FloorPose) -> None:
    """1.5 m by 0.85 m, laid for breakfast."""
    for x in (-0.66, 0.66):
        for y in (-0.34, 0.34):
            at.add_post(x, y, 0.04, 0.7)
            at.add_rod("oak", (x, y, 0.0), (x, y, 0.72), 0.035, blunt=True)
    at.add_box("oak", (-0.75, -0.43, 0.71), (0.75, 0.43, 0.75), 0.014)
    at.add_rod("white", (0, 0, 0.75), (0, 0, 0.79), 0.15, blunt=True)
    for fruit, (x, y) in zip(
        ("orange", "green", "red", "orange"),
        ((0.05, 0.04), (-0.06, 0.03), (0.0, -0.06), (0, 0)),
        strict=True,
    ):
        z = 0.83 if (x, y) != (0, 0) else 0.89
        at.add_ball(fruit, (x, y, z), (0.045, 0.045, 0.043))
    at.add_rod("bottle", (0.4, 0.1, 0.75), (0.4, 0.1, 0.95), 0.038, blunt=True)
    at.add_rod("bottle", (0.4, 0.1, 0.95), (0.4, 0.1, 1.04), 0.014)
    add_cup(at.pose_on(-0.42, 0.15), 0.75)
    add_cup(at.pose_on(0.35, -0.2), 0.75)


def add_counter(at: FloorPose, length: float) -> None:
    """Kitchen cupboards with a worktop along y, ``length`` metres, hob, sink and tiles behind."""
    half = length / 2
    at.add_box("black", (-0.28, -half, 0.0), (0.24, half, 0.10), 0.004)
    at.add_box("sage", (-0.30, -half, 0.09), (0.28, half, 0.86), 0.004)
    at.add_solid((-0.30, -half, 0.0), (0.31, half, 0.9))
    at.add_box("stone", (-0.30, -half - 0.01, 0.86), (0.32, half + 0.01, 0.90), 0.008)
    doors = max(1, round(length / 0.6))
    wide = length / doors
    for door in range(doors):
        y = -half + door * wide
        at.add_box("sage", (0.275, y + 0.01, 0.12), (0.300, y + wide - 0.01, 0.83), 0.006)
        at.add_rod("steel", (0.315, y + wide - 0.08, 0.62), (0.315, y + wide - 0.08, 0.76), 0.008)
    at.add_box("wall tiles", (-0.302, -half, 0.9), (-0.292, half, 1.5), 0.002)
    at.add_box("black", (-0.22, 0.35, 0.9), (0.24, 0.95, 0.908), 0.003)
    at.add_rod("steel", (0.0, 0.65, 0.91), (0.0, 0.65, 1.03), 0.11, blunt=True)
    at.add_box("steel", (-0.2, -0.95, 0.895), (0.2, -0.35, 0.905), 0.004)
    at.add_rod("steel", (-0.2, -0.65, 0.9), (-0.2, -0.65, 1.15), 0.014)
    at.add_rod("steel", (-0.2, -0.65, 1.15), (-0.02, -0.65, 1.13), 0.012)
    add_plant(at.pose_on(-0.1, -half + 0.25), 0.32, base=0.9)


def add_cupboards(at: FloorPose, length: float) -> None:
    """Wall cupboards above a counter, ``length`` metres along y."""
    half = length / 2
    doors = max(1, round(length / 0.6))
    wide = length / doors
    at.add_box("white wood", (-0.17, -half, 1.5), (0.15, half, 2.15), 0.004)
    for door in range(doors):
        y = -half + door * wide
        at.add_box("white wood", (0.145, y + 0.008, 1.51), (0.168, y + wide - 0.008, 2.14), 0.005)


def add_fridge(at: FloorPose) -> None:
    """1.8 m high, with drawings and magnets."""
    at.add_box("white", (-0.32, -0.32, 0.02), (0.30, 0.32, 1.8), 0.03, solid=True)
    at.add_box("steel", (0.295, -0.315, 0.03), (0.325, 0.315, 0.65), 0.012)
    at.add_box("steel", (0.295, -0.315, 0.67), (0.325, 0.315, 1.79), 0.012)
    for low, high in ((0.45, 0.62), (0.75, 1.1)):
        at.add_rod("black", (0.35, 0.26, low), (0.35, 0.26, high), 0.012)
    at.add_box("linen", (0.322, -0.15, 1.2), (0.328, 0.05, 1.45), 0.002)
    at.add_box("red", (0.325, -0.07, 1.43), (0.338, -0.04, 1.46), 0.004)


def add_bed(at: FloorPose) -> None:
    """1.6 m by 2.05 m, head at -x."""
    at.add_solid((-1.05, -0.82, 0.0), (1.02, 0.82, 0.5))
    at.add_box("walnut", (-1.05, -0.85, 0.05), (-0.98, 0.85, 1.05), 0.03)
    at.add_box("walnut", (-1.0, -0.82, 0.10), (1.02, 0.82, 0.28), 0.02)
    at.add_box("linen", (-0.97, -0.79, 0.25), (1.0, 0.79, 0.48), 0.07)
    at.add_box("blue cloth", (-0.35, -0.84, 0.20), (1.04, 0.84, 0.53), 0.06)
    at.add_box("linen", (-0.50, -0.83, 0.42), (-0.32, 0.83, 0.545), 0.05)
    for y in (-0.4, 0.4):
        at.pose_on(-0.76, y, 0.06 * y).add_box(
            "linen", (-0.19, -0.32, 0.46), (0.19, 0.32, 0.62), 0.075
        )
    at.pose_on(-0.6, 0.0).add_box("mustard cloth", (-0.07, -0.2, 0.50), (0.07, 0.2, 0.72), 0.06)


def add_wardrobe(at: FloorPose) -> None:
    """1.5 m wide, 2 m high."""
    at.add_box("white wood", (-0.29, -0.75, 0.03), (0.28, 0.75, 2.05), 0.012, solid=True)
    for y in (-0.5, 0.0, 0.5):
        at.add_box("oak", (0.275, y - 0.245, 0.08), (0.297, y + 0.245, 2.0), 0.008)
        at.add_rod("black", (0.31, y + 0.2, 0.95), (0.31, y + 0.2, 1.15), 0.009)


def add_desk(at: FloorPose) -> None:
    """A desk along y with a screen, a keyboard and a lamp; one sits at +x."""
    for y in (-0.66, 0.66):
        for x in (-0.28, 0.28):
            at.add_post(x, y, 0.03, 0.7)
            at.add_rod("black", (x, y, 0.0), (x, y, 0.72), 0.022, blunt=True)
    at.add_box("oak", (-0.33, -0.72, 0.71), (0.33, 0.72, 0.745), 0.012)
    at.add_box("black", (-0.2, -0.1, 0.745), (-0.02, 0.1, 0.755), 0.004)
    at.add_rod("black", (-0.12, 0, 0.75), (-0.12, 0, 0.95), 0.02)
    at.add_box("black", (-0.13, -0.33, 0.86), (-0.10, 0.33, 1.25), 0.008)
    at.add_box("galaxies", (-0.104, -0.315, 0.875), (-0.096, 0.315, 1.235), 0.002)
    at.add_box("white", (0.06, -0.21, 0.745), (0.2, 0.21, 0.765), 0.006)
    at.add_rod("black", (-0.15, 0.58, 0.745), (-0.15, 0.58, 1.05), 0.012)
    at.add_rod("shade", (-0.15, 0.58, 1.02), (-0.15, 0.58, 1.17), 0.09, blunt=True)
    add_cup(at.pose_on(0.1, -0.45), 0.745)


def office_chair(at: FloorPose) -> None:
    """On a star of castors; the lidar sees its column as a round post."""
    # One post for all five legs: the vehicle has to keep off the whole star.
    at.add_post(0, 0, 0.3, 0.35)
    for leg in range(5):
        turn = leg * 2 * math.pi / 5
        end = (0.28 * math.cos(turn), 0.28 * math.sin(turn))
        at.add_rod("black", (0, 0, 0.12), (*end, 0.07), 0.02)
        at.add_ball("black", (*end, 0.035), (0.03, 0.03, 0.03))
    at.add_rod("steel", (0, 0, 0.1), (0, 0, 0.45), 0.025, blunt=True)
    at.add_box("grey cloth", (-0.24, -0.24, 0.44), (0.24, 0.24, 0.53), 0.04)
    at.add_box("grey cloth", (-0.28, -0.22, 0.58), (-0.20, 0.22, 1.12), 0.04)


def add_bath(at: FloorPose) -> None:
    """A tub, 1.7 m along y."""
    at.add_solid((-0.38, -0.85, 0.0), (0.38, 0.85, 0.58))
    at.add_box("white", (-0.38, -0.85, 0.0), (0.38, 0.85, 0.50), 0.05)
    for x in (-0.35, 0.30):
        at.add_box("white", (x, -0.85, 0.45), (x + 0.05, 0.85, 0.58), 0.02)
    for y in (-0.85, 0.78):
        at.add_box("white", (-0.36, y, 0.45), (0.36, y + 0.07, 0.58), 0.02)
    at.add_box("blue cloth", (0.30, 0.2, 0.30), (0.405, 0.6, 0.60), 0.02)


def add_washstand(at: FloorPose) -> None:
    """A basin on a cupboard with a mirror above."""
    at.add_box("oak", (-0.22, -0.4, 0.05), (0.22, 0.4, 0.78), 0.01, solid=True)
    at.add_box("white", (-0.24, -0.42, 0.78), (0.25, 0.42, 0.90), 0.04)
    at.add_rod("steel", (-0.16, 0, 0.9), (-0.16, 0, 1.05), 0.014)
    at.add_rod("steel", (-0.16, 0, 1.05), (-0.02, 0, 1.04), 0.012)
    at.add_box("steel", (-0.235, -0.35, 1.15), (-0.225, 0.35, 1.95), 0.004)
    at.add_rod("red", (0.1, 0.3, 0.9), (0.1, 0.3, 1.0), 0.03, blunt=True)


def add_painting(at: FloorPose, finish: str, *, width: float, height: float, z: float) -> None:
    """A picture on the wall behind the place, its centre ``z`` metres high."""
    at.add_box(finish, (0.0, -width / 2, z - height / 2), (0.03, width / 2, z + height / 2), 0.003)


def add_window(at: FloorPose, width: float, z: float = 1.45) -> None:
    """A window with a sill and curtains."""
    at.add_box("window", (0.0, -width / 2, z - 0.6), (0.025, width / 2, z + 0.6), 0.003)
    at.add_box(
        "white wood", (0.0, -width / 2 - 0.08, z - 0.66), (0.16, width / 2 + 0.08, z - 0.61), 0.01
    )
    at.add_rod(
        "black", (0.09, -width / 2 - 0.3, z + 0.72), (0.09, width / 2 + 0.3, z + 0.72), 0.012
    )
    for side in (-1, 1):
        for fold in range(4):
            y = side * (width / 2 - 0.02 + fold * 0.075)
            at.add_rod("linen", (0.075 + 0.02 * (fold % 2), y, 0.25), (0.09, y, z + 0.70), 0.042)
