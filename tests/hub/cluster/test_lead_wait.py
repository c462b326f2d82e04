"""Who comes while no hub leads is held until one does, and a socket's opening is told to it."""

import asyncio

from talaia.hub.cluster.lead_wait import HeldOpening, LeadWait


class Hubs:
    """Whether one leads, and whether one is to be expected."""

    leads = False
    expected = True

    def wait(self, held_s: float = 60.0) -> LeadWait:
        return LeadWait(lambda: self.leads, lambda: self.expected, held_s=held_s)


def now_s() -> float:
    return asyncio.get_running_loop().time()


async def test_who_comes_within_a_take_over_is_let_in_when_a_hub_leads() -> None:
    hubs = Hubs()
    wait = hubs.wait()
    held = [asyncio.create_task(wait.wait_for_lead(now_s())) for _ in range(3)]
    await asyncio.sleep(0)
    # Heard, and still none.
    wait.notify()
    await asyncio.sleep(0)
    assert not any(task.done() for task in held)
    hubs.leads = True
    wait.notify()
    assert await asyncio.gather(*held) == [True, True, True]
    assert await wait.wait_for_lead(now_s())


async def test_nobody_is_held_for_longer_than_that_or_for_nothing() -> None:
    hubs = Hubs()
    assert not await hubs.wait(held_s=0.01).wait_for_lead(now_s())
    # Who came long ago has waited already.
    assert not await hubs.wait().wait_for_lead(now_s() - 61.0)
    hubs.expected = False
    assert not await hubs.wait().wait_for_lead(now_s())


async def test_an_opening_is_said_once_more_to_the_next_hub() -> None:
    said = [{"type": "websocket.connect"}, {"type": "websocket.disconnect", "code": 1006}]

    async def receive():
        return said.pop(0)

    opening = HeldOpening(receive)
    assert (await opening.receive())["type"] == "websocket.connect"
    assert opening.begin_again()
    assert (await opening.receive())["type"] == "websocket.connect"
    # They have gone: nothing is opened for them at another one.
    assert (await opening.receive())["type"] == "websocket.disconnect"
    assert not opening.begin_again()
