"""Which past series a query of Prometheus means, of what an account may see. Pure.

Names and labels are those of ``/metrics``, so that what was scraped and what the history has are
one series; see `site_metrics`.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from talaia.hub.auth.permissions import Right, sees_signal
from talaia.model.site import SignalType
from talaia.wire.prometheus.remote_read import MatchKind, PastSeries

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence

    from talaia.hub.auth.permissions import Grants
    from talaia.hub.history.queries.series import Series
    from talaia.hub.live.sites import LiveSite
    from talaia.wire.prometheus.remote_read import LabelMatcher

    # Keeps those of some texts that match a whole regular expression.
    MatchesRegex = Callable[[str, Sequence[str]], Sequence[bool]]

__all__ = ["PastChannel", "find_past_channels", "series_of_channel"]

_NAME, _VALUE, _STATE = "__name__", "talaia_signal_value", "talaia_signal_state"


class PastChannel(NamedTuple):
    """A series that a query means, and where its samples are.

    Attributes:
        state: of a state: the number of the word that the series is 1 for; else -1.

    """

    site: str
    address: str
    labels: Mapping[str, str]
    state: int = -1


def find_past_channels(
    sites: Iterable[LiveSite],
    *,
    grants: Grants,
    matchers: Sequence[LabelMatcher],
    more: Mapping[str, str],
    matches_regex: MatchesRegex,
) -> list[PastChannel]:
    """Find the series that all ``matchers`` fit; ``more`` are labels that all series have."""
    found = [
        channel._replace(labels={**more, **channel.labels})
        for live in sites
        if grants.has_right(Right.METRICS, live.name)
        for channel in _channels_of(live, grants)
    ]
    for matcher in matchers:
        values = [channel.labels.get(matcher.name, "") for channel in found]
        fits: Sequence[bool]
        if matcher.kind in {MatchKind.EQUAL, MatchKind.NOT_EQUAL}:
            fits = [value == matcher.value for value in values]
        else:
            fits = matches_regex(matcher.value, values)
        wanted = matcher.kind in {MatchKind.EQUAL, MatchKind.REGEX}
        found = [channel for channel, fit in zip(found, fits, strict=True) if fit is wanted]
    return found


def series_of_channel(channel: PastChannel, series: Series) -> PastSeries:
    """Give a series as Prometheus has it: at most one sample of each millisecond, the last."""
    time_ms = series.time_us // 1000
    value = series.value if channel.state < 0 else (series.value == channel.state).astype(float)
    last = np.append(time_ms[1:] != time_ms[:-1], True) if time_ms.size else time_ms.astype(bool)
    return PastSeries(channel.labels, time_ms[last], value[last])


def _channels_of(live: LiveSite, grants: Grants) -> Iterator[PastChannel]:
    for channel in live.channels:
        signal = live.description.devices[channel.device].signals[channel.signal]
        if channel.text or not sees_signal(
            grants, live.description, channel.device, channel.signal
        ):
            continue
        labels = {"site": live.name, "device": channel.device, "signal": channel.signal}
        if signal.type is SignalType.STATE:
            for number, word in enumerate(signal.states):
                own = {_NAME: _STATE, **labels, _STATE: word}
                yield PastChannel(live.name, channel.address, own, number)
            continue
        # An empty label is none, as where it is scraped.
        marks = {"part": channel.part, "unit": signal.unit}
        own = {_NAME: _VALUE, **labels, **{name: said for name, said in marks.items() if said}}
        yield PastChannel(live.name, channel.address, own)
