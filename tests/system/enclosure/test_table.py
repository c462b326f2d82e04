"""What the enclosure's table has run of each row, and that it says so."""

from __future__ import annotations

from .results import PROTOCOLS, SEEDS, Trial, table
from .rows import ROWS
from .trial import DISKS, disk_of


def test_every_row_is_done_on_every_kind_of_disk_with_every_protocol() -> None:
    for protocol in PROTOCOLS:
        for row in ROWS:
            seeds = range(1, SEEDS[protocol] + 1)
            if row.disks and protocol in row.protocols:
                assert {disk_of(row, seed) for seed in seeds} == set(DISKS)


def test_rows_have_names_of_their_own() -> None:
    assert len({row.name for row in ROWS}) == len(ROWS)


def test_the_table_says_on_which_disks_a_row_was_done_and_counts_each_violation() -> None:
    trials = [
        Trial("s", "ROS 2", "rain", seed, [1.0 * seed], [], wrong, {}, disk)
        for seed, disk, wrong in ((1, "healthy", []), (2, "full", ["late"]), (6, "full", []))
    ]
    text = table(trials)
    assert "| Rain | ROS 2 | 3 | 1–6 | 1 / 2 / 0 / 0 | 1 | 1.0 / 2.0 / 6.0 | 13 | – |  |" in text
    assert "- rain, ROS 2, seed 2, disk full: late" in text
    assert "3 runs, 1 violations" in text
