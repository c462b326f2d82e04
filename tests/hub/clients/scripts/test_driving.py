"""Scripts that drive: shut, forbidden, permitted; stuck, in error, and past the rules of tools."""

from __future__ import annotations

import asyncio
import time

import pytest
from patience import PATIENCE_S

from talaia.client import AsyncClient, BadSettings, Client, DrivingRefused, ProtocolShut
from talaia.wire import browser, frames
from talaia.wire.frames import LeaseOp

from ..tokens import open_protocol, token_of

pytestmark = pytest.mark.asyncio(loop_scope="module")


async def client_of(world, name) -> AsyncClient:
    return AsyncClient(world.hub.origin, await token_of(world.hub, name))


async def permit(world, name, *, allowed=True) -> None:
    admin = await world.admin()
    person = (await world.hub.people.find_by_name(name)).id
    asked = {"person": str(person), "site": "agv", "device": "base", "allowed": allowed}
    assert (await admin.put("/api/client-drivers", json=asked)).status_code == 204


async def grant_lease(gateway, epoch) -> frames.LeaseRequest:
    """Give the lease to the next who asks, as a gateway does."""
    lease = await gateway.hear(frames.LeaseRequest, lambda ask: ask.op is LeaseOp.TAKE)
    await gateway.say(
        frames.LeaseState(
            device="base", session=lease.session, who=lease.who, epoch=epoch, remains_ms=3000
        )
    )
    await gateway.say(frames.ControlTick(tick=epoch))
    return lease


def forget_frames(gateway) -> None:
    gateway.heard[:] = [one for one in gateway.heard if not isinstance(one, frames.DriveFrame)]


async def test_driving_is_shut_until_an_admin_opens_it_and_permits_the_account(
    shared_world,
) -> None:
    client = await client_of(shared_world, "driver")
    with pytest.raises(ProtocolShut, match="an admin opens it under Admin, Clients"):
        async with client.drive_device("agv/base"):
            pass
    await open_protocol(shared_world.hub, "scripts")
    with pytest.raises(DrivingRefused, match="an admin may let your account"):
        async with client.drive_device("agv/base"):
            pass
    gateway = shared_world.gateways["agv"]
    assert not [one for one in gateway.heard if isinstance(one, frames.LeaseRequest)]


async def test_velocity_moves_once_within_half_the_limits_and_an_error_sends_zeros(
    shared_world,
) -> None:
    gateway = shared_world.gateways["agv"]
    await open_protocol(shared_world.hub, "scripts")
    await permit(shared_world, "driver")
    client = await client_of(shared_world, "driver")

    async def script() -> None:
        async with client.drive_device("agv/base") as drive:
            with pytest.raises(BadSettings):
                await drive.set_velocity(float("nan"))
            await drive.set_velocity(0.9, 0.2)
            moved.append(await gateway.hear(frames.DriveFrame, lambda frame: frame.linear > 0))
            raise RuntimeError("of the script")

    moved = []
    forget_frames(gateway)
    running = asyncio.create_task(script())
    lease = await grant_lease(gateway, 11)
    with pytest.raises(RuntimeError, match="of the script"):
        await running
    assert lease.who == "driver"
    # Half of the description's 1 m/s.
    assert (moved[0].linear, moved[0].angular) == (0.5, 0.2)
    zero = await gateway.hear(frames.DriveFrame, lambda frame: frame.seq > moved[0].seq)
    assert (zero.linear, zero.angular) == (0.0, 0.0)
    await gateway.hear(frames.LeaseRequest, lambda ask: ask.op is LeaseOp.FREE)
    await permit(shared_world, "driver", allowed=False)


async def test_script_that_stands_still_stops_the_vehicle_within_the_time_of_one_velocity(
    shared_world,
) -> None:
    gateway = shared_world.gateways["agv"]
    await open_protocol(shared_world.hub, "scripts")
    await permit(shared_world, "operator")
    token = await token_of(shared_world.hub, "operator")
    stuck = asyncio.Event()
    loop, began = asyncio.get_running_loop(), []

    def script() -> None:
        with Client(shared_world.hub.origin, token) as hub, hub.drive_device("agv/base") as drive:
            drive.drive_for(0.3, seconds=0.25)
            drive.set_velocity(0.4)
            began.append(time.monotonic())
            # Stuck: it neither drives nor ends.
            asyncio.run_coroutine_threadsafe(stuck.wait(), loop).result(PATIENCE_S)

    forget_frames(gateway)
    running = asyncio.create_task(asyncio.to_thread(script))
    await grant_lease(gateway, 12)
    moved = [
        await gateway.hear(frames.DriveFrame, lambda frame: frame.linear == pytest.approx(0.3))
        for _ in range(2)
    ]
    last = await gateway.hear(frames.DriveFrame, lambda frame: frame.linear == pytest.approx(0.4))
    await gateway.hear(frames.DriveFrame, lambda frame: frame.linear == 0 and frame.seq > last.seq)
    # The hub judges by its own clock; see `test_client_driving` for the 250 ms themselves.
    assert time.monotonic() - began[0] > 0.2
    assert moved[0].seq < last.seq
    later = [one for one in gateway.heard if isinstance(one, frames.DriveFrame)]
    assert [one for one in later if one.linear and one.seq > last.seq] == []
    stuck.set()
    await running
    await gateway.hear(frames.LeaseRequest, lambda ask: ask.op is LeaseOp.FREE)
    await permit(shared_world, "operator", allowed=False)


async def test_permission_that_is_taken_back_ends_the_drive_with_the_reason(shared_world) -> None:
    gateway = shared_world.gateways["agv"]
    await open_protocol(shared_world.hub, "scripts")
    await permit(shared_world, "driver")
    client = await client_of(shared_world, "driver")
    forget_frames(gateway)

    async def script() -> None:
        async with client.drive_device("agv/base") as drive:
            await permit(shared_world, "driver", allowed=False)
            await drive.drive_for(0.2, seconds=PATIENCE_S)

    running = asyncio.create_task(script())
    await grant_lease(gateway, 13)
    with pytest.raises(DrivingRefused, match="an admin may let your account"):
        await running
    moved = [one for one in gateway.heard if isinstance(one, frames.DriveFrame) and one.linear]
    assert moved == []


async def test_token_does_not_drive_over_a_pages_socket_whatever_it_may(shared_world) -> None:
    gateway = shared_world.gateways["agv"]
    token = await token_of(shared_world.hub, "operator")
    connection = await shared_world.hub.dial("/ws", {"Authorization": f"Bearer {token}"})
    page = shared_world.hub.peer(connection)
    gateway.heard.clear()
    velocity = browser.PageDrive(
        site="agv", device="base", epoch=1, seq=1, tick=1, linear=1.0, angular=0.0
    )
    for message in (
        browser.PageLease(site="agv", device="base", op=LeaseOp.TAKE),
        velocity,
        browser.PageReset(site="agv", device="base", epoch=1),
    ):
        await page.say(message)
        problem = await page.hear(browser.RequestError)
        assert (problem.code, problem.about) == ("forbidden", type(message).__struct_config__.tag)
        assert "/clients/scripts/" in problem.message
    await page.say(browser.PageStop(site="agv", device="base", id="s"))
    await gateway.hear(frames.StopRequest)
    asked = frames.LeaseRequest | frames.DriveFrame | frames.ResetRequest
    assert not [one for one in gateway.heard if isinstance(one, asked)]
    await page.close()


async def test_socket_for_driving_does_nothing_else_and_nothing_of_other_sites(
    shared_world,
) -> None:
    await open_protocol(shared_world.hub, "scripts")
    token = await token_of(shared_world.hub, "operator")
    headers = {"Authorization": f"Bearer {token}"}
    page = shared_world.hub.peer(await shared_world.hub.dial("/clients/scripts/agv", headers))
    for message, word in (
        (browser.Subscribe(sub=1, site="agv", channels=[]), "over /ws"),
        (browser.PageCommand(site="agv", device="base", command="turn", id="x"), "over /ws"),
        (browser.PageLease(site="agv", device="base", op=LeaseOp.TAKE), "takes the lease"),
        (browser.PageStop(site="moon", device="rover", id="s"), "is of 'agv'"),
    ):
        await page.say(message)
        problem = await page.hear(browser.RequestError)
        assert word in problem.message
    await page.connection.send(b"\xc1")
    assert await page.closed() == 1002
