"""What a vehicle's camera meets reaches people: boxes, the logbook, and a mail.

Nothing here is a stand-in: the simulated vehicle draws its camera's pictures and speaks ROS 2, the
gateway's detector looks at them, Chromium shows them, and a mail server takes the mail.
"""

from __future__ import annotations

import asyncio
import email
import email.policy
import os
import re
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

import httpx
import pytest
from aiosmtpd.controller import Controller
from patience import PATIENCE_MS, PATIENCE_S
from playwright.async_api import Browser, Page as BrowserPage, async_playwright, expect
from ports import free_port
from priority import let_children_run
from shared_trust import usual_trust

from talaia.objects.worker import OWN_FILE
from talaia.wire import browser as wire
from talaia.wire.columns import unpack_columns

from .conftest import launching, missing, need_ros2
from .people import Page, page as opened_by
from .stack import PASSWORD, SITE, Process, Stack, until

pytestmark = [pytest.mark.robot, pytest.mark.browser]

ROOT = Path(__file__).parents[2]
EXAMPLE = (ROOT / "examples/agv/site.yaml").read_text()
# Of the example: an alarm for who stands in the way. Besides one for what is seen at all.
DESCRIPTION = EXAMPLE.replace("\nsite: agv\n", f"\nsite: {SITE}\n").replace(
    "\nalarms:\n",
    "\nalarms:\n"
    "  dog: {name: A dog is about, kind: detection, stream: camera/front, label: dog,"
    " confidence: 0.4}\n",
)


class Mailbox:
    """A mail server on loopback."""

    def __init__(self) -> None:
        """Listen at a port of its own."""
        self.mails: list[tuple[list[str], str, str]] = []
        self.pictures: list[bytes] = []
        self.port = free_port()
        self._server = Controller(self, hostname="127.0.0.1", port=self.port)
        self._server.start()

    async def handle_DATA(self, _server, _session, envelope) -> str:  # noqa: N802 - aiosmtpd's name
        mail = email.message_from_bytes(envelope.content, policy=email.policy.default)
        text = mail.get_body(("plain",)).get_content()
        self.pictures += [part.get_content() for part in mail.iter_attachments()]
        self.mails.append((envelope.rcpt_tos, mail["Subject"], text))
        return "250 OK"

    def close(self) -> None:
        self._server.stop()


class Seeing(Stack):
    """The simulated vehicle with its camera, and a hub that may reach the mail server."""

    description = DESCRIPTION

    def __init__(self, folder: Path, mailbox: Mailbox) -> None:
        """Let a person be told by mail before anything can be seen."""
        self._mailbox = mailbox
        super().__init__(folder, people={"boss": "admin", "driver": "operator"})

    def start_robot(self) -> Process:
        words = ["-m", "talaia", "sim", "vehicle", "--domain", str(self._world.domain)]
        words += ["--log", str(self.folder / "actuations.jsonl")]
        return Process(words, self.folder / "robot.log", self._ros)

    def start_hub(self) -> Process:
        words = ["-m", "talaia", "hub", "--data", str(self.folder), "--plain"]
        words += ["--host", "127.0.0.1", "--port", str(self.port)]
        words += ["--notify-network", "127.0.0.1/32"]
        self.hub = Process(words, self.folder / "hub.log", {})
        return self.hub

    def start_gateway(self) -> Process:
        asyncio.run(self._want_mail())
        return super().start_gateway()

    async def _want_mail(self) -> None:
        await self.hub.says("ready", PATIENCE_S)
        await self.robot.says("ready", PATIENCE_S)
        origin = {"Origin": self.address}
        async with httpx.AsyncClient(
            base_url=self.address, headers=origin, verify=usual_trust()
        ) as boss:
            signed = await boss.post("/api/login", json={"name": "boss", "password": PASSWORD})
            signed.raise_for_status()
            way = {
                "name": "Mail", "kind": "mail", "host": "127.0.0.1", "port": self._mailbox.port,
                "security": "none", "sender": "talaia@example.org",
            }  # fmt: skip
            made = await boss.post("/api/ways", json=way)
            made.raise_for_status()
            rule = {"site": SITE, "way": made.json()["id"], "target": "boss@example.org",
                    "least": "info", "over": False, "group_s": 0}  # fmt: skip
            (await boss.post("/api/me/rules", json=rule)).raise_for_status()


@pytest.fixture
def mailbox() -> Iterator[Mailbox]:
    listening = Mailbox()
    yield listening
    listening.close()


@pytest.fixture
def seeing(tmp_path: Path, mailbox: Mailbox) -> Iterator[Seeing]:
    need_ros2()
    for module in ("mujoco", "onnxruntime"):
        if not __import__("importlib.util").util.find_spec(module):
            missing(module)
    if not OWN_FILE.is_file():
        missing(f"{OWN_FILE} (python tools/make_detector.py makes it)")
    running = Seeing(tmp_path, mailbox)
    try:
        yield running
    finally:
        running.close()


async def signed_in(chrome: Browser, seeing: Seeing) -> BrowserPage:
    page = await chrome.new_page(viewport={"width": 1280, "height": 900})
    page.set_default_timeout(PATIENCE_MS)
    answer = await page.context.request.post(
        f"{seeing.address}/api/login",
        data={"name": "boss", "password": PASSWORD},
        headers={"Origin": seeing.address},
    )
    assert answer.ok, await answer.text()
    return page


async def let_camera_and_detector_run(seeing: Seeing) -> None:
    """Give what draws and what looks the priority of all others here, whenever they start.

    Both give way to everything else on their machine: beside other tests they would stand still.
    """
    while True:
        for part in (seeing.robot, seeing.gateway):
            let_children_run(part.popen.pid)
        await asyncio.sleep(1.0)


async def picture_of(page: BrowserPage, name: str) -> None:
    """Keep a screenshot where a person asked for them."""
    folder = os.environ.get("TALAIA_PICTURES")
    if folder:
        await page.screenshot(path=Path(folder) / f"{name}.png")


async def boxed(page: BrowserPage, label: str) -> float:
    """Wait for a box of this label and give where its middle is, as a part of the picture."""
    box = page.locator(f"t-camera .box[data-label='{label}']").first
    await expect(box).to_be_visible(timeout=PATIENCE_MS)
    await expect(box).to_have_text(re.compile(rf"^\s*{label} \d+\s%\s*$"))
    # Both at one moment: a box goes with its picture, and the next brings another.
    script = """(boxes, label) => {
        const box = boxes.shadowRoot.querySelector(`.box[data-label='${label}']`);
        if (!box) return -1;
        const [part, all] = [box.getBoundingClientRect(), boxes.getBoundingClientRect()];
        // Not laid out yet.
        if (all.width === 0) return -1;
        return (part.x + part.width / 2 - all.x) / all.width;
    }"""
    deadline = time.monotonic() + PATIENCE_S
    while (at := await page.locator("t-camera t-boxes").evaluate(script, label)) < 0:
        assert time.monotonic() < deadline, f"no box of a {label} stays"
    return float(at)


async def mail_of(mailbox: Mailbox, what: str) -> str:
    await until(
        lambda: [each for each in mailbox.mails if what in each[1]],
        PATIENCE_S,
        f"a mail of {what!r}; there are {[each[1] for each in mailbox.mails]}",
    )
    to, subject, text = next(each for each in mailbox.mails if what in each[1])
    assert to == ["boss@example.org"]
    return f"{subject}\n{text}"


async def test_a_person_and_a_dog_are_framed_logged_and_told_of(
    seeing: Seeing, mailbox: Mailbox, chromium: str
) -> None:
    await seeing.gateway.says("linked to", PATIENCE_S)
    running = asyncio.create_task(let_camera_and_detector_run(seeing))
    async with async_playwright() as playing:
        chrome = await playing.chromium.launch(**launching(chromium))
        page = await signed_in(chrome, seeing)
        await page.goto(f"{seeing.address}/sites/{SITE}/devices/camera")
        # From where it starts the person stands to the left of the middle, the dog to the right.
        assert 0.2 < await boxed(page, "person") < 0.5
        assert 0.6 < await boxed(page, "dog") < 1.0
        await picture_of(page, "objects-boxes")
        assert "dog seen" in await mail_of(mailbox, "A dog is about")
        # What was seen goes with the words.
        assert any(picture.startswith(b"\xff\xd8") for picture in mailbox.pictures)

        # A page that shows no camera leaves the machine to those who drive.
        await page.goto(f"{seeing.address}/sites/{SITE}/logbook")
        async with opened_by(seeing, "driver") as driver:
            await meet_and_turn_away(driver)
            assert "Persons in the drive path is 1" in await mail_of(
                mailbox, "in the vehicle's way"
            )

        await page.goto(f"{seeing.address}/sites/{SITE}/logbook")
        for label in ("person", "dog"):
            row = page.get_by_text(f"{label} seen at Front camera").first
            await expect(row).to_be_visible(timeout=PATIENCE_MS)
        await expect(page.get_by_text("Somebody is in the vehicle's way").first).to_be_visible()
        await expect(page.get_by_text("Persons in the drive path is above 0").first).to_be_visible()
        await picture_of(page, "objects-logbook")

        await page.goto(f"{seeing.address}/sites/{SITE}/sightings")
        # The astronaut on the wall counts at times.
        for words in (r"1 person|\d+ people|\d+ persons", "1 dog"):
            shown = page.locator("t-sighting").filter(has_text=re.compile(words)).first
            picture = shown.locator("img")
            await expect(picture).to_be_visible(timeout=PATIENCE_MS)
            assert await picture.evaluate("img => img.decode().then(() => img.naturalWidth)") > 16
        await picture_of(page, "objects-sightings")
        await chrome.close()
    running.cancel()


class Pose(NamedTuple):
    """Where the vehicle is in the house: from its start, along its first heading (m; rad)."""

    x: float
    yaw: float


POSE_CHANNELS = ["base/pose.x", "base/pose.yaw"]
# Two metres before the person: in the drive path, and the feet on the picture for a metre more.
IN_THE_WAY_M = 1.25


def newest_pose(driver: Page) -> Pose:
    """Give what the page was told last."""
    found: dict[int, float] = {}
    for update in reversed(driver.got):
        if isinstance(update, wire.Values):
            columns = unpack_columns(update)
            found = dict(zip(columns.channel.tolist(), columns.value.tolist(), strict=True)) | found
            if len(found) == len(POSE_CHANNELS):
                break
    return Pose(found.get(0, 0.0), found.get(1, 0.0))


async def drive_until(
    driver: Page, linear: float, angular: float, done: Callable[[], object]
) -> None:
    """Hold a direction; on a machine that is so busy that the lease is lost, press anew."""
    began = time.monotonic()
    while not done():
        assert time.monotonic() - began < PATIENCE_S, "it did not come to that"
        assert (await driver.take()).yours
        since = len(driver.got)

        def lost(since: int = since) -> bool:
            news = [each for each in driver.got[since:] if isinstance(each, wire.LeaseUpdate)]
            return bool(news) and not news[-1].yours

        driver.press(linear, angular)
        await until(lambda lost=lost: done() or lost(), what="what is driven for")
        await driver.let_go()


async def meet_and_turn_away(driver: Page) -> None:
    """Drive towards the person, which slows the vehicle down; then look elsewhere.

    How far is driven goes by where the vehicle says that it is: what a detector on a busy machine
    sees late is waited for while the vehicle stands where the person is in its way.
    """

    def told() -> bool:
        news = [each for each in driver.all(wire.AlarmUpdate) if each.alarm == "person_in_the_way"]
        return bool(news) and news[-1].phase == "active"

    def slowed() -> bool:
        news = [each for each in driver.got[since:] if isinstance(each, wire.DriveUpdate)]
        return any(each.cap <= 0.4 and 0 < each.linear <= 0.4 * 0.22 + 1e-9 for each in news)

    def gone() -> bool:
        ended = {each.label for each in driver.all(wire.SightingUpdate) if each.ended_us}
        return ended >= {"person", "dog"}

    await driver.say(wire.Subscribe(sub=1, site=SITE, channels=POSE_CHANNELS, every_ms=0))
    await drive_until(driver, 0.22, 0.0, lambda: newest_pose(driver).x > IN_THE_WAY_M)
    await until(told, what="the alarm that somebody is in the way")
    since = len(driver.got)
    await drive_until(driver, 0.22, 0.0, slowed)
    # To the wall behind it, and there it stays: who turned on would meet them again.
    await drive_until(driver, 0.0, 1.0, lambda: abs(newest_pose(driver).yaw) > 2.6)
    await until(gone, what="the end of both sightings")
