"""Missions at a hub with a gateway that answers as the test says."""

from __future__ import annotations

import asyncio

import pytest
from patience import PATIENCE_S
from sqlalchemy import event, update

from talaia.hub.store.missions.mission_store import RunRecord, StepRecord
from talaia.hub.store.tables import users
from talaia.wire import frames
from talaia.wire.browser import PageStop
from talaia.wire.frames import CommandPhase

from ...conftest import DESCRIPTION

NOW = 1_700_000_000_000_000
AT = "/api/sites/agv/missions"
EMPTY = {
    "name": "", "device": "", "command": "", "args": {}, "units": {}, "condition": "",
    "seconds": 0, "goes_on": False,
}  # fmt: skip


def wander(*, active: bool = True, **more: object) -> dict[str, object]:
    asked = {"kind": "command", "device": "base", "command": "wander", "args": {"active": active}}
    return {**EMPTY, **asked, **more}


def pause(seconds: float) -> dict[str, object]:
    return {**EMPTY, "kind": "pause", "seconds": seconds}


def until(condition: str, seconds: float = 60) -> dict[str, object]:
    return {**EMPTY, "kind": "until", "condition": condition, "seconds": seconds}


async def save(client, *steps: dict[str, object], schedule: object = None) -> str:
    mission = {"name": "Patrol", "note": "", "steps": list(steps), "schedule": schedule}
    answer = await client.post(AT, json={"mission": mission})
    assert answer.status_code == 200, answer.text
    return answer.json()["id"]


async def start(client, *steps: dict[str, object]) -> None:
    answer = await client.post(f"{AT}/{await save(client, *steps)}/start", json={})
    assert answer.status_code == 200, answer.text


async def run_that(client, *states: str) -> dict:
    """Wait for the newest run to be in one of these states."""
    async with asyncio.timeout(PATIENCE_S):
        while True:
            runs = (await client.get("/api/sites/agv/mission-runs")).json()["runs"]
            if runs and runs[0]["state"] in states:
                return runs[0]


def states_of(run: dict) -> list[str]:
    return [step["state"] for step in run["steps"]]


async def answer_command(gateway, phase: CommandPhase, message: str = "") -> frames.CommandRequest:
    asked = await gateway.hear(frames.CommandRequest)
    await end_command(gateway, asked, phase, message)
    return asked


async def end_command(gateway, asked, phase: CommandPhase, message: str = "") -> None:
    await gateway.say(
        frames.CommandState(
            id=asked.id, device="base", command="wander", phase=phase, message=message
        )
    )


# What was heard stays fresh for as long as a test takes, however busy the machine is.
LASTING = DESCRIPTION.replace(
    "role: vehicle.speed\n", "role: vehicle.speed\n        max_age: 9999\n", 1
)


@pytest.fixture
async def gateway(hub):
    made = await hub.gateway()
    await made.hello(LASTING)
    return made


@pytest.fixture
async def operator(hub, gateway):
    """Sign an operator in, at a robot that was just heard."""
    client = await hub.client("operator")
    await gateway.samples(("base/speed", NOW, 0.0))
    async with asyncio.timeout(PATIENCE_S):
        while (site := (await client.get("/api/sites")).json()[0])["stale"] == site["signals"]:
            pass
    return client


async def test_steps_are_done_in_order_each_with_its_result(operator, gateway) -> None:
    await start(operator, wander(), pause(0.2), wander(active=False))
    first = await answer_command(gateway, CommandPhase.SUCCEEDED, "wandering")
    assert (first.who, first.args) == ("operator by mission Patrol", {"active": True})
    second = await answer_command(gateway, CommandPhase.SUCCEEDED)
    assert second.args == {"active": False}
    run = await run_that(operator, "succeeded")
    assert states_of(run) == ["succeeded"] * 3
    assert (run["who"], run["begun_by"], run["steps"][0]["message"]) == (
        "operator", "operator", "wandering",
    )  # fmt: skip


async def test_refusal_of_an_interlock_ends_it_and_the_rest_is_not_begun(operator, gateway) -> None:
    await start(operator, wander(), wander(active=False))
    await answer_command(gateway, CommandPhase.REFUSED, "Rain locks it")
    run = await run_that(operator, "failed")
    assert states_of(run) == ["refused", "waiting"]
    assert run["why"] == "step 1, Vehicle base: Wander about, refused: Rain locks it"


async def test_step_that_may_fail_does_not_end_it(operator, gateway) -> None:
    await start(operator, wander(goes_on=True), wander(active=False))
    await answer_command(gateway, CommandPhase.FAILED)
    await answer_command(gateway, CommandPhase.SUCCEEDED)
    assert states_of(await run_that(operator, "succeeded")) == ["failed", "succeeded"]


async def test_unknown_ends_it_even_where_a_failure_would_not(operator, gateway) -> None:
    await start(operator, wander(goes_on=True), wander(active=False))
    await answer_command(gateway, CommandPhase.UNKNOWN)
    assert states_of(await run_that(operator, "interrupted")) == ["unknown", "waiting"]


async def test_stop_ends_it_and_what_is_under_way(hub, operator, gateway) -> None:
    await start(operator, wander(), wander(active=False))
    asked = await gateway.hear(frames.CommandRequest)
    await (await hub.page("admin")).say(PageStop(site="agv", device="base", id="s"))
    pressed = await gateway.hear(frames.StopRequest)
    await gateway.say(frames.StopState(device="base", latched=True, who=pressed.who, id="s"))
    cancelled = await gateway.hear(frames.CommandCancel)
    assert cancelled.id == asked.id
    await end_command(gateway, asked, CommandPhase.CANCELLED)
    run = await run_that(operator, "stopped")
    assert run["why"] == "STOP is latched at Vehicle base, pressed by admin"
    assert states_of(run) == ["cancelled", "waiting"]


async def test_nothing_begins_while_stop_is_latched(operator, gateway) -> None:
    number = await save(operator, wander())
    await gateway.say(frames.StopState(device="base", latched=True, who="ada", id="s"))
    async with asyncio.timeout(PATIENCE_S):
        while not (await operator.get(AT)).json()["missions"][0]["problem"]:
            pass
    answer = await operator.post(f"{AT}/{number}/start", json={})
    assert answer.status_code == 409
    assert "STOP is latched" in answer.json()["message"]


async def test_lost_link_interrupts_it_and_nothing_goes_on_when_it_is_back(
    hub, operator, gateway
) -> None:
    await start(operator, wander(), wander(active=False))
    await gateway.hear(frames.CommandRequest)
    await gateway.close()
    run = await run_that(operator, "interrupted")
    assert states_of(run) == ["unknown", "waiting"]
    again = await hub.gateway()
    await again.hello()
    answer = await operator.post(f"{AT}/{await save(operator, wander())}/start", json={})
    # It came back, and nothing was heard of the device on this link that is fresh enough, or it
    # begins: in no case is the interrupted one taken up.
    assert answer.status_code in {200, 409}
    assert not [
        one for one in again.heard
        if isinstance(one, frames.CommandRequest) and one.args == {"active": False}
    ]  # fmt: skip


async def test_pause_begins_no_further_step_and_resume_does(operator, gateway) -> None:
    await start(operator, wander(), wander(active=False))
    asked = await gateway.hear(frames.CommandRequest)
    act = "/api/sites/agv/mission-runs/act"
    assert (await operator.post(act, json={"act": "pause"})).status_code == 204
    await end_command(gateway, asked, CommandPhase.SUCCEEDED)
    async with asyncio.timeout(PATIENCE_S):
        while states_of(await run_that(operator, "paused")) != ["succeeded", "waiting"]:
            pass
    assert (await operator.post(act, json={"act": "resume"})).status_code == 204
    await answer_command(gateway, CommandPhase.SUCCEEDED)
    await run_that(operator, "succeeded")


async def test_cancel_ends_it_and_what_is_under_way(operator, gateway) -> None:
    await start(operator, wander(), wander(active=False))
    asked = await gateway.hear(frames.CommandRequest)
    await operator.post("/api/sites/agv/mission-runs/act", json={"act": "cancel"})
    await gateway.hear(frames.CommandCancel)
    await end_command(gateway, asked, CommandPhase.CANCELLED)
    run = await run_that(operator, "cancelled")
    assert (run["why"], states_of(run)) == ("cancelled by operator", ["cancelled", "waiting"])


async def test_account_that_is_disabled_in_the_middle_ends_it(hub, operator, gateway) -> None:
    admin = await hub.client("admin")
    await start(operator, wander(), wander(active=False))
    asked = await gateway.hear(frames.CommandRequest)
    async with hub.hub.core.database.write() as connection:
        await connection.execute(
            update(users).where(users.c.name == "operator").values(disabled=True)
        )
    await gateway.hear(frames.CommandCancel, lambda cancel: cancel.id == asked.id)
    run = await run_that(admin, "interrupted")
    assert run["why"].startswith("operator: ")
    assert states_of(run)[1] == "waiting"


async def test_it_waits_until_a_condition_holds(operator, gateway) -> None:
    await start(operator, until("{base/speed} > 0.1"), wander())
    await gateway.samples(("base/speed", NOW + 1, 0.2))
    await answer_command(gateway, CommandPhase.SUCCEEDED)
    assert states_of(await run_that(operator, "succeeded")) == ["succeeded", "succeeded"]


async def test_condition_that_does_not_come_true_in_time_fails(operator) -> None:
    await start(operator, until("{base/speed} > 0.1", 0.3), wander())
    assert states_of(await run_that(operator, "failed")) == ["failed", "waiting"]


async def test_it_never_begins_on_a_stale_state(hub, gateway) -> None:
    client = await hub.client("operator")
    number = await save(client, wander())
    answer = await client.post(f"{AT}/{number}/start", json={})
    assert (answer.status_code, answer.json()["message"]) == (
        409, "nothing is heard of Vehicle base: its state is stale",
    )  # fmt: skip
    number = await save(client, until("{base/speed} > 1"))
    answer = await client.post(f"{AT}/{number}/start", json={})
    assert "cannot be judged now" in answer.json()["message"]


async def test_one_runs_at_a_site_at_a_time(operator) -> None:
    await start(operator, pause(60))
    answer = await operator.post(f"{AT}/{await save(operator, wander())}/start", json={})
    assert (answer.status_code, answer.json()["message"]) == (409, "Patrol goes on there")


async def missed_events(client) -> list[dict]:
    events = (await client.get("/api/sites/agv/events")).json()["events"]
    return [one for one in events if one["kind"] == "mission missed"]


async def _make_due(hub, number: str, ago_us: int) -> None:
    service = hub.hub.missions.service
    kept = await service._store.find_mission("agv", int(number))
    assert await service._store.claim_due(kept, service._now_us() - ago_us)


async def test_schedule_begins_with_the_rights_of_who_saved_it(hub, operator, gateway) -> None:
    number = await save(operator, wander(), schedule={"at": "06:00", "days": [], "date": ""})
    before = (await operator.get(AT)).json()["missions"][0]["due_us"]
    await _make_due(hub, number, 1_000_000)
    asked = await answer_command(gateway, CommandPhase.SUCCEEDED)
    assert asked.who == "operator by mission Patrol"
    run = await run_that(operator, "succeeded")
    assert (run["who"], run["begun_by"]) == ("operator", "schedule")
    # Once: the next time is again the one that is written.
    assert (await operator.get(AT)).json()["missions"][0]["due_us"] == before


async def test_missed_schedule_is_told_and_not_done_late(hub, operator, gateway) -> None:
    number = await save(operator, wander(), schedule={"at": "06:00", "days": [], "date": ""})
    await _make_due(hub, number, 3600 * 1_000_000)
    run = await run_that(operator, "missed")
    assert "the hub was not running" in run["why"]
    assert not any(isinstance(one, frames.CommandRequest) for one in gateway.heard)
    # The log takes its rows into memory, and writes them a moment later.
    async with asyncio.timeout(PATIENCE_S):
        while not (missed := await missed_events(operator)):
            pass
    assert not missed[0]["good"]


async def test_schedule_of_a_disabled_account_does_not_run(hub, operator, gateway) -> None:
    number = await save(operator, wander(), schedule={"at": "06:00", "days": [], "date": ""})
    admin = await hub.client("admin")
    async with hub.hub.core.database.write() as connection:
        await connection.execute(
            update(users).where(users.c.name == "operator").values(disabled=True)
        )
    await _make_due(hub, number, 1_000_000)
    run = await run_that(admin, "missed")
    assert run["why"] == "its account is disabled or gone"
    assert not any(isinstance(one, frames.CommandRequest) for one in gateway.heard)


async def test_run_that_the_end_of_the_hub_left_is_interrupted(hub, operator) -> None:
    store = hub.hub.missions.store
    left = RunRecord(
        site="agv", mission_id=1, name="Patrol", who="operator", begun_by="operator", began_us=NOW,
        steps=[StepRecord("Go", "running", began_us=NOW, command="c"), StepRecord("Next")],
    )  # fmt: skip
    await store.add_run(left)
    # As it does at its next start.
    await hub.hub.missions.service.open()
    run = await run_that(operator, "interrupted")
    assert (run["why"], states_of(run)) == ("the hub ended meanwhile", ["unknown", "waiting"])


async def test_mission_is_written_as_a_file_and_read_back(operator) -> None:
    number = await save(operator, wander(), pause(5))
    text = (await operator.get(f"{AT}/{number}/text")).json()["text"]
    read = (await operator.post(f"{AT}/reading", json={"text": text})).json()
    kept = (await operator.get(AT)).json()["missions"][0]["mission"]
    assert read == {"mission": kept, "where": "", "problem": "", "remedy": ""}
    wrong = text.replace("wander", "fly")
    told = (await operator.post(f"{AT}/reading", json={"text": wrong})).json()
    assert told["where"] == "$.steps[0].command"
    assert (await operator.delete(f"{AT}/{number}")).status_code == 204
    assert (await operator.get(f"{AT}/{number}/text")).status_code == 404


async def test_database_is_asked_for_due_missions_only_when_one_is_due_or_a_time_changed(
    hub, operator
) -> None:
    store = hub.hub.missions.service._store
    number = await save(operator, wander(), schedule={"at": "06:00", "days": [], "date": ""})
    kept = await store.find_mission("agv", int(number))
    assert await store.due_missions(kept.due_us - 1) == []
    asked = []
    engine = hub.hub.core.database._engine.sync_engine
    event.listen(engine, "before_cursor_execute", lambda *words: asked.append(words[2]))
    assert await store.due_missions(kept.due_us - 1) == []
    assert not [sql for sql in asked if "FROM missions" in sql]
    assert [one.id for one in await store.due_missions(kept.due_us)] == [kept.id]
    # It is not there any more, and nothing else has a time: nothing is due for ever.
    assert await store.claim_due(kept, 0)
    assert await store.due_missions(kept.due_us) == []
    # A time that is written is seen at once.
    assert await store.claim_due(kept._replace(due_us=0), kept.due_us - 5)
    assert [one.id for one in await store.due_missions(kept.due_us)] == [kept.id]
