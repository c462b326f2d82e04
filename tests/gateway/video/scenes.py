"""Pictures whose content is known, as each encoding has them, and how far two are apart."""

from __future__ import annotations

from types import SimpleNamespace as Message

import numpy as np

RED = {"rggb": (0, 0), "bggr": (1, 1), "gbrg": (1, 0), "grbg": (0, 1)}


def scene(width: int = 64, height: int = 48, turn: int = 0) -> np.ndarray:
    """A smooth picture with all colours in it, which every encoding can carry: RGB."""
    across = np.linspace(0, 2 * np.pi, width)[None, :]
    down = np.linspace(0, 2 * np.pi, height)[:, None]
    parts = (
        np.sin(across + turn / 5) + 0 * down,
        np.cos(down + turn / 7) + 0 * across,
        np.sin(across + down + 1),
    )
    return np.stack([np.clip(128 + 90 * each, 0, 255) for each in parts], 2).astype(np.uint8)


def psnr(one: np.ndarray, other: np.ndarray) -> float:
    """Peak signal to noise (dB); 30 is hard to tell apart by eye."""
    error = np.mean((one.astype(float) - other.astype(float)) ** 2)
    return 99.0 if error == 0 else float(10 * np.log10(255**2 / error))


def planes_of(rgb: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """BT.601, limited range; its own sums, not the product's."""
    red, green, blue = (rgb[:, :, each].astype(float) / 255 for each in range(3))
    luma = 0.299 * red + 0.587 * green + 0.114 * blue
    planes = (16 + 219 * luma, 128 + 224 * (blue - luma) / 1.772, 128 + 224 * (red - luma) / 1.402)
    first, second, third = (np.clip(np.rint(each), 0, 255).astype(np.uint8) for each in planes)
    return first, second, third


def packed(rgb: np.ndarray, encoding: str, pad: int = 0, *, big: bool = False) -> Message:
    """Write a picture as a ``sensor_msgs/Image`` of an encoding, rows padded by ``pad`` bytes."""
    height, width = rgb.shape[:2]
    rows = _rows(rgb, encoding, ">u2" if big else "<u2")
    padded = np.pad(rows, ((0, 0), (0, pad)), constant_values=77)
    return Message(
        height=height, width=width, encoding=encoding, is_bigendian=int(big),
        step=padded.shape[1], data=np.ascontiguousarray(padded).ravel(),
    )  # fmt: skip


def _rows(rgb: np.ndarray, encoding: str, word: str) -> np.ndarray:
    height, width = rgb.shape[:2]
    grey = planes_of(rgb)[0]
    solid = np.full((height, width, 1), 255, np.uint8)
    y, u, v = planes_of(rgb)
    orders = {
        "rgb": rgb, "bgr": rgb[:, :, ::-1], "rgba": np.dstack([rgb, solid]),
        "bgra": np.dstack([rgb[:, :, ::-1], solid]), "mono": grey,
    }  # fmt: skip
    same = {"8UC1": "mono8", "8UC3": "bgr8", "8UC4": "bgra8"}
    encoding = same.get(encoding, encoding)
    for order, pixels in orders.items():
        if encoding == f"{order}8":
            return pixels.reshape(height, -1)
        if encoding == f"{order}16":
            return (pixels.astype(np.uint16) * 257).astype(word).view(np.uint8).reshape(height, -1)
    if encoding == "16UC1":
        return (grey.astype(np.uint16) * 20).astype(word).view(np.uint8).reshape(height, -1)
    if encoding == "32FC1":
        form = word.replace("u2", "f4")
        return (grey.astype(np.float32) / 50).astype(form).view(np.uint8).reshape(height, -1)
    if encoding.startswith("bayer_"):
        red_row, red_column = RED[encoding[6:10]]
        plane = rgb[:, :, 1].copy()
        plane[red_row::2, red_column::2] = rgb[red_row::2, red_column::2, 0]
        plane[1 - red_row :: 2, 1 - red_column :: 2] = rgb[1 - red_row :: 2, 1 - red_column :: 2, 2]
        if encoding.endswith("16"):
            return (plane.astype(np.uint16) * 257).astype(word).view(np.uint8).reshape(height, -1)
        return plane
    if encoding in ("yuv422", "uyvy", "yuv422_yuy2", "yuyv"):
        pairs = np.stack([u[:, ::2], v[:, ::2]], 2).reshape(height, width)
        both = (y, pairs) if encoding in ("yuv422_yuy2", "yuyv") else (pairs, y)
        return np.stack(both, 2).reshape(height, -1)
    if encoding == "nv24":
        return np.vstack([y, np.stack([u, v], 2).reshape(2 * height, width)])
    quarter = u[::2, ::2], v[::2, ::2]
    if encoding == "i420":
        return np.vstack([y, *(each.reshape(-1, width) for each in quarter)])
    pair = quarter if encoding == "nv12" else quarter[::-1]
    return np.vstack([y, np.stack(pair, 2).reshape(-1, width)])


def numbered(number: int, width: int = 320, height: int = 240) -> np.ndarray:
    """A picture that says its number (to 65535) in a row of black and white fields, as RGB."""
    picture = scene(width, height, number)
    wide = width // 16
    for bit in range(16):
        value = 235 if number >> bit & 1 else 20
        picture[: height // 4, bit * wide : (bit + 1) * wide] = value
    return picture


def number_in(picture: np.ndarray) -> int:
    """Read what `numbered` says."""
    height, width = picture.shape[:2]
    wide = width / 16
    row = picture[height // 8].astype(int).reshape(width, -1).mean(1)
    return sum(int(row[round((bit + 0.5) * wide)] > 128) << bit for bit in range(16))
