"""How much of each channel is held in memory before it becomes a block."""

import numpy as np
import pytest

from talaia.hub.history.blocks.journal_rows import JournalRows
from talaia.hub.history.limits import HistoryLimits
from talaia.hub.history.writing.chunks import Chunk
from talaia.hub.history.writing.open_blocks import Tails
from talaia.hub.history.writing.seal_choice import SealChoice, sealing_size

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


def tails_of(channels, rows):
    """Give tails with a sample of each channel in each row, all dealt out, and their journal."""
    tails, journal = Tails(1, 0, 1), JournalRows()
    for row in range(1, rows + 1):
        ids = np.arange(channels)
        zeros = np.zeros(channels)
        tails.add_chunks([Chunk(row, ids, zeros.astype(np.int64), zeros, {})])
        journal.append_row(row, channels)
        tails.deal_chunks()
    return tails, journal


def test_channels_that_keep_too_many_rows_are_saved_in_turn_each_once() -> None:
    choice = SealChoice(HistoryLimits(journal_rows=10))
    tails, journal = tails_of(channels=40, rows=11)
    saved = []
    for _ in range(60):
        # Each commit has a row: while as many come as there may be, all have their turn.
        choice.rows += 1
        chosen, some, _ = choice.choose_channels(tails, journal)
        assert chosen == []
        assert len(some) <= 6
        tails.mark_saved(some)
        saved += some
    assert sorted(saved) == list(range(40))


def test_while_the_journal_has_few_rows_nothing_is_saved() -> None:
    choice = SealChoice(HistoryLimits(journal_rows=10))
    tails, journal = tails_of(channels=40, rows=10)
    assert choice.choose_channels(tails, journal)[:2] == ([], [])


def test_a_channel_that_was_made_a_block_meanwhile_is_not_chosen_again() -> None:
    limits = HistoryLimits(block=4, largest=4, journal_rows=1)
    choice = SealChoice(limits)
    tails, journal = tails_of(channels=3, rows=5)
    choice.rows = 1
    chosen, saved, _ = choice.choose_channels(tails, journal)
    tails.forget_sealed(chosen, 2)
    tails.mark_saved(saved)
    seen = [*chosen, *saved]
    for _ in range(5):
        chosen, saved, _ = choice.choose_channels(tails, journal)
        tails.forget_sealed(chosen, 2)
        tails.mark_saved(saved)
        seen += [*chosen, *saved]
    assert {0, 1, 2} == {*seen}
