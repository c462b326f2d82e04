"""Statements that are made once and given a window find what one finds who looks at every block."""

import random

from talaia.hub.history.blocks.rollup import RollupPiece
from talaia.hub.history.engine import open_engine
from talaia.hub.history.queries.window import (
    StoredWindow,
    blocks_behind,
    gaps_of,
    outside_rollups,
    overlapping_blocks,
)
from talaia.hub.history.writing.bulk_writes import insert_rows
from talaia.hub.store import history_tables as tables
from talaia.hub.store.tables import metadata

BLOCKS = 150


def block_row(chance: random.Random, number: int) -> dict[str, object]:
    """Make a block of one of two channels, up to 400 long, somewhere; some begin together."""
    first = chance.randrange(60) * 50
    last = first + chance.randrange(400)
    return {
        "id": number, "channel_id": 1 + number % 2, "finest_us": chance.choice([0, 5, 30]),
        "bytes": 1, "samples": 1 + number, "numbers": 1, "total": 1.0, "squares": 0.0,
        "low": 1.0, "low_us": first, "high": 1.0, "high_us": last, "last": 1.0, "last_us": last,
        "first_us": first,
    }  # fmt: skip


def random_window(chance: random.Random) -> StoredWindow:
    """Make a window of a channel, up to the length of everything."""
    from_us = chance.randrange(-500, 3_500)
    before = chance.choice([BLOCKS + 1, 90])
    return StoredWindow(chance.choice([1, 2]), from_us, from_us + chance.randrange(5_000), 400,
                        before, 1)  # fmt: skip


def blocks_in(blocks: list[dict[str, object]], window: StoredWindow) -> list[dict[str, object]]:
    """Find the blocks that overlap a window by looking at each, in the order of their beginning."""
    found = [
        block
        for block in blocks
        if block["channel_id"] == window.channel
        and block["id"] < window.before_block
        and block["first_us"] <= window.to_us
        and block["last_us"] >= window.from_us
    ]
    return sorted(found, key=lambda block: (block["first_us"], block["id"]))


def test_blocks_of_a_window_are_those_that_overlap_it(url) -> None:
    chance = random.Random(5)  # noqa: S311 - samples
    engine = open_engine(url, writes=True)
    metadata.create_all(engine, list(tables.HISTORY_TABLES))
    blocks = [block_row(chance, number) for number in range(1, BLOCKS + 1)]
    with engine.begin() as connection:
        insert_rows(connection, tables.block, blocks)
        for _ in range(60):
            window = random_window(chance)
            due = blocks_in(blocks, window)
            ids, samples = [block["id"] for block in due], sum(block["samples"] for block in due)
            for most in (samples - 1, samples, 10**9):
                found = overlapping_blocks(connection, window, most)
                assert (None if found is None else [row.id for row in found]) == (
                    None if samples > most else ids
                )
            # A few at a time, each time behind the last of them.
            after, seen = (-(2**63), 0), []
            while rows := blocks_behind(connection, window, after, 7):
                seen += [row.id for row in rows]
                assert len(seen) <= len(ids)
                after = (rows[-1].first_us, rows[-1].id)
            assert seen == ids
            middle = (window.from_us + window.to_us) // 2
            pieces = [
                RollupPiece(0, window.from_us, middle),
                RollupPiece(5, middle, window.to_us + 1),
            ]
            outside = [
                (number, row.id) for number, row in outside_rollups(connection, window, pieces)
            ]
            wanted = [
                (number, block["id"])
                for number, piece in enumerate(pieces)
                for block in blocks_in(
                    blocks, window._replace(from_us=piece.from_us, to_us=piece.past_us - 1)
                )
                if block["finest_us"] == 0 or block["finest_us"] > piece.width_us
            ]
            assert sorted(outside) == sorted(wanted)
    engine.dispose()


def test_gaps_of_a_window_are_those_of_its_site_that_touch_it(url) -> None:
    engine = open_engine(url, writes=True)
    metadata.create_all(engine, list(tables.HISTORY_TABLES))
    boots = [{"id": at, "site": f"agv{at}", "boot": "b"} for at in (1, 2)]
    gaps = [
        {
            "boot_id": 1 + at % 2, "first_seq": at, "last_seq": at, "from_us": 10 * at,
            "to_us": 10 * at + 5, "reason": f"gap {at}",
        }
        for at in range(20)
    ]  # fmt: skip
    with engine.begin() as connection:
        insert_rows(connection, tables.boot, boots)
        insert_rows(connection, tables.gap, gaps)
        for from_us, to_us in ((0, 200), (25, 60), (26, 39), (500, 600)):
            found = [gap.reason for gap in gaps_of(connection, "agv1", from_us, to_us)]
            assert found == [
                gap["reason"]
                for gap in gaps
                if gap["boot_id"] == 1 and gap["from_us"] <= to_us and gap["to_us"] >= from_us
            ]
    engine.dispose()
