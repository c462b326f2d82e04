"""Find where a picture stands in the sky, from a rough place and the size of a pixel. Pure.

Triangles of bright stars on the picture are compared with those of the catalogue around the place
where the mount says that it points (the idea: Groth 1986, AJ 91, 1244; Valdes and others 1995, PASP
107, 1119). The size of a pixel is known to some per cent, so a triangle is known by its three sides
and fits few others. Each fit is a proposal; the one under which most stars of the picture meet one
of the catalogue is refined, and believed only when chance would hardly make as many meet.

Long, because a proposal is of no use without its proof.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from talaia.imaging.tangent_plane import TanWcs, plane_to_sky, sky_to_plane

if TYPE_CHECKING:
    from collections.abc import Callable
    from typing import TypeAlias

    from numpy.typing import NDArray

    from talaia.imaging.star_catalog import Stars
    from talaia.imaging.star_detection import DetectedStars

    Numbers: TypeAlias = NDArray[np.float64]

__all__ = ["PlateHint", "PlateSolution", "solve_plate"]

# Stars of the picture that triangles are made of, and by which a proposal is judged.
_CORNERS, _JUDGED = 14, 60
# Triangles smaller than this part of the picture's diagonal say little.
_SMALLEST = 0.08
# Stars meet within so many pixels under a proposal, and after it has been refined.
_ROUGH, _FINE = 4.0, 2.0
# Proposals that are looked at before it gives up.
_MOST_PROPOSALS = 6000
# A solution that chance makes once in so many proposals is not believed.
_CHANCE = 1e-9


class PlateHint(NamedTuple):
    """What is known before.

    Attributes:
        ra: about where the middle is (°, J2000).
        dec: (°, J2000).
        scale: of a pixel (arc seconds).
        radius: how far off the place may be (°).
        scale_error: how wrong the size of a pixel may be, as a part of it.

    """

    ra: float
    dec: float
    scale: float
    radius: float = 0.5
    scale_error: float = 0.02


class PlateSolution(NamedTuple):
    """Where a picture stands, or why that was not found.

    Attributes:
        wcs: where its pixels stand; none when `problem` says why not.
        matched: stars of the picture that meet one of the catalogue.
        rms: how far apart they are in the middle (arc seconds).
        problem: in words; empty when it was solved.
        pairs: index of each matched star of the picture, and of the catalogue's `stars`.
        stars: of the catalogue around the solved field.

    """

    wcs: TanWcs | None = None
    matched: int = 0
    rms: float = float("nan")
    problem: str = ""
    pairs: NDArray[np.int_] | None = None
    stars: Stars | None = None


class _Triangles(NamedTuple):
    """Triangles by rows: the longest side, the two others as parts of it, and their corners.

    A corner stands where the side of the same column lies opposite.
    """

    longest: Numbers
    ratios: Numbers
    corners: NDArray[np.int_]


def solve_plate(
    found: DetectedStars,
    shape: tuple[int, int],
    hint: PlateHint,
    catalog: Callable[[float, float, float], Stars],
) -> PlateSolution:
    """Solve a picture.

    Args:
        found: its stars.
        shape: rows and columns of the picture.
        hint: see `PlateHint`.
        catalog: gives the stars within a radius (°) of a place.

    """
    if found.total < 5:
        return PlateSolution(problem=f"{found.total} stars were seen; at least 5 are needed")
    if not 0.01 < hint.scale < 600.0 or not -90.0 <= hint.dec <= 90.0:
        return PlateSolution(problem="the size of a pixel or the place has no sense")
    diagonal = math.hypot(*shape) * hint.scale
    stars = catalog(hint.ra, hint.dec, hint.radius + diagonal / 7200.0)
    chosen = _bright_enough(stars, hint, diagonal)
    if len(chosen.ra) < 5:
        return PlateSolution(problem=f"the catalogue has {len(chosen.ra)} stars there")
    middle = np.array([(shape[1] - 1) / 2, (shape[0] - 1) / 2])
    # Both in arc seconds about the middle of the picture and the place of the hint.
    picture = (np.stack([found.x, found.y], axis=1)[:_JUDGED] - middle) * hint.scale
    plane = np.stack(sky_to_plane(chosen.ra, chosen.dec, hint.ra, hint.dec), axis=1) * 3600.0
    best = _best_proposal(picture, plane, hint, diagonal)
    if best is None:
        return PlateSolution(problem="no triangle of its stars is like one of the catalogue")
    matrix, shift, met = best
    center = plane_to_sky(shift[:1] / 3600.0, shift[1:] / 3600.0, hint.ra, hint.dec)
    wcs = TanWcs(
        ra=float(center[0][0]),
        dec=float(center[1][0]),
        x=float(middle[0]),
        y=float(middle[1]),
        cd=_cd_of(matrix, hint.scale),
    )
    near = catalog(wcs.ra, wcs.dec, diagonal / 7200.0)
    return _refined_solution(found, near, wcs, met=met, shape=shape)


def _bright_enough(stars: Stars, hint: PlateHint, diagonal: float) -> Stars:
    # So many that each field has about as many as triangles are made of, and some more: what is
    # bright through a filter is not always what is bright in the catalogue.
    ground = math.pi * (hint.radius + diagonal / 7200.0) ** 2
    field = 0.46 * (diagonal / 3600.0) ** 2
    return stars.brightest(min(1500, round(2.0 * _CORNERS * max(1.0, ground / field))))


def _best_proposal(
    picture: Numbers, plane: Numbers, hint: PlateHint, diagonal: float
) -> tuple[Numbers, Numbers, int] | None:
    ours = _triangles_of(picture[:_CORNERS], _SMALLEST * diagonal, diagonal * 1.1)
    theirs = _triangles_of(plane, _SMALLEST * diagonal, diagonal * 1.1)
    order = np.argsort(theirs.longest)
    theirs = _Triangles(theirs.longest[order], theirs.ratios[order], theirs.corners[order])
    best: tuple[Numbers, Numbers, int] | None = None
    looked = 0
    # Large triangles fix the turn best.
    for row in np.argsort(-ours.longest):
        for other in _like_triangles(ours, int(row), theirs, hint):
            looked += 1
            fit = _similarity(picture[ours.corners[row]], plane[theirs.corners[other]])
            if (
                fit is None
                or abs(math.sqrt(abs(np.linalg.det(fit[0]))) - 1.0) > hint.scale_error * 1.5
            ):
                continue
            met = _count_met(picture @ fit[0].T + fit[1], plane, _ROUGH * hint.scale)
            if best is None or met > best[2]:
                best = (*fit, met)
                if met >= max(10, 0.5 * len(picture)):
                    return best
        if looked > _MOST_PROPOSALS:
            break
    return best


def _triangles_of(points: Numbers, least: float, most: float) -> _Triangles:
    """List the triangles whose sides are all between two lengths."""
    far = np.hypot(points[:, None, 0] - points[None, :, 0], points[:, None, 1] - points[None, :, 1])
    rows: list[NDArray[np.int_]] = []
    for first in range(len(points)):
        near = np.flatnonzero((far[first] >= least) & (far[first] <= most))
        near = near[near > first]
        if len(near) > 45:
            # The brightest come first: enough of them are in each picture.
            near = near[:45]
        if len(near) < 2:
            continue
        two, three = np.triu_indices(len(near), 1)
        side = far[near[two], near[three]]
        fits = (side >= least) & (side <= most)
        pairs = np.stack([near[two][fits], near[three][fits]], axis=1)
        rows.append(np.column_stack([np.full(len(pairs), first), pairs]))
    corners = np.concatenate(rows) if rows else np.empty((0, 3), int)
    a, b, c = corners.T
    sides = np.stack([far[b, c], far[a, c], far[a, b]], axis=1)
    by_length = np.argsort(-sides, axis=1)
    sides = np.take_along_axis(sides, by_length, axis=1)
    corners = np.take_along_axis(corners, by_length, axis=1)
    longest = sides[:, 0] if len(sides) else np.empty(0)
    return _Triangles(longest, sides[:, 1:] / np.maximum(longest[:, None], 1e-9), corners)


def _like_triangles(
    ours: _Triangles, row: int, theirs: _Triangles, hint: PlateHint
) -> NDArray[Any]:
    longest = ours.longest[row]
    low, high = np.searchsorted(
        theirs.longest,
        (longest * (1 - hint.scale_error), longest * (1 + hint.scale_error)),
    )
    # A centre is known to a pixel or so.
    tolerance = 1.5 * hint.scale / longest
    off = np.abs(theirs.ratios[low:high] - ours.ratios[row])
    return np.asarray(low + np.flatnonzero((off < tolerance).all(axis=1)))


def _similarity(ours: Numbers, theirs: Numbers) -> tuple[Numbers, Numbers] | None:
    """Give the matrix and the shift that bring three points onto three others."""
    source, goal = ours - ours.mean(axis=0), theirs - theirs.mean(axis=0)
    try:
        matrix = np.linalg.solve(source[:2], goal[:2]).T
    except np.linalg.LinAlgError:
        return None
    # Without shear: the nearest turn and scale, mirrored where the triangle is.
    u, sizes, v = np.linalg.svd(matrix)
    turned = (u @ v) * sizes.mean()
    return turned, theirs.mean(axis=0) - turned @ ours.mean(axis=0)


def _count_met(moved: Numbers, plane: Numbers, within: float) -> int:
    # Those of the catalogue beside the field cost time and meet nothing.
    low, high = moved.min(axis=0) - within, moved.max(axis=0) + within
    near = plane[((plane >= low) & (plane <= high)).all(axis=1)]
    if not len(near):
        return 0
    square = ((moved[:, None, :] - near[None, :, :]) ** 2).sum(axis=2)
    return int((square.min(axis=1) <= within * within).sum())


def _cd_of(matrix: Numbers, scale: float) -> tuple[float, float, float, float]:
    cd = matrix * scale / 3600.0
    return float(cd[0, 0]), float(cd[0, 1]), float(cd[1, 0]), float(cd[1, 1])


def _refined_solution(
    found: DetectedStars, stars: Stars, wcs: TanWcs, *, met: int, shape: tuple[int, int]
) -> PlateSolution:
    """Fit all stars that meet, again and again, and ask whether chance would do as well."""
    limit = stars.brightest(max(60, 4 * found.total))
    pairs = np.empty((0, 2), int)
    for within in (_ROUGH, _FINE, _FINE):
        pairs = _pairs_within(found, limit, wcs, within)
        if len(pairs) < 4:
            return PlateSolution(
                problem=f"only {max(met, len(pairs))} of its stars meet the catalogue"
            )
        wcs = _fitted_wcs(found, limit, wcs, pairs)
    x, y = wcs.sky_to_pixel(limit.ra, limit.dec)
    rows, columns = shape
    inside = int(((x >= 0) & (x < columns) & (y >= 0) & (y < rows)).sum())
    share = min(0.9, inside * math.pi * _FINE**2 / (rows * columns))
    chance = _chance_of(len(pairs), found.total, share)
    if len(pairs) < 6 or chance > _CHANCE:
        return PlateSolution(
            problem=f"{len(pairs)} of {found.total} stars meet the catalogue: that may be chance"
        )
    off = np.hypot(x[pairs[:, 1]] - found.x[pairs[:, 0]], y[pairs[:, 1]] - found.y[pairs[:, 0]])
    rms = float(np.sqrt((off**2).mean())) * wcs.scale
    return PlateSolution(wcs, len(pairs), rms, "", pairs, limit)


def _pairs_within(found: DetectedStars, stars: Stars, wcs: TanWcs, within: float) -> NDArray[Any]:
    x, y = wcs.sky_to_pixel(stars.ra, stars.dec)
    square = (found.x[:, None] - x) ** 2 + (found.y[:, None] - y) ** 2
    square = np.where(np.isfinite(square), square, np.inf)
    nearest = square.argmin(axis=1)
    # Each is the other's nearest, so that no star counts twice.
    mutual = square.argmin(axis=0)[nearest] == np.arange(found.total)
    close = square[np.arange(found.total), nearest] <= within * within
    ours = np.flatnonzero(mutual & close)
    return np.stack([ours, nearest[ours]], axis=1)


def _fitted_wcs(found: DetectedStars, stars: Stars, wcs: TanWcs, pairs: NDArray[Any]) -> TanWcs:
    ours, theirs = pairs.T
    xi, eta = sky_to_plane(stars.ra[theirs], stars.dec[theirs], wcs.ra, wcs.dec)
    columns = np.stack([found.x[ours] - wcs.x, found.y[ours] - wcs.y, np.ones(len(ours))], axis=1)
    (a, c), (b, d), shift = np.linalg.lstsq(columns, np.stack([xi, eta], axis=1), rcond=None)[0]
    ra, dec = plane_to_sky(shift[:1], shift[1:], wcs.ra, wcs.dec)
    return TanWcs(
        float(ra[0]), float(dec[0]), wcs.x, wcs.y, (float(a), float(b), float(c), float(d))
    )


def _chance_of(met: int, count: int, share: float) -> float:
    """Give the chance that so many of so many stars meet one when they stand anywhere."""
    # The tail of the binomial distribution.
    return float(
        sum(
            math.comb(count, k) * share**k * (1.0 - share) ** (count - k)
            for k in range(met, count + 1)
        )
    )
