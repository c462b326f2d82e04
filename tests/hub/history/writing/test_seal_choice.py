"""How much of each channel is held in memory before it becomes a block."""

import pytest

from talaia.hub.history.limits import HistoryLimits
from talaia.hub.history.writing.seal_choice import sealing_size

pytestmark = pytest.mark.pure


@pytest.mark.parametrize(
    ("channels", "samples"),
    [(0, 16_384), (1, 16_384), (64, 16_384), (128, 8_192), (256, 4_096), (2_048, 4_096)],
)
def test_few_channels_have_large_blocks(channels, samples) -> None:
    assert sealing_size(HistoryLimits(), channels) == samples


def test_ten_thousand_channels_hold_what_a_hub_has_memory_for() -> None:
    for channels in (3_000, 5_000, 10_000, 25_000):
        size = sealing_size(HistoryLimits(), channels)
        assert 1_024 <= size <= 4_096
        assert channels * size * 16 < max(150e6, channels * 17_000)


def test_a_small_block_stays_as_small_as_it_is_asked_for() -> None:
    assert sealing_size(HistoryLimits(block=8, largest=8), 3) == 8
    assert sealing_size(HistoryLimits(block=64, largest=64), 100_000) == 64
