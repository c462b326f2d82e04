"""What several signals usually do together: their scales, covariance and its inverse root."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from talaia.hub.anomaly.base import Floats

__all__ = [
    "SignalShare",
    "inverse_root",
    "share_distance",
    "shrink_covariance",
    "usual_spreads",
]

# By so much of itself the diagonal of a covariance is raised, of up to so many rows; of more it is
# raised by less, as correlations are known better.
_SHRINKAGE, _FEW_ROWS = 0.3, 400
# A smoothed signal moves at least by so much of its spread squared; white noise would by 0.03.
_LEAST_VARIANCE = 0.01


class SignalShare(NamedTuple):
    """What one signal has to do with the distance.

    Attributes:
        name: of the signal.
        share: of the squared distance, 0 to 1.
        spreads: by so many usual spreads it is above (or below, negative) its usual level.
        place: its place among the signals.

    """

    name: str
    share: float
    spreads: float
    place: int


def usual_spreads(center: Floats, variances: Floats) -> Floats:
    """Give the spread of each signal, in its unit; never 0.

    Args:
        center: the means.
        variances: their mean squared departures.

    """
    spread = np.sqrt(variances)
    size = np.where(center == 0.0, 1.0, np.abs(center))
    # A constant signal has no spread: a thousandth of its value is taken for it.
    return np.where(spread > 1e-6 * size, spread, 1e-3 * size)


def shrink_covariance(departures: Floats) -> Floats:
    """Give the covariance (signals, signals) of departures (rows, signals), its diagonal raised.

    Ledoit and Wolf (2004): from few rows correlations are known badly, and an inverse would make
    much of that; what is best raises it by the inverse of the number of rows.
    """
    raised = _SHRINKAGE * min(1.0, _FEW_ROWS / len(departures))
    shrunk = departures.T @ departures / len(departures)
    variances = np.maximum(np.diag(shrunk), _LEAST_VARIANCE)
    np.fill_diagonal(shrunk, variances * (1.0 + raised))
    return shrunk


def inverse_root(covariance: Floats, known: Floats) -> Floats:
    """Give ``S^(-½)`` of the signals that are known, 0 for the others.

    Args:
        covariance: ``S``, symmetric (signals, signals).
        known: 1 for each signal that counts, 0 for the others.

    """
    root = np.zeros_like(covariance)
    places: NDArray[np.intp] = np.flatnonzero(known)
    if len(places):
        inside = np.ix_(places, places)
        values, vectors = np.linalg.eigh(covariance[inside])
        # It is positive by its raised diagonal; rounding must not make a root of less.
        values = np.maximum(values, 1e-3 * _LEAST_VARIANCE)
        root[inside] = (vectors / np.sqrt(values)) @ vectors.T
    return root


def share_distance(names: Sequence[str], whitened: Floats, spreads: Floats) -> list[SignalShare]:
    """Divide a distance among its signals, the greatest share first.

    Args:
        names: of the signals.
        whitened: their departures times `inverse_root`; their squares add up to the distance.
        spreads: their departures in usual ones.

    """
    squares = whitened**2
    shares = (squares / squares.sum()).tolist()
    found = map(SignalShare, names, shares, spreads.tolist(), range(len(names)))
    return sorted(found, key=lambda signal: -signal.share)
