"""Driving through the real chain, and everything that must stop it."""

from __future__ import annotations

import asyncio

from .people import page
from .stack import Stack, until


async def test_smoke(stack: Stack) -> None:
    await stack.ready()
    async with page(stack, "driver") as driver:
        await driver.take()
        driver.press(0.3)
        await until(lambda: any(x.v == [0.3, 0.0] for x in stack.heard("/cmd_vel")), 10)
        at = stack.hub.kill()
        await until(lambda: stack.heard("/cmd_vel", at), 10)
        await asyncio.sleep(2)
        print([(round((x.t-at)/1e6,1), x.v) for x in stack.heard("/cmd_vel", at)][:5])
    print(stack.gateway.said())
    print(stack.hub.said())
