"""Does the time of a refused sign-in tell whether there is a person of that name?"""

from __future__ import annotations

import tempfile
import time
from pathlib import Path

import httpx
import numpy as np

from talaia.clock import SystemClock
from talaia.hub.app import build_hub
from talaia.hub.auth.passwords import Passwords
from talaia.hub.settings import Settings
from talaia.hub.store.accounts.people import People
from talaia.hub.store.database import Database

ORIGIN = "http://localhost"


async def refusals(each: int) -> tuple[np.ndarray, np.ndarray]:
    """Time wrong passwords (ms) for as many known and unknown names, in turn."""
    with tempfile.TemporaryDirectory() as folder:
        settings = Settings(data=Path(folder), plain=True)
        hub = build_hub(settings, SystemClock())
        async with hub.running():
            database = Database(settings.url)
            try:
                hashed = await Passwords(settings.password_cost).hash_password("what nobody tries")
                people = People(database, SystemClock())
                for number in range(each):
                    await people.add_person(f"known{number}", hashed, "guest")
                found = {"known": [], "other": []}
                await _refused(hub.asgi, "warm", 0)
                for number in range(each):
                    for at, (kind, times) in enumerate(found.items()):
                        began = time.perf_counter()
                        await _refused(hub.asgi, f"{kind}{number}", 2 * number + at + 1)
                        times.append((time.perf_counter() - began) * 1000)
            finally:
                await database.close()
    return np.array(found["known"]), np.array(found["other"])


async def _refused(app: object, name: str, caller: int) -> None:
    # Each from an address of its own, so that none has to wait for those before.
    client = (f"10.0.{caller // 250}.{caller % 250 + 1}", 1)
    transport = httpx.ASGITransport(app, client=client)  # type: ignore[arg-type]
    headers = {"Origin": ORIGIN}
    async with httpx.AsyncClient(transport=transport, base_url=ORIGIN, headers=headers) as page:
        answer = await page.post("/api/login", json={"name": name, "password": "wrong password"})
    assert answer.status_code == 401, answer.text
