"""Browsers without a screen: sign in over HTTPS, subscribe, and tell the age of what comes."""

from __future__ import annotations

import asyncio
import time

import httpx
import numpy as np
import websockets
from stack import PASSWORD, Stack, context

from talaia.wire import browser
from talaia.wire.columns import unpack_columns


async def cookie(stack: Stack, name: str = "admin") -> str:
    """Sign in and give the session's cookie."""
    async with httpx.AsyncClient(
        verify=context(stack), base_url=stack.origin, timeout=60
    ) as client:
        headers = {"Origin": stack.origin}
        answer = await client.post(
            "/api/login", json={"name": name, "password": PASSWORD}, headers=headers
        )
        answer.raise_for_status()
        return "; ".join(f"{each}={value}" for each, value in client.cookies.items())


async def listen(
    stack: Stack, session: str, topics: int, every_ms: int, seconds: float
) -> np.ndarray:
    """Subscribe to every signal and give the ages (ms) of all samples that came."""
    ages: list[np.ndarray] = []
    async with websockets.connect(
        f"wss://localhost:{stack.port}/ws",
        ssl=context(stack),
        compression=None,
        ping_interval=None,
        max_size=8 * 1024 * 1024,
        additional_headers={"Cookie": session},
        origin=stack.origin,  # type: ignore[arg-type]
    ) as socket:
        channels = [f"base/s{each}" for each in range(topics)]
        wanted = browser.Subscribe(sub=1, site="bench", channels=channels, every_ms=every_ms)
        await socket.send(browser.FROM_BROWSER.encode(wanted))
        until = asyncio.get_running_loop().time() + seconds
        warm = until - seconds + 1.0
        while (now := asyncio.get_running_loop().time()) < until:
            try:
                data = await asyncio.wait_for(socket.recv(), until - now)
            except TimeoutError:
                break
            message = browser.TO_BROWSER.decode(data)
            if isinstance(message, browser.Values) and not message.age_ms and now > warm:
                columns = unpack_columns(message)
                ages.append((time.time() * 1e6 - columns.value) / 1000)
    return np.concatenate(ages) if ages else np.array([])
