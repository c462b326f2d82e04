"""Scores wait for their history, and not for that of another site."""

import pytest

from talaia.hub.history.errors import HistoryAway
from talaia.hub.live.detection.score_writer import ScoreWriter


class TwoServers:
    """Keeps what is appended, but for sites that are away."""

    def __init__(self) -> None:
        """Have one site that is away."""
        self.away = {"far"}
        self.stored = []

    async def append_samples(self, site, run, first, *, addresses, columns) -> None:
        del run
        if site in self.away:
            raise HistoryAway("away")
        self.stored.append((site, first, addresses, columns.value.tolist()))


async def test_scores_of_a_site_that_is_away_hold_no_other_up_and_are_stored_later() -> None:
    history = TwoServers()
    writer = ScoreWriter(history)
    for site in ("far", "near"):
        writer.add_score(site, "base/x.score", 1, 0.5)
    with pytest.raises(HistoryAway):
        await writer.write_waiting()
    assert history.stored == [("near", 0, ("base/x.score",), [0.5])]
    history.away.clear()
    writer.add_score("near", "base/x.score", 2, 0.75)
    await writer.write_waiting()
    assert history.stored[1:] == [
        ("far", 0, ("base/x.score",), [0.5]),
        ("near", 1, ("base/x.score",), [0.75]),
    ]
