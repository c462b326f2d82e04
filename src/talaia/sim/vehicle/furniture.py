"""The things that stand in the house. Each function builds one, facing the place's own x axis.

Longer than other files because it is a list: one short function for each thing, none calls many.
"""

from __future__ import annotations

import math

from talaia.sim.vehicle.scene import Finish, FloorPose
from talaia.sim.vehicle.textures import book_row, cloth, fur, photograph, rug, tiles, view, wood

__all__ = [
    "FINISHES",
    "armchair",
    "bath",
    "bed",
    "bookshelf",
    "chair",
    "counter",
    "cupboards",
    "desk",
    "dining_table",
    "fridge",
    "lamp",
    "low_table",
    "office_chair",
    "painting",
    "plant",
    "sofa",
    "television",
    "wardrobe",
    "washstand",
    "window",
]

# By the names that the things below are made of; house and occupants add their own.
FINISHES: dict[str, Finish] = {
    "oak": Finish(lambda r: wood(r, (0.74, 0.56, 0.36)), repeat=1.0, shine=0.15),
    "walnut": Finish(lambda r: wood(r, (0.43, 0.29, 0.19)), repeat=1.0, shine=0.2),
    "white wood": Finish(colour=(0.93, 0.92, 0.89), shine=0.2),
    "sage": Finish(colour=(0.53, 0.62, 0.54), shine=0.25),
    "teal cloth": Finish(lambda r: cloth(r, (0.16, 0.42, 0.45)), repeat=4.0, shine=0.0),
    "mustard cloth": Finish(lambda r: cloth(r, (0.84, 0.62, 0.20)), repeat=4.0, shine=0.0),
    "grey cloth": Finish(lambda r: cloth(r, (0.46, 0.48, 0.52)), repeat=4.0, shine=0.0),
    "linen": Finish(lambda r: cloth(r, (0.94, 0.92, 0.88)), repeat=5.0, shine=0.0),
    "blue cloth": Finish(lambda r: cloth(r, (0.28, 0.40, 0.62)), repeat=5.0, shine=0.0),
    "stone": Finish(lambda r: wood(r, (0.30, 0.31, 0.33)), repeat=1.4, shine=0.5),
    "wall tiles": Finish(
        lambda r: tiles(r, (0.84, 0.89, 0.88), metres=(1.0, 1.0), scale=128, side=0.125),
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
    "leaf": Finish(lambda r: fur(r, (0.20, 0.44, 0.18)), cube=True, shine=0.1),
    "dark leaf": Finish(lambda r: fur(r, (0.12, 0.32, 0.16)), cube=True, shine=0.1),
    "shade": Finish(colour=(0.98, 0.90, 0.72), glow=0.6),
    "books": Finish(book_row, repeat=0.0),
    "window": Finish(view, repeat=0.0, glow=0.55),
    "galaxies": Finish(lambda _: photograph("galaxies", frame=None), repeat=0.0, glow=0.45),
    "astronaut": Finish(lambda _: photograph("astronaut"), repeat=0.0, glow=0.15),
    "cat": Finish(lambda _: photograph("cat"), repeat=0.0, glow=0.15),
    "coffee": Finish(lambda _: photograph("coffee"), repeat=0.0, glow=0.15),
    "rocket": Finish(lambda _: photograph("rocket"), repeat=0.0, glow=0.15),
    "rug": Finish(lambda r: rug(r, ((0.72, 0.33, 0.24), (0.93, 0.86, 0.72)), 512, 340), repeat=0.0),
    "blue rug": Finish(
        lambda r: rug(r, ((0.30, 0.42, 0.56), (0.88, 0.88, 0.84)), 448, 300), repeat=0.0
    ),
}


def sofa(at: FloorPose, cloth_name: str = "teal cloth") -> None:
    """Three seats, 2.1 m wide, 0.9 m deep."""
    at.solid((-0.45, -1.05, 0.0), (0.45, 1.05, 0.8))
    at.box(cloth_name, (-0.45, -1.0, 0.08), (0.43, 1.0, 0.32), 0.05)
    at.box(cloth_name, (-0.45, -1.0, 0.2), (-0.2, 1.0, 0.82), 0.09)
    for side in (-1, 1):
        low, high = sorted((side * 0.84, side * 1.05))
        at.box(cloth_name, (-0.45, low, 0.08), (0.45, high, 0.60), 0.09)
    for seat in (-1, 0, 1):
        at.box(
            cloth_name, (-0.24, seat * 0.56 - 0.275, 0.30), (0.45, seat * 0.56 + 0.275, 0.46), 0.06
        )
    for y, colour in ((0.62, "mustard cloth"), (-0.6, "linen"), (0.3, "linen")):
        at.on(-0.1, y, 0.12 * y).box(colour, (-0.09, -0.21, 0.45), (0.07, 0.21, 0.80), 0.07)
    for x in (-0.4, 0.38):
        for y in (-0.95, 0.95):
            at.rod("walnut", (x, y, 0.0), (x, y, 0.1), 0.025, blunt=True)


def armchair(at: FloorPose, cloth_name: str = "mustard cloth") -> None:
    """One seat, 0.85 m wide."""
    at.solid((-0.4, -0.42, 0.0), (0.4, 0.42, 0.8))
    at.box(cloth_name, (-0.38, -0.38, 0.12), (0.38, 0.38, 0.44), 0.09)
    at.box(cloth_name, (-0.42, -0.4, 0.2), (-0.2, 0.4, 0.86), 0.10)
    for side in (-1, 1):
        low, high = sorted((side * 0.28, side * 0.43))
        at.box(cloth_name, (-0.4, low, 0.12), (0.36, high, 0.58), 0.07)
    for x in (-0.33, 0.33):
        for y in (-0.35, 0.35):
            at.rod("walnut", (x, y, 0.0), (x, y, 0.14), 0.02, blunt=True)


def low_table(at: FloorPose) -> None:
    """A chest table, 1.1 m by 0.6 m, with a book and a cup."""
    at.box("walnut", (-0.3, -0.55, 0.36), (0.3, 0.55, 0.41), 0.015)
    at.box("oak", (-0.26, -0.5, 0.04), (0.26, 0.5, 0.36), 0.01)
    at.solid((-0.3, -0.55, 0.0), (0.3, 0.55, 0.41))
    at.on(0.05, 0.22, 0.4).box("red", (-0.12, -0.09, 0.41), (0.12, 0.09, 0.44), 0.006)
    at.on(0.05, 0.22, 0.2).box("linen", (-0.11, -0.085, 0.44), (0.11, 0.085, 0.46), 0.006)
    cup(at.on(-0.05, -0.2), 0.41)


def cup(at: FloorPose, height: float) -> None:
    """A cup on a saucer on something ``height`` metres high."""
    at.rod("white", (0, 0, height), (0, 0, height + 0.01), 0.075, blunt=True)
    at.rod("white", (0, 0, height), (0, 0, height + 0.085), 0.042, blunt=True)
    at.rod("walnut", (0, 0, height), (0, 0, height + 0.087), 0.036, blunt=True)
    at.rod("white", (0.05, 0, height + 0.03), (0.05, 0, height + 0.06), 0.012)


def television(at: FloorPose) -> None:
    """A bench with a screen that shows galaxies."""
    at.box("oak", (-0.22, -0.85, 0.06), (0.22, 0.85, 0.45), 0.012, solid=True)
    for door in (-0.56, 0.0, 0.56):
        at.box("white wood", (0.215, door - 0.27, 0.09), (0.232, door + 0.27, 0.42), 0.006)
    at.box("black", (-0.06, -0.2, 0.45), (0.06, 0.2, 0.49), 0.01)
    at.box("black", (-0.03, -0.68, 0.53), (0.03, 0.68, 1.31), 0.012)
    at.box("galaxies", (0.026, -0.65, 0.56), (0.034, 0.65, 1.28), 0.002)
    plant(at.on(-0.02, 0.76), 0.25, base=0.45)


def bookshelf(at: FloorPose) -> None:
    """1.0 m wide, 1.9 m high, full of books."""
    at.solid((-0.16, -0.5, 0.0), (0.16, 0.5, 1.9))
    for side in (-1, 1):
        low, high = sorted((side * 0.46, side * 0.5))
        at.box("oak", (-0.16, low, 0.0), (0.16, high, 1.9), 0.008)
    for shelf in range(6):
        z = 0.04 + shelf * 0.365
        at.box("oak", (-0.16, -0.48, z), (0.16, 0.48, z + 0.035), 0.006)
        if shelf < 5:
            at.box("books", (-0.15, -0.46, z + 0.035), (0.08, 0.46, z + 0.34), 0.003)
    at.ball("clay", (0.1, 0.3, 1.07), (0.05, 0.05, 0.05))
    plant(at.on(0.0, -0.25), 0.3, base=1.9)


def plant(at: FloorPose, size: float = 1.0, *, base: float = 0.0) -> None:
    """A pot with leaves, ``size`` metres high; solid when it stands on the floor."""
    # On a table it stands in nobody's way.
    if base == 0.0:
        at.post(0, 0, 0.22 * size, 0.36 * size)
    pot = 0.17 * size
    at.rod("clay", (0, 0, base), (0, 0, base + 0.30 * size), pot, blunt=True)
    at.rod("clay", (0, 0, base + 0.27 * size), (0, 0, base + 0.33 * size), pot * 1.12, blunt=True)
    for leaf in range(14):
        # The golden angle (rad): leaves spread all round.
        turn = leaf * 2.399
        rise = 0.35 + 0.60 * ((leaf * 5) % 14) / 14
        reach = 0.10 + 0.22 * (1.15 - rise)
        tip = (reach * size * math.cos(turn), reach * size * math.sin(turn), base + rise * size)
        at.rod("dark leaf", (0, 0, base + 0.3 * size), tip, 0.008 * size)
        name = "leaf" if leaf % 3 else "dark leaf"
        at.on(tip[0], tip[1], turn).ball(
            name, (0.05 * size, 0, tip[2]), (0.17 * size, 0.07 * size, 0.025 * size), 0.5 * rise
        )


def lamp(at: FloorPose) -> None:
    """A standard lamp, 1.6 m."""
    at.post(0, 0, 0.16, 0.3)
    at.rod("black", (0, 0, 0), (0, 0, 0.03), 0.16, blunt=True)
    at.rod("black", (0, 0, 0), (0, 0, 1.4), 0.014)
    at.rod("shade", (0, 0, 1.32), (0, 0, 1.62), 0.2, blunt=True)


def chair(at: FloorPose, seat: str = "linen") -> None:
    """A kitchen chair with four legs; its place's x points to the table."""
    for x in (-0.19, 0.19):
        for y in (-0.19, 0.19):
            at.post(x, y, 0.025, 0.44)
            at.rod("oak", (x, y, 0.0), (x * 0.95, y * 0.95, 0.45), 0.019)
    at.box("oak", (-0.22, -0.22, 0.43), (0.22, 0.22, 0.46), 0.012)
    at.box(seat, (-0.20, -0.20, 0.455), (0.20, 0.20, 0.49), 0.016)
    for y in (-0.18, 0.18):
        at.rod("oak", (-0.2, y, 0.45), (-0.25, y, 0.92), 0.017)
    at.box("oak", (-0.26, -0.2, 0.76), (-0.225, 0.2, 0.93), 0.012)
    at.box("oak", (-0.25, -0.2, 0.60), (-0.22, 0.2, 0.66), 0.012)


def dining_table(at: FloorPose) -> None:
    """1.5 m by 0.85 m, laid for breakfast."""
    for x in (-0.66, 0.66):
        for y in (-0.34, 0.34):
            at.post(x, y, 0.04, 0.7)
            at.rod("oak", (x, y, 0.0), (x, y, 0.72), 0.035, blunt=True)
    at.box("oak", (-0.75, -0.43, 0.71), (0.75, 0.43, 0.75), 0.014)
    at.rod("white", (0, 0, 0.75), (0, 0, 0.79), 0.15, blunt=True)
    for fruit, (x, y) in zip(
        ("orange", "green", "red", "orange"),
        ((0.05, 0.04), (-0.06, 0.03), (0.0, -0.06), (0, 0)),
        strict=True,
    ):
        z = 0.83 if (x, y) != (0, 0) else 0.89
        at.ball(fruit, (x, y, z), (0.045, 0.045, 0.043))
    at.rod("bottle", (0.4, 0.1, 0.75), (0.4, 0.1, 0.95), 0.038, blunt=True)
    at.rod("bottle", (0.4, 0.1, 0.95), (0.4, 0.1, 1.04), 0.014)
    cup(at.on(-0.42, 0.15), 0.75)
    cup(at.on(0.35, -0.2), 0.75)


def counter(at: FloorPose, length: float) -> None:
    """Kitchen cupboards with a worktop along y, ``length`` metres, hob, sink and tiles behind."""
    half = length / 2
    at.box("black", (-0.28, -half, 0.0), (0.24, half, 0.10), 0.004)
    at.box("sage", (-0.30, -half, 0.09), (0.28, half, 0.86), 0.004)
    at.solid((-0.30, -half, 0.0), (0.31, half, 0.9))
    at.box("stone", (-0.30, -half - 0.01, 0.86), (0.32, half + 0.01, 0.90), 0.008)
    doors = max(1, round(length / 0.6))
    wide = length / doors
    for door in range(doors):
        y = -half + door * wide
        at.box("sage", (0.275, y + 0.01, 0.12), (0.300, y + wide - 0.01, 0.83), 0.006)
        at.rod("steel", (0.315, y + wide - 0.08, 0.62), (0.315, y + wide - 0.08, 0.76), 0.008)
    at.box("wall tiles", (-0.302, -half, 0.9), (-0.292, half, 1.5), 0.002)
    at.box("black", (-0.22, 0.35, 0.9), (0.24, 0.95, 0.908), 0.003)
    at.rod("steel", (0.0, 0.65, 0.91), (0.0, 0.65, 1.03), 0.11, blunt=True)
    at.box("steel", (-0.2, -0.95, 0.895), (0.2, -0.35, 0.905), 0.004)
    at.rod("steel", (-0.2, -0.65, 0.9), (-0.2, -0.65, 1.15), 0.014)
    at.rod("steel", (-0.2, -0.65, 1.15), (-0.02, -0.65, 1.13), 0.012)
    plant(at.on(-0.1, -half + 0.25), 0.32, base=0.9)


def cupboards(at: FloorPose, length: float) -> None:
    """Wall cupboards above a counter, ``length`` metres along y."""
    half = length / 2
    doors = max(1, round(length / 0.6))
    wide = length / doors
    at.box("white wood", (-0.17, -half, 1.5), (0.15, half, 2.15), 0.004)
    for door in range(doors):
        y = -half + door * wide
        at.box("white wood", (0.145, y + 0.008, 1.51), (0.168, y + wide - 0.008, 2.14), 0.005)


def fridge(at: FloorPose) -> None:
    """1.8 m high, with drawings and magnets."""
    at.box("white", (-0.32, -0.32, 0.02), (0.30, 0.32, 1.8), 0.03, solid=True)
    at.box("steel", (0.295, -0.315, 0.03), (0.325, 0.315, 0.65), 0.012)
    at.box("steel", (0.295, -0.315, 0.67), (0.325, 0.315, 1.79), 0.012)
    for low, high in ((0.45, 0.62), (0.75, 1.1)):
        at.rod("black", (0.35, 0.26, low), (0.35, 0.26, high), 0.012)
    at.box("linen", (0.322, -0.15, 1.2), (0.328, 0.05, 1.45), 0.002)
    at.box("red", (0.325, -0.07, 1.43), (0.338, -0.04, 1.46), 0.004)


def bed(at: FloorPose) -> None:
    """1.6 m by 2.05 m, head at -x."""
    at.solid((-1.05, -0.82, 0.0), (1.02, 0.82, 0.5))
    at.box("walnut", (-1.05, -0.85, 0.05), (-0.98, 0.85, 1.05), 0.03)
    at.box("walnut", (-1.0, -0.82, 0.10), (1.02, 0.82, 0.28), 0.02)
    at.box("linen", (-0.97, -0.79, 0.25), (1.0, 0.79, 0.48), 0.07)
    at.box("blue cloth", (-0.35, -0.84, 0.20), (1.04, 0.84, 0.53), 0.06)
    at.box("linen", (-0.50, -0.83, 0.42), (-0.32, 0.83, 0.545), 0.05)
    for y in (-0.4, 0.4):
        at.on(-0.76, y, 0.06 * y).box("linen", (-0.19, -0.32, 0.46), (0.19, 0.32, 0.62), 0.075)
    at.on(-0.6, 0.0).box("mustard cloth", (-0.07, -0.2, 0.50), (0.07, 0.2, 0.72), 0.06)


def wardrobe(at: FloorPose) -> None:
    """1.5 m wide, 2 m high."""
    at.box("white wood", (-0.29, -0.75, 0.03), (0.28, 0.75, 2.05), 0.012, solid=True)
    for y in (-0.5, 0.0, 0.5):
        at.box("oak", (0.275, y - 0.245, 0.08), (0.297, y + 0.245, 2.0), 0.008)
        at.rod("black", (0.31, y + 0.2, 0.95), (0.31, y + 0.2, 1.15), 0.009)


def desk(at: FloorPose) -> None:
    """A desk along y with a screen, a keyboard and a lamp; one sits at +x."""
    for y in (-0.66, 0.66):
        for x in (-0.28, 0.28):
            at.post(x, y, 0.03, 0.7)
            at.rod("black", (x, y, 0.0), (x, y, 0.72), 0.022, blunt=True)
    at.box("oak", (-0.33, -0.72, 0.71), (0.33, 0.72, 0.745), 0.012)
    at.box("black", (-0.2, -0.1, 0.745), (-0.02, 0.1, 0.755), 0.004)
    at.rod("black", (-0.12, 0, 0.75), (-0.12, 0, 0.95), 0.02)
    at.box("black", (-0.13, -0.33, 0.86), (-0.10, 0.33, 1.25), 0.008)
    at.box("galaxies", (-0.104, -0.315, 0.875), (-0.096, 0.315, 1.235), 0.002)
    at.box("white", (0.06, -0.21, 0.745), (0.2, 0.21, 0.765), 0.006)
    at.rod("black", (-0.15, 0.58, 0.745), (-0.15, 0.58, 1.05), 0.012)
    at.rod("shade", (-0.15, 0.58, 1.02), (-0.15, 0.58, 1.17), 0.09, blunt=True)
    cup(at.on(0.1, -0.45), 0.745)


def office_chair(at: FloorPose) -> None:
    """On a star of castors; the lidar sees its column as a round post."""
    # One post for all five legs: the vehicle has to keep off the whole star.
    at.post(0, 0, 0.3, 0.35)
    for leg in range(5):
        turn = leg * 2 * math.pi / 5
        end = (0.28 * math.cos(turn), 0.28 * math.sin(turn))
        at.rod("black", (0, 0, 0.12), (*end, 0.07), 0.02)
        at.ball("black", (*end, 0.035), (0.03, 0.03, 0.03))
    at.rod("steel", (0, 0, 0.1), (0, 0, 0.45), 0.025, blunt=True)
    at.box("grey cloth", (-0.24, -0.24, 0.44), (0.24, 0.24, 0.53), 0.04)
    at.box("grey cloth", (-0.28, -0.22, 0.58), (-0.20, 0.22, 1.12), 0.04)


def bath(at: FloorPose) -> None:
    """A tub, 1.7 m along y."""
    at.solid((-0.38, -0.85, 0.0), (0.38, 0.85, 0.58))
    at.box("white", (-0.38, -0.85, 0.0), (0.38, 0.85, 0.50), 0.05)
    for x in (-0.35, 0.30):
        at.box("white", (x, -0.85, 0.45), (x + 0.05, 0.85, 0.58), 0.02)
    for y in (-0.85, 0.78):
        at.box("white", (-0.36, y, 0.45), (0.36, y + 0.07, 0.58), 0.02)
    at.box("blue cloth", (0.30, 0.2, 0.30), (0.405, 0.6, 0.60), 0.02)


def washstand(at: FloorPose) -> None:
    """A basin on a cupboard with a mirror above."""
    at.box("oak", (-0.22, -0.4, 0.05), (0.22, 0.4, 0.78), 0.01, solid=True)
    at.box("white", (-0.24, -0.42, 0.78), (0.25, 0.42, 0.90), 0.04)
    at.rod("steel", (-0.16, 0, 0.9), (-0.16, 0, 1.05), 0.014)
    at.rod("steel", (-0.16, 0, 1.05), (-0.02, 0, 1.04), 0.012)
    at.box("steel", (-0.235, -0.35, 1.15), (-0.225, 0.35, 1.95), 0.004)
    at.rod("red", (0.1, 0.3, 0.9), (0.1, 0.3, 1.0), 0.03, blunt=True)


def painting(at: FloorPose, finish: str, *, width: float, height: float, z: float) -> None:
    """A picture on the wall behind the place, its centre ``z`` metres high."""
    at.box(finish, (0.0, -width / 2, z - height / 2), (0.03, width / 2, z + height / 2), 0.003)


def window(at: FloorPose, width: float, z: float = 1.45) -> None:
    """A window with a sill and curtains."""
    at.box("window", (0.0, -width / 2, z - 0.6), (0.025, width / 2, z + 0.6), 0.003)
    at.box(
        "white wood", (0.0, -width / 2 - 0.08, z - 0.66), (0.16, width / 2 + 0.08, z - 0.61), 0.01
    )
    at.rod("black", (0.09, -width / 2 - 0.3, z + 0.72), (0.09, width / 2 + 0.3, z + 0.72), 0.012)
    for side in (-1, 1):
        for fold in range(4):
            y = side * (width / 2 - 0.02 + fold * 0.075)
            at.rod("linen", (0.075 + 0.02 * (fold % 2), y, 0.25), (0.09, y, z + 0.70), 0.042)
