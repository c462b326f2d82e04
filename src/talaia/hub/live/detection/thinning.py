"""Takes one sample a second of a signal, out of batches of many signals. Pure."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from talaia.wire.columns import Columns

__all__ = ["Thinning"]

# A little less than a second, so that one of 1 Hz whose clock trembles loses none (µs).
_EVERY_US = 900_000
# More than there are channels in a site.
_CHANNELS = 65_536


class Thinning:
    """Which samples of fast signals are looked at."""

    def __init__(self, thin: NDArray[np.bool_]) -> None:
        """Thin the channels where ``thin`` is true, by their place in the list of channels."""
        self._thin = thin
        self._any = bool(thin.any())
        # From when on a channel's next sample is taken (µs).
        self._next_us = np.zeros(thin.size, np.int64)

    def pick_samples(self, columns: Columns, at: NDArray[np.intp]) -> NDArray[np.intp]:
        """Choose among the samples at the places ``at`` of a batch.

        Returns:
            The places of those that are looked at, in the order they came: all of channels that
            are not thinned, of the others at most one a second.

        """
        if not self._any or not at.size:
            return at
        thin = self._thin[columns.channel[at]]
        fast = at[thin]
        if not fast.size:
            return at
        channel = columns.channel[fast].astype(np.int64)
        time_us = columns.time_us[fast]
        # A channel's first sample is taken; of several the first, which is written last here.
        new = np.flatnonzero(self._next_us[channel] == 0)[::-1]
        self._next_us[channel[new]] = time_us[new]
        # How many seconds behind the one in which the newest was taken, which is -1. Older ones
        # are taken, too: whoever looks at them counts what came late.
        second = (time_us - self._next_us[channel]) // _EVERY_US
        due = second != -1
        # By far most batches of a fast signal hold nothing that is due.
        if not np.count_nonzero(due):
            return at[~thin]
        _, first = np.unique((second * _CHANNELS + channel)[due], return_index=True)
        taken = np.flatnonzero(due)[first]
        np.maximum.at(self._next_us, channel[taken], time_us[taken] + _EVERY_US)
        return np.sort(np.concatenate((at[~thin], fast[taken])))
