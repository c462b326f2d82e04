"""``talaia history``: where histories are, and a move that the hub does, or the command itself."""

import asyncio
from dataclasses import replace

import pytest
from hub.conftest import RunningHub, settings_in

from talaia.cli.errors import CliError
from talaia.cli.history.main import main
from talaia.cli.history.moving import list_histories, move_history
from talaia.clock import SystemClock
from talaia.hub.app import build_hub
from talaia.hub.errors import CannotStart
from talaia.hub.lock import hub_lock
from talaia.wire.frames import Ack

ROW_US = 1_700_000_000_000_000


@pytest.fixture
def settings(tmp_path):
    """Give the settings of a hub that knows another server."""
    servers = tmp_path / "servers.yaml"
    servers.write_text(f"servers: {{east: 'sqlite:///{tmp_path}/east.db'}}\n")
    return replace(settings_in(tmp_path), history_servers=servers)


async def stored_values(client, past):
    asked = {"channel": "power/voltage", "from_us": ROW_US, "to_us": ROW_US + 10**9}
    answer = await client.get("/api/sites/agv/history", params={**asked, "width": past})
    (series,) = answer.json()["series"]
    return series["v"]


async def test_the_hub_that_runs_moves_a_site_while_its_gateway_sends(settings) -> None:
    said = []
    # As a hub's process has it.
    with hub_lock(settings.data):
        async with RunningHub(settings, None) as hub:
            await move_while_sending(settings, hub, said)
    assert said[-1] == "agv: own"
    assert any("on its way to east" in line for line in said)


async def move_while_sending(settings, hub, said) -> None:
    await hub.populate()
    gateway = await hub.gateway()
    await gateway.hello()
    ended = asyncio.Event()

    async def keep_sending() -> int:
        first = 0
        while not ended.is_set():
            rows = [("power/voltage", ROW_US + at, at / 8) for at in range(first, first + 20)]
            await gateway.samples(*rows)
            first += 20
            await gateway.hear(Ack, lambda ack, past=first: ack.below >= past)
        return first

    sending = asyncio.create_task(keep_sending())
    for server in ("east", "own"):
        await move_history(settings, "agv", server, said.append)
    ended.set()
    past = await sending
    client = await hub.client("operator")
    assert await stored_values(client, past) == [at / 8 for at in range(past)]
    kinds = (await (await hub.client("admin")).get("/api/audit")).json()["rows"]
    assert [row["message"] for row in kinds if row["kind"] == "history moved"] == [
        "the history of agv from east to own",
        "the history of agv from own to east",
    ]


async def test_without_a_hub_the_command_moves_it(settings) -> None:
    async with RunningHub(settings, None) as hub:
        await hub.populate()
        gateway = await hub.gateway()
        await gateway.hello()
        rows = [("power/voltage", ROW_US + at, at / 8) for at in range(50)]
        await gateway.samples(*rows)
        await gateway.hear(Ack, lambda ack: ack.below >= 50)
    said = []
    await move_history(settings, "agv", "east", said.append)
    await list_histories(settings, said.append)
    assert said[-2:] == ["agv: east", "agv: east"]
    # Where it is: nothing is to be done.
    await move_history(settings, "agv", "east", said.append)
    async with RunningHub(settings, None) as hub:
        client = await hub.client("operator")
        assert await stored_values(client, 50) == [at / 8 for at in range(50)]
    # A hub that does not know that server would write it in a second place.
    with pytest.raises(CannotStart, match="'east'"):
        async with build_hub(replace(settings, history_servers=None), SystemClock()).running():
            pass


def test_words_that_cannot_be_are_told(settings, tmp_path) -> None:
    data, servers = f"--data={tmp_path}", f"--history-servers={settings.history_servers}"
    with pytest.raises(CliError, match="name one of own, east"):
        main(["move", "agv", "--to", "west", data, servers])
    with pytest.raises(CliError, match="there is no site 'agv'"):
        main(["move", "agv", "--to", "east", data, servers])
    with pytest.raises(CliError, match="name the file"):
        main(["move", "agv", "--to", "east", data])
    with pytest.raises(CliError, match="is no folder"):
        main(["list", f"--data={tmp_path}/none"])
