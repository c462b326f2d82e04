"""A page that does not read: it is not cut off, it costs nobody anything, it gets the newest."""

import numpy as np

from talaia.wire.browser import FROM_BROWSER, TO_BROWSER, Subscribe, Subscribed, Values
from talaia.wire.columns import unpack_columns

BATCHES = 400
ROWS = 2_000
NOW = 1_700_000_000_000_000


async def test_stalled_page_is_bounded_and_hurts_nobody(hub, gateway) -> None:
    stalled = await hub.dial("/ws", {"Cookie": await hub.cookie("admin"), "Origin": hub.origin})
    asked = Subscribe(sub=1, site="agv", channels=["base/speed"], every_ms=0)
    await stalled.send(FROM_BROWSER.encode(asked))
    page = await hub.page("operator")
    await page.say(asked)
    await page.hear(Subscribed)
    browsers = hub.hub.core.browsers
    slow = next(each for each in browsers if each.who.name == "admin")
    for at in range(BATCHES):
        value = float(at)
        await gateway.samples(*[("base/speed", NOW + at, value)] * ROWS)
        # The page that reads gets every batch although the other one reads none.
        got = await page.hear(Values)
        assert np.frombuffer(got.value)[-1] == value
        assert slow.waiting <= 8 * 1024 * 1024
    assert slow.waiting > 0
    last = -1.0
    while last != BATCHES - 1:
        message = TO_BROWSER.decode(await stalled.recv())
        if isinstance(message, Values):
            piece = unpack_columns(message)
            # What goes past the outbox and what waited in it come in their order.
            assert last <= piece.value[0] <= piece.value[-1]
            last = piece.value[-1]
    await stalled.close()
