"""An observatory on INDI's own simulators: from the driver to the hub's archive."""

from __future__ import annotations

import asyncio
import io
import socket
import sys
import warnings
from contextlib import asynccontextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import httpx
import pytest
from astropy.io import fits
from astropy.wcs import WCS, FITSFixedWarning
from patience import PATIENCE_S
from shared_trust import usual_trust

sys.path.insert(0, str(Path(__file__).parents[1] / "gateway/adapters/indi"))
from indi_server import server_of

from talaia.clock import SystemClock
from talaia.gateway.run import serve_gateway
from talaia.gateway.settings import GatewaySettings as GatewaySettings, HubAddress
from talaia.hub import accounts
from talaia.hub.app import build_hub
from talaia.hub.run import server_of as hub_server_of
from talaia.hub.settings import Settings
from talaia.model.checks.site_checks import raise_first
from talaia.model.yaml_text.load import load_site
from talaia.wire import browser
from talaia.wire.browser import FROM_BROWSER, TO_BROWSER

if TYPE_CHECKING:
    from collections.abc import AsyncIterator

    from websockets.asyncio.client import ClientConnection

pytestmark = pytest.mark.robot
PASSWORD = "a password for a minute"  # noqa: S105 - of a hub that lives for a minute on loopback
DESCRIPTION = """
talaia: 1
site: sky
name: Test observatory
zone: Europe/Madrid
connections: {indi: {kind: indi, port: %d}}
"""


@asynccontextmanager
async def observatory(port: int, data: Path) -> AsyncIterator[tuple[httpx.AsyncClient, str]]:
    """A hub and a gateway in this process; gives the operator's client and where the hub is."""
    settings = Settings(data=data, plain=True, port=0, password_cost=4)
    await accounts.create_user(settings, "operator", PASSWORD, "operator")
    key = await accounts.create_gateway(settings, "sky")
    hub = build_hub(settings, SystemClock())
    listener = socket.create_server(("127.0.0.1", 0))
    listener.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    place = f"127.0.0.1:{listener.getsockname()[1]}"
    ready, ended = asyncio.Event(), asyncio.Event()
    server = hub_server_of(hub, ready.set)
    serving = asyncio.ensure_future(server.serve(sockets=[listener]))
    await asyncio.wait_for(ready.wait(), PATIENCE_S)
    gateway = asyncio.ensure_future(
        serve_gateway(
            raise_first(load_site(DESCRIPTION % port)),
            GatewaySettings(
                hub=HubAddress.from_text(f"ws://{place}", allow_plain=True),
                key=key,
                data=data / "gateway",
            ),
            ended,
        )
    )
    try:
        async with httpx.AsyncClient(
            base_url=f"http://{place}",
            headers={"Origin": f"http://{place}"},
            timeout=PATIENCE_S,
            verify=usual_trust(),
        ) as client:
            words = {"name": "operator", "password": PASSWORD}
            answer = await client.post("/api/login", json=words)
            assert answer.status_code == 200, answer.text
            yield client, place
    finally:
        ended.set()
        await asyncio.wait_for(gateway, PATIENCE_S)
        server.should_exit = True
        await serving


async def until_there(client: httpx.AsyncClient, path: str, holds) -> dict:
    async with asyncio.timeout(PATIENCE_S):
        while True:
            answer = await client.get(path)
            if answer.status_code == 200 and holds(answer.json()):
                return answer.json()
            await asyncio.sleep(0.2)


async def does(page: ClientConnection, device: str, command: str, **args: object) -> str:
    """Give a command as a page does, and wait for its end."""
    command_id = f"{device}-{command}-{len(args)}"
    await page.send(
        FROM_BROWSER.encode(
            browser.PageCommand(
                site="sky", device=device, command=command, id=command_id, args=args
            )
        )
    )
    async with asyncio.timeout(PATIENCE_S):
        while True:
            news = TO_BROWSER.decode(await page.recv())
            if (
                isinstance(news, browser.CommandUpdate)
                and news.id == command_id
                and news.phase not in ("accepted", "running")
            ):
                assert news.phase == "succeeded", news.message
                return news.message


async def test_picture_goes_from_the_camera_to_the_archive_with_its_circumstances(
    tmp_path: Path,
) -> None:
    from websockets.asyncio.client import connect

    drivers = [f"indi_simulator_{each}" for each in ("telescope", "ccd", "weather", "focus")]
    async with (
        server_of(tmp_path, *drivers) as server,
        observatory(server.port, tmp_path / "hub") as (client, place),
    ):
        await until_there(
            client,
            "/api/sites/sky",
            lambda site: (
                {"ccd_simulator", "weather_simulator", "telescope_simulator"}
                <= {each["id"] for each in site["devices"]}
            ),
        )
        cookie = "; ".join(f"{name}={value}" for name, value in client.cookies.items())
        async with connect(
            f"ws://{place}/ws", additional_headers={"Cookie": cookie}, origin=f"http://{place}"
        ) as page:
            await does(page, "ccd_simulator", "expose", seconds=0.5, target="NGC 7000")
        found = await until_there(client, "/api/sites/sky/frames", lambda answer: answer["frames"])
        (frame,) = found["frames"]
        assert frame["device"] == "ccd_simulator"
        assert frame["target"] == "NGC 7000"
        assert frame["problems"] == []
        assert frame["exposure_s"] == 0.5
        answer = await client.get(f"/api/sites/sky/frames/{frame['id']}/file")
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            with fits.open(io.BytesIO(answer.content)) as hdus:
                hdus.verify("exception")
                header = hdus[0].header
                assert hdus[0].data.shape == (1024, 1280)
        assert header["OBSERVAT"] == "Test observatory"
        assert header["TELESCOP"] == "Telescope Simulator"
        assert header["INSTRUME"] == "CCD Simulator"
        assert header["AMBTEMP"] == 15.0
        assert header["WXSAFE"] == "safe"
        assert header["FOCALLEN"] == 900.0
        assert header["FILTER"]
        with warnings.catch_warnings():
            # It tells that it works out MJD-OBS of DATE-OBS for itself.
            warnings.simplefilter("ignore", FITSFixedWarning)
            world = WCS(header)
        middle = world.pixel_to_world(639.5, 511.5)
        assert middle.ra.deg == pytest.approx(header["RA"], abs=1e-6)
        assert middle.dec.deg == pytest.approx(header["DEC"], abs=1e-6)
        # 5.2 µm at 900 mm: 1.19 arcseconds a pixel.
        assert abs(header["CDELT2"]) * 3600 == pytest.approx(1.192, abs=0.01)
        preview = await client.get(f"/api/sites/sky/frames/{frame['id']}/preview")
        assert preview.content.startswith(b"\x89PNG")
        assert not [*(tmp_path / "hub" / "gateway" / "outbox").glob("*.bin")]
