"""Surfaces of the house, made from noise: each function gives an RGB picture, no files needed.

All pictures are ``uint8`` arrays of shape (height, width, 3), row 0 at the top.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import numpy.typing as npt
from PIL import Image, ImageDraw, ImageFilter

__all__ = [
    "Picture",
    "book_row",
    "draw_cloth",
    "draw_fur",
    "draw_parquet",
    "draw_plaster",
    "draw_rug",
    "draw_tiles",
    "draw_view",
    "draw_wood",
    "load_photograph",
    "shade_floor",
]

Picture = npt.NDArray[np.uint8]
Field = npt.NDArray[np.float64]
Colour = tuple[float, float, float]

PICTURES = Path(__file__).parent / "pictures"


def _smooth_noise(
    rng: np.random.Generator, height: int, width: int, coarse: tuple[int, int]
) -> Field:
    """Give smooth noise of mean 0 and deviation about 1, blotches of ``coarse`` pixels."""
    rows = max(2, height // coarse[0])
    columns = max(2, width // coarse[1])
    small = rng.normal(size=(rows, columns))
    scaled = Image.fromarray(small.astype(np.float32)).resize(
        (width, height), Image.Resampling.BICUBIC
    )
    return np.asarray(scaled, dtype=np.float64)


def _shaded_colour(colour: Colour, light: Field) -> Picture:
    """Give a colour (0..1) its brightness at each pixel."""
    rgb = np.asarray(colour)[None, None, :] * light[:, :, None]
    return (np.clip(rgb, 0.0, 1.0) * 255.0).astype(np.uint8)


def draw_wood(rng: np.random.Generator, colour: Colour, size: int = 256) -> Picture:
    """Grain along the width."""
    light = 1.0 + 0.05 * _smooth_noise(rng, size, size, (3, size // 2))
    light += 0.05 * _smooth_noise(rng, size, size, (12, size)) + 0.02 * rng.normal(
        size=(size, size)
    )
    return _shaded_colour(colour, light)


def draw_cloth(rng: np.random.Generator, colour: Colour, size: int = 128) -> Picture:
    """A woven fabric: threads two pixels wide."""
    rows, columns = np.indices((size, size))
    weave = np.where((rows // 2 + columns // 2) % 2 == 0, 1.04, 0.95)
    light = (
        weave
        + 0.03 * rng.normal(size=(size, size))
        + 0.02 * _smooth_noise(rng, size, size, (16, 16))
    )
    return _shaded_colour(colour, light)


def draw_fur(rng: np.random.Generator, colour: Colour, size: int = 64) -> Picture:
    """Short strokes, lighter and darker; six pictures below each other for a cube."""
    faces = []
    for _ in range(6):
        light = (
            1.0
            + 0.07 * _smooth_noise(rng, size, size, (5, 2))
            + 0.05 * rng.normal(size=(size, size))
        )
        light += 0.04 * _smooth_noise(rng, size, size, (24, 24))
        faces.append(_shaded_colour(colour, light))
    return np.concatenate(faces)


def draw_plaster(
    rng: np.random.Generator,
    colour: Colour,
    metres: tuple[float, float],
    corners: tuple[bool, bool],
) -> Picture:
    """A painted wall ``metres`` wide and high, darker towards ceiling, floor and inner corners."""
    # 64 pixels a metre.
    width, height = (max(8, int(64 * m)) for m in metres)
    up = np.linspace(metres[1], 0.0, height)[:, None]
    along = np.linspace(0.0, metres[0], width)[None, :]
    light = 1.0 - 0.20 * np.exp(-up / 0.30) - 0.16 * np.exp(-(metres[1] - up) / 0.35)
    light = light * np.ones((1, width))
    if corners[0]:
        light *= 1.0 - 0.18 * np.exp(-along / 0.30)
    if corners[1]:
        light *= 1.0 - 0.18 * np.exp(-(metres[0] - along) / 0.30)
    light += 0.008 * _smooth_noise(rng, height, width, (20, 20)) + 0.008 * rng.normal(
        size=(height, width)
    )
    return _shaded_colour(colour, light)


def draw_parquet(
    rng: np.random.Generator, colour: Colour, metres: tuple[float, float], scale: int
) -> Picture:
    """Boards of 14 cm by 1.2 m, each of its own tone, with joints; ``scale`` pixels a metre."""
    width, height = int(metres[0] * scale), int(metres[1] * scale)
    rows, columns = np.indices((height, width))
    board = max(2, int(0.14 * scale))
    length = int(1.2 * scale)
    row = rows // board
    # By a large prime, so that the joints of the rows make no steps.
    shift = (row * 7919) % length
    column = (columns + shift) // length
    tones = rng.normal(1.0, 0.055, size=(row.max() + 1, column.max() + 1))
    light = tones[row, column]
    light = light + 0.035 * _smooth_noise(rng, height, width, (3, scale // 2))
    light += 0.015 * rng.normal(size=(height, width))
    light[(rows % board) == 0] *= 0.72
    light[((columns + shift) % length) == 0] *= 0.72
    return _shaded_colour(colour, light)


def draw_tiles(
    rng: np.random.Generator,
    colour: Colour,
    *,
    metres: tuple[float, float],
    scale: int,
    side: float,
) -> Picture:
    """Square tiles of ``side`` metres with pale joints."""
    width, height = int(metres[0] * scale), int(metres[1] * scale)
    rows, columns = np.indices((height, width))
    pitch = max(4, int(side * scale))
    row, column = rows // pitch, columns // pitch
    tones = rng.normal(1.0, 0.04, size=(row.max() + 1, column.max() + 1))
    light = tones[row, column] + 0.02 * _smooth_noise(rng, height, width, (12, 12))
    picture = _shaded_colour(colour, light)
    joint = max(1, scale // 80)
    gap = ((rows % pitch) < joint) | ((columns % pitch) < joint)
    picture[gap] = (np.clip(np.asarray(colour) * 0.72 + 0.12, 0, 1) * 255).astype(np.uint8)
    return picture


def draw_rug(
    rng: np.random.Generator, colours: tuple[Colour, Colour], width: int, height: int
) -> Picture:
    """A woven rug: border, stripes and a row of diamonds."""
    rows, columns = np.indices((height, width))
    x = np.minimum(columns, width - 1 - columns)
    y = np.minimum(rows, height - 1 - rows)
    edge = np.minimum(x, y)
    unit = max(6, height // 12)
    diamond = (np.abs(columns % (4 * unit) - 2 * unit) + np.abs(rows - height // 2)) < 1.6 * unit
    border = ((edge > unit * 0.6) & (edge < unit * 1.1)) | (
        (edge > unit * 1.4) & (edge < unit * 1.6)
    )
    picture = draw_cloth(rng, colours[0], 64)
    picture = np.tile(picture, (height // 64 + 1, width // 64 + 1, 1))[:height, :width].copy()
    other = draw_cloth(rng, colours[1], 64)
    other = np.tile(other, (height // 64 + 1, width // 64 + 1, 1))[:height, :width]
    mask = border | diamond
    picture[mask] = other[mask]
    return picture


def shade_floor(picture: Picture, outlines: list[list[tuple[float, float]]], scale: int) -> Picture:
    """Darken a floor where things stand on it and along its walls: soft, as in a lit room.

    Args:
        picture: the floor, row 0 at the far side (largest y).
        outlines: corners of each footprint, in metres from the floor's lower left corner.
        scale: pixels a metre.

    """
    height, width = picture.shape[:2]
    # At a quarter of the size: the blur hides it, and it costs a sixteenth.
    step = 4
    mask = Image.new("L", (width // step, height // step), 0)
    pen = ImageDraw.Draw(mask)
    ratio = scale / step
    for outline in outlines:
        pen.polygon([(x * ratio, height / step - y * ratio) for x, y in outline], fill=255)
    # Narrow where things touch the floor, wide for the light that they take away.
    near = mask.filter(ImageFilter.GaussianBlur(0.07 * ratio))
    far = mask.filter(ImageFilter.GaussianBlur(0.30 * ratio))
    dark = 0.30 * np.asarray(near, dtype=np.float64) / 255 + 0.38 * np.asarray(far) / 255
    rows, columns = np.indices(dark.shape)
    edge = np.minimum(
        np.minimum(columns, dark.shape[1] - 1 - columns), np.minimum(rows, dark.shape[0] - 1 - rows)
    )
    dark = np.clip(dark + 0.18 * np.exp(-edge / (0.28 * ratio)), 0.0, 0.75)
    light = Image.fromarray((255 * (1.0 - dark)).astype(np.uint8)).resize(
        (width, height), Image.Resampling.BILINEAR
    )
    # Two bytes multiplied fit 16 bits.
    factor = np.asarray(light, dtype=np.uint16)[:, :, None]
    return ((picture * factor) // 255).astype(np.uint8)


def draw_view(rng: np.random.Generator, width: int = 256, height: int = 224) -> Picture:
    """What the windows show: morning sky over the ridges of the Montsec, with the frame."""
    rows = np.linspace(0.0, 1.0, height)[:, None, None]
    sky = np.asarray([0.50, 0.74, 0.96]) * (1 - rows) + np.asarray([0.97, 0.94, 0.87]) * rows
    picture = np.repeat(sky, width, axis=1)
    columns = np.arange(width)
    # Three ridges, the farthest first, each over the one behind it.
    for base, rough, colour in (
        (0.56, 0.11, (0.60, 0.69, 0.80)),
        (0.68, 0.08, (0.46, 0.57, 0.62)),
        (0.80, 0.06, (0.33, 0.47, 0.30)),
    ):
        ridge = np.interp(columns, np.linspace(0, width, 9), rng.uniform(-1, 1, 9)) * rough
        ridge += np.interp(columns, np.linspace(0, width, 41), rng.uniform(-1, 1, 41)) * rough * 0.2
        below = np.arange(height)[:, None] > (base + ridge)[None, :] * height
        picture[below] = colour
    image = Image.fromarray((np.clip(picture, 0, 1) * 255).astype(np.uint8))
    pen = ImageDraw.Draw(image)
    white = (244, 243, 238)
    pen.rectangle((0, 0, width - 1, height - 1), outline=white, width=12)
    pen.rectangle((width // 2 - 5, 0, width // 2 + 5, height), fill=white)
    pen.rectangle((0, height // 3 - 3, width, height // 3 + 3), fill=white)
    return np.asarray(image)


def book_row(rng: np.random.Generator, width: int = 256, height: int = 96) -> Picture:
    """The backs of a row of books before the dark of the shelf."""
    image = Image.new("RGB", (width, height), (38, 30, 24))
    pen = ImageDraw.Draw(image)
    palette = [
        (151, 54, 48),
        (34, 78, 110),
        (206, 160, 66),
        (61, 97, 73),
        (226, 214, 190),
        (92, 62, 98),
        (186, 98, 52),
        (48, 52, 60),
        (120, 150, 160),
    ]
    x = 2
    while x < width - 6:
        thick = int(rng.integers(6, 17))
        tall = int(rng.integers(int(height * 0.66), int(height * 0.95)))
        if rng.random() < 0.08:
            x += thick
            continue
        colour = palette[int(rng.integers(len(palette)))]
        pen.rectangle((x, height - tall, x + thick - 2, height), fill=colour)
        light = tuple(min(255, c + 60) for c in colour)
        pen.line((x + thick // 2, height - tall + 10, x + thick // 2, height - 22), fill=light)
        pen.rectangle((x, height - 14, x + thick - 2, height - 11), fill=light)
        pen.line((x + thick - 2, height - tall, x + thick - 2, height), fill=(20, 18, 16))
        x += thick
    return np.asarray(image)


def load_photograph(name: str, *, frame: Colour | None = (0.16, 0.13, 0.11)) -> Picture:
    """A picture of `pictures/`, in a frame with a white margin unless ``frame`` is None."""
    with Image.open(PICTURES / f"{name}.jpg") as stored:
        image = stored.convert("RGB")
    if frame is not None:
        edge = max(image.size) // 26
        mounted = Image.new(
            "RGB", (image.width + 4 * edge, image.height + 4 * edge), (246, 244, 238)
        )
        mounted.paste(image, (2 * edge, 2 * edge))
        colour = tuple(int(255 * c) for c in frame)
        ImageDraw.Draw(mounted).rectangle(
            (0, 0, mounted.width - 1, mounted.height - 1), outline=colour, width=edge
        )
        image = mounted
    return np.asarray(image)
