"""The newest sample of every channel of a site, with the moment it arrived."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from talaia.wire.columns import Columns

if TYPE_CHECKING:
    from numpy.typing import NDArray

__all__ = ["Latest"]

_NEVER = np.iinfo(np.int64).min


class Latest:
    """One place for each channel; arrays have the shape (channels,)."""

    def __init__(self, channels: int) -> None:
        """Start with nothing known."""
        self.value = np.full(channels, np.nan)
        self.time_us = np.zeros(channels, np.int64)
        self.arrived_ns = np.full(channels, _NEVER, np.int64)
        self.texts: dict[int, str] = {}

    def update(self, columns: Columns, now_ns: int) -> None:
        """Take a live batch; of several samples of a channel the last in the batch counts."""
        channel = columns.channel
        self.value[channel] = columns.value
        self.time_us[channel] = columns.time_us
        self.arrived_ns[channel] = now_ns
        for at, text in columns.texts.items():
            self.texts[int(channel[at])] = text

    def remember(
        self, channel: int, time_us: int, value: float, text: str, arrived_ns: int
    ) -> None:
        """Take a sample from the history, unless one is there."""
        if self.arrived_ns[channel] == _NEVER:
            self.value[channel] = value
            self.time_us[channel] = time_us
            self.arrived_ns[channel] = arrived_ns
            if text:
                self.texts[channel] = text

    def of(self, channels: NDArray[np.int64], now_ns: int) -> tuple[Columns, list[float]]:
        """Give what is known of ``channels``, numbered by their place in it, and its age (ms)."""
        known = np.flatnonzero(self.arrived_ns[channels] != _NEVER)
        at = channels[known]
        texts = {
            place: self.texts[int(channel)]
            for place, channel in enumerate(at)
            if int(channel) in self.texts
        }
        age_ms = np.maximum(0, now_ns - self.arrived_ns[at]) / 1e6
        columns = Columns(known.astype(np.uint16), self.time_us[at], self.value[at], texts)
        return columns, [round(age, 1) for age in age_ms.tolist()]
