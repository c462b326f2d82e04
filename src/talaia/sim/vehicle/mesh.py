"""Shapes with rounded edges and texture coordinates, which MuJoCo's own boxes do not have."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

__all__ = ["rounded_box"]

Array = npt.NDArray[np.float64]
Vector = tuple[float, float, float]


def rounded_box(
    size: Vector, radius: float, repeat: float
) -> tuple[Array, Array, Array, npt.NDArray[np.int32]]:
    """Vertices, normals, texture coordinates and triangles of a box with rounded edges.

    Texture coordinates run along the two axes of each side, upright on the four walls: in
    ``repeat`` times metres, or from 0 to 1 over the side when ``repeat`` is 0.
    """
    half = np.asarray(size) / 2
    core = half - radius
    points: list[Array] = []
    normals: list[Array] = []
    uvs: list[Array] = []
    faces: list[tuple[int, int, int]] = []
    # For each side: the axis it faces, its sign, and the axes of u and v.
    sides = ((0, 1, 1, 2), (0, -1, 1, 2), (1, 1, 0, 2), (1, -1, 0, 2), (2, 1, 0, 1), (2, -1, 0, 1))
    for axis, sign, a, b in sides:
        # Four points along each side: its ends, and where the rounding begins.
        u = np.array([-half[a], -core[a], core[a], half[a]])
        v = np.array([-half[b], -core[b], core[b], half[b]])
        grid = np.zeros((4, 4, 3))
        grid[:, :, axis] = sign * half[axis]
        grid[:, :, a] = u[None, :]
        grid[:, :, b] = v[:, None]
        # From the core, a box without the rounding, every point is as far as the radius.
        inner = np.clip(grid, -core, core)
        out = grid - inner
        out /= np.linalg.norm(out, axis=2, keepdims=True)
        start = 16 * len(points)
        points.append((inner + radius * out).reshape(16, 3))
        normals.append(out.reshape(16, 3))
        # Seen from outside, u must run to the right, or writing would be mirrored.
        right = 1.0 if (axis == 0) == (sign > 0) or axis == 2 else -1.0
        us, vs = right * grid[:, :, a], grid[:, :, b]
        if repeat:
            uv = np.stack([us * repeat, vs * repeat], axis=2)
        else:
            uv = np.stack([us / size[a] + 0.5, vs / size[b] + 0.5], axis=2)
        uvs.append(uv.reshape(16, 2))
        flip = (sign > 0) != (axis == 1)
        for row in range(3):
            for column in range(3):
                p = start + 4 * row + column
                quad = [(p, p + 1, p + 5), (p, p + 5, p + 4)]
                faces.extend(quad if flip else [(c, b_, a_) for a_, b_, c in quad])
    return (
        np.concatenate(points),
        np.concatenate(normals),
        np.concatenate(uvs),
        np.asarray(faces, dtype=np.int32),
    )
