"""Notes of people at the hub: written, changed, searched and taken away, over its routes."""

from __future__ import annotations

import csv
import io

from talaia.wire import browser

NOW = 1_700_000_000_000_000
AT = "/api/sites/agv/notes"
NOTE = {"device": "base", "signal": "", "from_us": NOW, "to_us": NOW, "text": "The wheel slipped"}


async def listed(client, **asked: object) -> list[str]:
    answer = await client.get(AT, params=asked)
    assert answer.status_code == 200, answer.text
    return [note["text"] for note in answer.json()["notes"]]


async def written(client, **more: object) -> dict[str, object]:
    answer = await client.post(AT, json={**NOTE, **more})
    assert answer.status_code == 201, answer.text
    return answer.json()


async def test_a_note_is_written_found_changed_and_removed_and_all_of_it_is_logged(
    hub, gateway
) -> None:
    operator, admin = [await hub.client(name) for name in ("operator", "admin")]
    span = {"from_us": NOW - 5_000_000, "to_us": NOW, "signal": "speed"}
    made = await written(operator, **span, text="  Two lines\nof \u202etext  ")
    # Lines stay; what would turn the writing round is shown as what it is.
    assert (made["text"], made["version"]) == ("Two lines\nof \\u202etext", 1)
    assert await listed(admin, text="lines TWO") == [made["text"]]
    assert await listed(admin, from_us=NOW + 1) == []
    changed = {**NOTE, "text": "One line", "base": 1}
    after = (await admin.put(f"{AT}/{made['id']}", json=changed)).json()
    assert (after["who"], after["changed_by"], after["version"]) == ("operator", "admin", 2)
    # The operator has seen the first version alone.
    late = await operator.put(f"{AT}/{made['id']}", json=changed)
    assert (late.status_code, late.json()["code"]) == (409, "changed")
    assert (await operator.delete(f"{AT}/{made['id']}")).status_code == 204
    assert (await operator.delete(f"{AT}/{made['id']}")).status_code == 404
    rows = (await admin.get("/api/audit", params={"kind": "note "})).json()["rows"]
    said = [(row["kind"], row["who"], row["device"]) for row in rows]
    assert said == [
        ("note removed", "operator", "base"),
        ("note changed", "admin", "base"),
        ("note written", "operator", "base"),
    ]
    # What a removed note said can still be read there.
    assert "One line" in rows[0]["message"]
    # In the logbook a note stands at its moment, and not where it was written.
    events = (await admin.get("/api/sites/agv/events")).json()["events"]
    assert [event["kind"] for event in events if event["kind"].startswith("note")] == []


async def test_who_may_only_look_writes_nothing_and_reads_what_they_may_view(hub, gateway) -> None:
    operator, guest, admin = [await hub.client(name) for name in ("operator", "guest", "admin")]
    made = await written(operator)
    # A guest sees what is public of the site, and no notes of its people.
    assert await listed(guest) == []
    assert (await guest.post(AT, json=NOTE)).status_code == 403
    assert (await guest.delete(f"{AT}/{made['id']}")).status_code == 404
    kept = (await hub.people.find_by_name("operator")).password_hash
    await hub.people.add_person("second", kept, "operator")
    second = await hub.client("second")
    # Another operator reads it, and changes nothing of it.
    assert await listed(second) == [NOTE["text"]]
    (row,) = (await second.get(AT)).json()["notes"]
    assert row["may_change"] is False
    assert (await second.put(f"{AT}/{made['id']}", json={**NOTE, "base": 1})).status_code == 403
    (row,) = (await admin.get(AT)).json()["notes"]
    assert row["may_change"] is True


async def test_what_is_no_note_is_refused(hub, gateway) -> None:
    operator = await hub.client("operator")
    for wrong in (
        {"to_us": NOW - 1},
        {"text": " \n "},
        {"text": "x" * 4001},
        {"device": "", "signal": "speed"},
        {"device": "no_such"},
        {"signal": "no_such"},
    ):
        answer = await operator.post(AT, json={**NOTE, **wrong})
        assert answer.status_code == 422, wrong
    assert await listed(operator) == []


async def test_pages_are_told_of_a_note_at_once(hub, gateway) -> None:
    watching = await hub.page("operator")
    operator = await hub.client("operator")
    await written(operator)
    news = await watching.hear(browser.EventUpdate, lambda told: told.kind == "note written")
    assert (news.site, news.device, news.who) == ("agv", "base", "operator")


async def test_notes_go_out_as_a_file_that_no_spreadsheet_runs(hub, gateway) -> None:
    operator, guest = await hub.client("operator"), await hub.client("guest")
    await written(operator, text="=1+1")
    await written(operator, from_us=NOW + 1_000_000, to_us=NOW + 2_000_000, text="later")
    asked = {"from_us": NOW, "to_us": NOW}
    answer = await operator.get(f"{AT}/export", params=asked)
    rows = list(csv.DictReader(io.StringIO(answer.text)))
    assert [(row["text"], row["from_utc"]) for row in rows] == [
        ("'=1+1", "2023-11-14T22:13:20.000+00:00")
    ]
    assert "attachment" in answer.headers["content-disposition"]
    assert len((await guest.get(f"{AT}/export")).text.splitlines()) == 1
