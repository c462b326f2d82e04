"""Blocks that were read lately stay in memory, and no longer than they are true."""

import numpy as np
import pytest

from talaia.hub.history.blocks.block import BlockSamples
from talaia.hub.history.blocks.cache import BlockCache

pytestmark = pytest.mark.pure


def block(size, texts=None):
    return BlockSamples(np.arange(size), np.zeros(size), texts or {})


def test_what_was_asked_for_longest_ago_goes_first() -> None:
    cache = BlockCache(100)
    cache.add_blocks(0, {1: block(40), 2: block(40)})
    assert set(cache.find_blocks(0, [1])) == {1}
    cache.add_blocks(0, {3: block(40)})
    assert set(cache.find_blocks(0, [1, 2, 3])) == {1, 3}
    assert cache.bytes == 80 * 16


def test_a_block_larger_than_all_room_is_not_kept() -> None:
    cache = BlockCache(100)
    cache.add_blocks(0, {1: block(40), 2: block(101)})
    assert cache.find_blocks(0, [1, 2]) == {}
    cache.add_blocks(0, {3: block(100)})
    assert set(cache.find_blocks(0, [3])) == {3}


def test_texts_are_not_kept() -> None:
    cache = BlockCache(100)
    cache.add_blocks(0, {1: block(2, {0: "x"})})
    assert cache.find_blocks(0, [1]) == {}


def test_all_is_forgotten_when_numbers_may_be_given_again() -> None:
    cache = BlockCache(100)
    cache.add_blocks(0, {1: block(10)})
    assert cache.find_blocks(1, [1]) == {}
    # A reader from before, which comes too late.
    cache.add_blocks(0, {1: block(10)})
    assert cache.find_blocks(1, [1]) == {}
    cache.add_blocks(1, {1: block(10)})
    assert set(cache.find_blocks(1, [1])) == {1}
