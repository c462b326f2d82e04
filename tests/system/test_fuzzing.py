"""Every reader of foreign bytes, given kept seeds and changes of them: `make fuzz`, short."""

from __future__ import annotations

import resource
import warnings

import pytest

from .fuzz import target as fuzz
from .fuzz.mutation import mutations
from .fuzz.targets import GROUPS, targets_in

# Of each target; those that take a file apart get fewer.
TRIES = 300
MOST_GROWN_KIB = 150 * 1024


def peak_kib() -> int:
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss


@pytest.mark.parametrize("group", GROUPS)
def test_readers_raise_what_they_declare_at_once_and_in_little_memory(group) -> None:
    targets = targets_in(group)
    before = peak_kib()
    failed = []
    for target in targets:
        seeds = fuzz.load_seeds(target.name)
        tries = max(10, int(TRIES * target.share))
        with warnings.catch_warnings():
            # Of numbers out of bounds; they go to no log either.
            warnings.simplefilter("ignore")
            for data in [*seeds, *mutations(seeds, tries, target.name)]:
                try:
                    fuzz.try_input(target, data)
                except Exception as error:  # noqa: BLE001 - whatever it is, it is named
                    failed.append(f"{target.name} on {data[:1000]!r}: {error!r}")
    assert failed == []
    assert peak_kib() - before < MOST_GROWN_KIB


def understands(target, seed: bytes) -> bool:
    try:
        target.read(seed)
    except target.errors:
        return False
    return True


@pytest.mark.parametrize("group", GROUPS)
def test_each_target_has_seeds_that_it_understands(group) -> None:
    deaf = [
        target.name
        for target in targets_in(group)
        if not any(understands(target, seed) for seed in fuzz.load_seeds(target.name)[1:])
    ]
    assert deaf == []


def test_error_that_is_not_declared_and_one_second_too_many_are_found() -> None:
    def fail(data: bytes) -> None:
        raise KeyError(data)

    with pytest.raises(KeyError):
        fuzz.try_input(fuzz.FuzzTarget("made_up", fail, (ValueError,)), b"x")
    slow = fuzz.FuzzTarget("made_up", lambda _: sum(range(100_000)), ())
    with pytest.raises(fuzz.TooSlow):
        fuzz.try_input(slow, b"", most_s=0.0)
