"""What the database keeps of notes, on every kind of database."""

from __future__ import annotations

import time

import pytest
from sqlalchemy import delete, insert

from talaia.clock import HandClock
from talaia.hub.store.accounts.people import People
from talaia.hub.store.note_tables import notes
from talaia.hub.store.sites.notes import NoteBody, NoteFilter, NoteStore
from talaia.hub.store.tables import users

MOMENT = NoteBody("base", "speed", 1_000, 1_000, "Wheel slipped")
SPAN = NoteBody("", "", 2_000, 9_000, "Run 7: 50% load\non wet ground")


@pytest.fixture
async def author(database) -> int:
    return await People(database, HandClock()).add_person("ada", "hash", "operator")


@pytest.fixture
def store(database) -> NoteStore:
    return NoteStore(database, HandClock())


async def found(store: NoteStore, **wanted: object) -> list[str]:
    rows, _ = await store.find_notes("agv", NoteFilter(**wanted), 10)
    return [row.body.text for row in rows]


async def test_notes_are_found_by_span_device_author_and_words(store, author) -> None:
    for body in (MOMENT, SPAN):
        await store.add_note("agv", body, author, "ada")
    await store.add_note("moon", MOMENT._replace(text="elsewhere"), author, "ada")
    both = [SPAN.text, MOMENT.text]
    assert await found(store) == both
    assert await found(store, from_us=1_000, to_us=2_000) == both
    # Any part of a span does, and its ends are included.
    assert await found(store, from_us=9_000, to_us=9_500) == [SPAN.text]
    assert await found(store, from_us=9_001) == []
    assert await found(store, devices=frozenset({"base"})) == [MOMENT.text]
    assert await found(store, devices=frozenset()) == []
    assert await found(store, device="base") == [MOMENT.text]
    assert await found(store, who="bob") == []
    # Each word somewhere, in any case and order; nothing of it is a wildcard.
    assert await found(store, text="GROUND run") == [SPAN.text]
    assert await found(store, text="50%") == [SPAN.text]
    assert await found(store, text="5%d") == []
    assert await found(store, text="ada") == both


async def test_the_second_of_two_who_change_a_note_at_once_is_told(store, author) -> None:
    kept = await store.add_note("agv", MOMENT, author, "ada")
    first = await store.change_note(kept, MOMENT._replace(text="by A"), base=1, who="ada")
    assert (first.version, first.changed_by) == (2, "ada")
    assert await store.change_note(kept, MOMENT._replace(text="by B"), base=1, who="bob") is None
    assert await store.find_note("agv", kept.id) == first
    assert await store.find_note("moon", kept.id) is None
    assert await store.remove_note(kept) is True
    assert await store.remove_note(kept) is False
    assert await store.change_note(kept, MOMENT, base=2, who="ada") is None


async def test_a_note_outlives_its_author_and_is_nobody_else_s(database, store, author) -> None:
    kept = await store.add_note("agv", MOMENT, author, "ada")
    async with database.write() as connection:
        await connection.execute(delete(users).where(users.c.id == author))
    after = await store.find_note("agv", kept.id)
    assert (after.who, after.author) == ("ada", None)


async def test_ten_thousand_notes_are_listed_and_searched_page_by_page(database, store) -> None:
    row = {"site": "agv", "device": "base", "signal": "", "author_id": None, "who": "ada"}
    stamps = {"created_us": 1, "changed_us": 1, "changed_by": "ada", "version": 1}
    # Two of each microsecond: pages neither repeat nor skip one.
    rows = [
        {**row, **stamps, "from_us": at // 2, "to_us": at // 2 + 5, "text": f"note {at} of many"}
        for at in range(10_000)
    ]
    async with database.write() as connection:
        await connection.execute(insert(notes), rows)
    began = time.monotonic()
    page, more = await store.find_notes("agv", NoteFilter(from_us=2_000, to_us=2_100), 100)
    assert (len(page), more) == (100, True)
    words = await found(store, text="9999 many")
    assert words == ["note 9999 of many"]
    # A tenth of what a person takes for a wait; measured 10 to 40 ms here.
    assert time.monotonic() - began < 2
    every = [note.id async for note in store.iterate_notes("agv", NoteFilter())]
    assert len(every) == len(set(every)) == 10_000
