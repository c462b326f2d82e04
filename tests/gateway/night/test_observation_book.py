"""What was observed is numbered, kept until the hub has it, and never told twice as new."""

from __future__ import annotations

import cProfile
import pstats

import msgspec
import pytest
from hypothesis import example, given, strategies as st
from night_observatory import request

from talaia.gateway.night.night_values import ObservationChange
from talaia.gateway.night.observation_book import (
    MOST_WAITING,
    BookContent,
    BookEntry,
    ObservationBook,
)
from talaia.gateway.night.planning.charged_time import MOST_CHARGES
from talaia.model.observing.states import (
    FINAL_OBSERVATION_STATES,
    OBSERVATION_CHANGES,
    ObservationState,
    SuspensionCause,
)

pytestmark = pytest.mark.pure
S = ObservationState


def change(
    name: str, state: ObservationState, *frames: int, spent: float = 0.0
) -> ObservationChange:
    return ObservationChange(name, state, frames, block_s=spent)


class Disk:
    """What a run left: the whole book, and what was written behind it."""

    def __init__(self) -> None:
        """Begin empty."""
        self.whole = msgspec.json.encode(BookContent())
        self.lines: list[bytes] = []
        # Updates that were written, each as often as it was.
        self.written = 0

    def write(self, book: ObservationBook) -> None:
        pages = book.take_pages()
        if pages.whole is not None:
            self.whole, self.lines = msgspec.json.encode(pages.whole), []
            self.written += len(pages.whole.waiting)
        else:
            self.lines += [msgspec.json.encode(entry) for entry in pages.entries]
            self.written += len(pages.entries)

    def read(self) -> ObservationBook:
        entries = [msgspec.json.decode(line, type=BookEntry) for line in self.lines]
        return ObservationBook(msgspec.json.decode(self.whole, type=BookContent), "site", entries)


def restarted(book: ObservationBook) -> ObservationBook:
    """Give what another run reads from the disk."""
    data = msgspec.json.encode(book.content)
    return ObservationBook(msgspec.json.decode(data, type=BookContent), "site-later")


def test_one_try_keeps_its_id_over_interruptions_and_a_restart_and_the_next_has_another() -> None:
    book = ObservationBook(BookContent(), "site")
    first = book.record_change(change("m31", S.IN_PROGRESS), 10.0)
    book.record_change(change("m31", S.SUSPENDED, 2), 20.0)
    book = restarted(book)
    ended = book.record_change(change("m31", S.COMPLETED, 5), 30.0)
    assert (ended.id, ended.number) == (first.id, 3)
    again = book.record_change(change("m31", S.IN_PROGRESS), 40.0)
    assert again.id != first.id


def test_what_a_killed_gateway_had_under_way_is_suspended_with_its_frames() -> None:
    book = ObservationBook(BookContent(), "site")
    book.record_change(change("m31", S.IN_PROGRESS, 2), 10.0)
    book = restarted(book)
    (update,) = book.close_interrupted(50.0)
    assert (update.state, update.cause) == (S.SUSPENDED, SuspensionCause.FAULT)
    assert update.frames_done == [2]
    assert book.close_interrupted(60.0) == []


def test_block_time_of_all_visits_of_a_try_is_charged_once() -> None:
    book = ObservationBook(BookContent(), "site")
    book.record_change(change("m31", S.IN_PROGRESS, spent=0.0), 0.0)
    book.record_change(change("m31", S.IN_PROGRESS, 1, spent=60.0), 60.0)
    assert book.record_change(change("m31", S.SUSPENDED, 1, spent=80.0), 80.0).block_s == 80.0
    book.record_change(change("m31", S.IN_PROGRESS, 1, spent=0.0), 500.0)
    assert book.record_change(change("m31", S.COMPLETED, 2, spent=70.0), 570.0).block_s == 150.0


def test_frames_of_this_gateway_count_before_the_hub_knows_of_them() -> None:
    book = ObservationBook(BookContent(), "site")
    book.record_change(change("m31", S.SUSPENDED, 2), 10.0)
    assert book.frames_done([request("m31")]) == {"m31": (2,)}


def test_what_is_completed_here_is_not_begun_again_until_the_hub_asks_it_anew() -> None:
    book = ObservationBook(BookContent(), "site")
    book.record_change(change("m31", S.IN_PROGRESS), 10.0)
    done = book.record_change(change("m31", S.COMPLETED, 3), 20.0)
    # The hub does not know it yet, and asks for it still.
    book.settle_requests([request("m31")])
    assert book.ended == {"m31"}
    book.acknowledge_updates(done.number)
    # Now it does: who asks for it again means it so, for the frames were of no use.
    book.settle_requests([request("m31")])
    assert book.ended == frozenset()


def test_a_hub_that_is_away_for_long_hears_of_every_end_but_not_of_every_frame() -> None:
    book = ObservationBook(BookContent(), "site")
    for index in range(20):
        for frame in range(100):
            book.record_change(change(f"r{index}", S.IN_PROGRESS, frame), 10.0)
        book.record_change(change(f"r{index}", S.COMPLETED, 100), 20.0)
    waiting = book.content.waiting
    assert len(waiting) <= MOST_WAITING + 1
    assert sum(one.state is S.COMPLETED for one in waiting) == 20
    assert book.acknowledge_updates(waiting[-1].number)
    assert book.content.waiting == []


@given(
    st.lists(
        st.tuples(st.sampled_from("ab"), st.sampled_from(sorted(ObservationState)), st.booleans()),
        max_size=30,
    )
)
def test_numbers_rise_and_each_try_ends_once(
    steps: list[tuple[str, ObservationState, bool]],
) -> None:
    book = ObservationBook(BookContent(), "site")
    now: dict[str, ObservationState] = {}
    told = []
    for name, state, restart in steps:
        if restart:
            book = restarted(book)
        before = now.get(name)
        if before is None or before in FINAL_OBSERVATION_STATES:
            state = S.IN_PROGRESS
        elif state is not before and state not in OBSERVATION_CHANGES[before]:
            continue
        now[name] = state
        told.append(book.record_change(change(name, state), 1.0))
    assert [one.number for one in told] == list(range(1, len(told) + 1))
    for name in {one.id for one in told}:
        ends = [one for one in told if one.id == name and one.state in FINAL_OBSERVATION_STATES]
        assert len(ends) <= 1


def test_files_of_steps_that_are_left_out_go_on_with_the_next_one() -> None:
    book = ObservationBook(BookContent(), "site")
    for number in range(MOST_WAITING + 1):
        book.record_change(change("m31", S.IN_PROGRESS, number), float(number), [f"file-{number}"])
    waiting = book.content.waiting
    assert len(waiting) < MOST_WAITING
    named = [name for update in waiting for name in update.files]
    assert named == [f"file-{number}" for number in range(MOST_WAITING + 1)]


def charged(book: ObservationBook) -> dict[str, float]:
    return {name: round(seconds) for name, seconds in book.charged_seconds().items()}


def test_what_was_charged_while_the_hub_is_away_is_known_until_its_hours_have_it() -> None:
    book = ObservationBook(BookContent(), "site")
    book.record_change(change("m31", S.IN_PROGRESS), 0.0, payers={"m31": "school"})
    book.record_change(change("m31", S.IN_PROGRESS, 1, spent=60.0), 60.0, payers={"m31": "school"})
    book.record_change(change("m31", S.SUSPENDED, 1, spent=80.0), 80.0, payers={"m31": "school"})
    # Who paid for the try goes on to, though its request is no longer asked.
    book.record_change(change("m31", S.COMPLETED, 2, spent=70.0), 500.0)
    book.record_change(change("dark", S.COMPLETED, 5, spent=300.0), 900.0, payers={"dark": "club"})
    book.record_change(change("old", S.FAILED, spent=40.0), 950.0, payers={"old": "club"})
    assert charged(book) == {"school": 150, "club": 340}
    # Over a restart, too; a set that comes before the hub has heard of it changes nothing.
    book = restarted(book)
    book.settle_requests([])
    assert charged(book) == {"school": 150, "club": 340}
    # The hub has the first four; hours of a set that comes behind have them.
    book.acknowledge_updates(4)
    assert charged(book) == {"school": 150, "club": 340}
    book = restarted(book)
    book.settle_requests([])
    assert charged(book) == {"club": 340}


def test_what_a_killed_gateway_had_observed_stays_charged() -> None:
    book = ObservationBook(BookContent(), "site")
    book.record_change(change("m31", S.IN_PROGRESS), 0.0, payers={"m31": "school"})
    book.record_change(change("m31", S.IN_PROGRESS, 1, spent=60.0), 60.0, payers={"m31": "school"})
    book = restarted(book)
    (update,) = book.close_interrupted(500.0)
    assert update.block_s == 60.0
    assert charged(book) == {"school": 60}
    book.record_change(change("m31", S.COMPLETED, 2, spent=70.0), 600.0)
    assert charged(book) == {"school": 130}


def test_charges_of_weeks_without_new_hours_become_few_and_lose_nothing() -> None:
    book = ObservationBook(BookContent(), "site")
    for number in range(3 * MOST_CHARGES):
        payers = {"m31": "school" if number % 2 else "club"}
        update = book.record_change(change("m31", S.COMPLETED, 1, spent=2.0), 0.0, payers=payers)
        book.acknowledge_updates(update.number)
    assert charged(book) == {"school": 3 * MOST_CHARGES, "club": 3 * MOST_CHARGES}
    assert len(book.content.charges) <= MOST_CHARGES


def observe_many(book: ObservationBook, disk: Disk, count: int) -> None:
    """End so many observations of which the hub hears nothing, each change written at once."""
    for number in range(count):
        name = f"r{number}"
        for state, frames in ((S.IN_PROGRESS, 0), (S.IN_PROGRESS, 1), (S.COMPLETED, 2)):
            payers = {name: "school"}
            book.record_change(change(name, state, frames, spent=9.0), 1.0, payers=payers)
            book.charged_seconds()
            disk.write(book)


def work_of(count: int) -> tuple[int, int]:
    """Give the calls that so many observations cost, and the updates that were written."""
    book, disk, profile = ObservationBook(BookContent(), "site"), Disk(), cProfile.Profile()
    profile.runcall(observe_many, book, disk, count)
    return pstats.Stats(profile).total_calls, disk.written  # type: ignore[attr-defined]


def test_each_observation_costs_the_same_however_many_the_hub_has_not_heard_of() -> None:
    calls, written = work_of(400)
    more_calls, more_written = work_of(1600)
    # Four times as many; by the square it would be sixteen times.
    assert more_calls < 6 * calls
    assert more_written < 6 * written
    assert more_written < 6 * 3 * 1600


@given(
    st.lists(
        st.tuples(
            st.sampled_from(["change", "write", "ack", "settle", "fail"]),
            st.sampled_from("abc"),
            st.sampled_from([S.IN_PROGRESS, S.SUSPENDED, S.COMPLETED, S.FAILED]),
            st.integers(0, 30),
        ),
        max_size=60,
    )
)
@example(
    [
        ("change", "a", S.COMPLETED, 1),
        ("change", "b", S.SUSPENDED, 1),
        ("write", "a", S.FAILED, 0),
        ("ack", "a", S.FAILED, 1),
        ("write", "a", S.FAILED, 0),
    ]
)
def test_what_is_read_again_is_what_was_written_last(
    steps: list[tuple[str, str, ObservationState, int]],
) -> None:
    book, disk = ObservationBook(BookContent(), "site"), Disk()
    disk.write(book)
    for what, name, state, number in steps:
        match what:
            case "change":
                payers = {name: "school"}
                book.record_change(change(name, state, number, spent=3.0), 1.0, payers=payers)
            case "ack":
                book.acknowledge_updates(min(number, book.content.number))
            case "settle":
                book.settle_requests([request(name)])
            case "fail":
                # The disk takes nothing: all of it has to be written next time.
                book.take_pages()
                book.write_whole()
            case _:
                disk.write(book)
                again = disk.read()
                assert again.content == book.content
                assert again.charged_seconds() == pytest.approx(book.charged_seconds())
