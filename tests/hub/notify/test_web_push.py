"""Web Push from end to end: an alarm becomes a notification, and a click on it opens the alarm.

Everything is real but the browser vendor's push service, which the internet has and this machine
has not. `PushManager.subscribe` alone is replaced in the page: Chromium refuses it where it cannot
reach its vendor. Instead of it the page gets an address on this machine and keys of the test's.
There, over HTTPS, the hub's own request is checked (VAPID, RFC 8292) and decrypted (RFC 8291), and
its text is handed to the real service worker by the browser's debugging protocol, as the vendor's
service would. The notification is shown and clicked by a desktop's service, see `desktop`.
"""

# ruff: noqa: D107

from __future__ import annotations

import asyncio
import base64
import hmac
import json
import os
import shutil
import time

import pytest
from browser_program import CHROMIUM
from cryptography.hazmat.primitives import hashes
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.hazmat.primitives.asymmetric.utils import encode_dss_signature
from cryptography.hazmat.primitives.ciphers.aead import AESGCM
from cryptography.hazmat.primitives.serialization import Encoding, PublicFormat
from patience import PATIENCE_MS
from playwright.async_api import async_playwright, expect

from ..chromium import program_or_skip, sign_in_on
from ..conftest import DESCRIPTION
from .desktop import Desktop
from .peers import Peer, certified, served

pytestmark = [pytest.mark.browser, pytest.mark.timeout(120)]

ALARMS = """
alarms:
  low: {name: Battery low, kind: limit, signal: power/voltage, below: 11, max_age: 3600,
        severity: critical, advice: Bring it home.}
  high: {name: Battery high, kind: limit, signal: power/voltage, above: 20, max_age: 3600}
"""


def b64(raw: bytes) -> str:
    return base64.urlsafe_b64encode(raw).decode().rstrip("=")


def unb64(text: str) -> bytes:
    return base64.urlsafe_b64decode(text + "=" * (-len(text) % 4))


def point(key: ec.EllipticCurvePublicKey) -> bytes:
    return key.public_bytes(Encoding.X962, PublicFormat.UncompressedPoint)


def derived(salt: bytes, secret: bytes, info: bytes, length: int) -> bytes:
    """HKDF (RFC 5869) with SHA-256, of one block."""
    key = hmac.digest(salt, secret, "sha256")
    return hmac.digest(key, info + b"\x01", "sha256")[:length]


class PushService(Peer):
    """A browser vendor's push service with one subscription; it has the browser's keys, too."""

    def __init__(self) -> None:
        super().__init__()
        self.answer = "201 Created"
        self.browser_key = ec.generate_private_key(ec.SECP256R1())
        self.secret = os.urandom(16)

    @property
    def origin(self) -> str:
        return f"https://127.0.0.1:{self.port}"

    def subscription(self) -> dict[str, object]:
        keys = {"p256dh": b64(point(self.browser_key.public_key())), "auth": b64(self.secret)}
        return {"endpoint": f"{self.origin}/push/1", "keys": keys}

    async def message(self, hub_key: str) -> str:
        """Wait for the next message; check who sent it, and give what only the browser can read."""
        line, fields, body = await self.news.get()
        assert line == "POST /push/1 HTTP/1.1"
        assert int(fields["ttl"]) > 0
        assert fields["urgency"] == "high"
        self.signed_by(hub_key, fields["authorization"])
        assert fields["content-encoding"] == "aes128gcm"
        return self.decrypted(body)

    def signed_by(self, hub_key: str, authorization: str) -> None:
        """Check the signature of RFC 8292: by the key that the page subscribed with."""
        scheme, _, said = authorization.partition(" ")
        parts = dict(part.strip().split("=", 1) for part in said.split(","))
        assert (scheme, parts["k"].rstrip("=")) == ("vapid", hub_key)
        head, claims, signature = parts["t"].split(".")
        assert json.loads(unb64(head))["alg"] == "ES256"
        raw = unb64(signature)
        key = ec.EllipticCurvePublicKey.from_encoded_point(ec.SECP256R1(), unb64(hub_key))
        key.verify(
            encode_dss_signature(int.from_bytes(raw[:32]), int.from_bytes(raw[32:])),
            f"{head}.{claims}".encode(),
            ec.ECDSA(hashes.SHA256()),
        )
        claimed = json.loads(unb64(claims))
        assert (claimed["aud"], claimed["sub"]) == (self.origin, "mailto:admin@example.org")
        assert time.time() < claimed["exp"] <= time.time() + 86_400

    def decrypted(self, body: bytes) -> str:
        """Decrypt a message of one record, written anew from RFC 8188 and 8291."""
        salt, size, length = body[:16], int.from_bytes(body[16:20]), body[20]
        sender, record = body[21 : 21 + length], body[21 + length :]
        assert len(record) <= size
        theirs = ec.EllipticCurvePublicKey.from_encoded_point(ec.SECP256R1(), sender)
        shared = self.browser_key.exchange(ec.ECDH(), theirs)
        info = b"WebPush: info\0" + point(self.browser_key.public_key()) + sender
        secret = derived(self.secret, shared, info, 32)
        key = derived(salt, secret, b"Content-Encoding: aes128gcm\0", 16)
        nonce = derived(salt, secret, b"Content-Encoding: nonce\0", 12)
        plain = AESGCM(key).decrypt(nonce, record, None).rstrip(b"\0")
        assert plain.endswith(b"\x02")
        return plain[:-1].decode()


@pytest.fixture
async def push_service(tmp_path, monkeypatch):
    context, trusted = certified(tmp_path, "127.0.0.1")
    monkeypatch.setenv("SSL_CERT_FILE", str(trusted))
    # A browser's address is a public one in any case; of this machine's the test makes one.
    monkeypatch.setattr("talaia.hub.notify.senders._NETWORKS_OF_PUSH", ("127.0.0.1/32",))
    service, server = await served("127.0.0.1", PushService(), context)
    yield service
    server.close()


@pytest.fixture
async def desktop():
    if not shutil.which("dbus-daemon"):
        (pytest.fail if os.environ.get("TALAIA_REQUIRE_ALL") else pytest.skip)("no dbus-daemon")
    desktop = Desktop()
    await desktop.open()
    yield desktop
    await desktop.close()


@pytest.fixture
async def profile(desktop, tmp_path):
    """A person's Chromium, with notifications allowed to whoever asks."""
    # The shell shows no notifications.
    program = program_or_skip(*CHROMIUM)
    kept = {key: value for key, value in os.environ.items() if key != "LD_LIBRARY_PATH"}
    expect.set_options(timeout=PATIENCE_MS)
    async with async_playwright() as play:
        context = await play.chromium.launch_persistent_context(
            tmp_path / "profile",
            executable_path=program,
            args=["--no-sandbox", "--disable-gpu"],
            env={**kept, "DBUS_SESSION_BUS_ADDRESS": desktop.address},
            permissions=["notifications"],
        )
        context.set_default_timeout(PATIENCE_MS)
        yield context
        await context.close()


SUBSCRIBE = """
PushManager.prototype.subscribe = async (asked) => {
  const key = btoa(String.fromCharCode(...new Uint8Array(asked.applicationServerKey)));
  window.askedOfPush = { visible: asked.userVisibleOnly, key };
  return { toJSON: () => (%s) };
};
"""


async def deliver(page, origin: str, text: str) -> None:
    """Hand a message to the page's service worker, as the vendor's service would."""
    debug = await page.context.new_cdp_session(page)
    found = asyncio.get_running_loop().create_future()

    def updated(event) -> None:
        for each in event["registrations"]:
            if each["scopeURL"] == f"{origin}/" and not found.done():
                found.set_result(each["registrationId"])

    debug.on("ServiceWorker.workerRegistrationUpdated", updated)
    await debug.send("ServiceWorker.enable")
    await debug.send(
        "ServiceWorker.deliverPushMessage",
        {"origin": origin, "registrationId": await found, "data": text},
    )
    await debug.detach()


async def test_alarm_becomes_a_notification_and_a_click_opens_it(
    hub, profile, desktop, push_service
) -> None:
    gateway = await hub.gateway()
    await gateway.hello(DESCRIPTION + ALARMS)
    admin = await hub.client("admin")
    way = {"name": "Browsers", "kind": "push", "sender": "admin@example.org"}
    assert (await admin.post("/api/ways", json=way)).status_code == 201

    # A person turns it on.
    await profile.add_init_script(SUBSCRIBE % json.dumps(push_service.subscription()))
    page = await profile.new_page()
    page.set_default_timeout(PATIENCE_MS)
    await sign_in_on(page, hub, "operator")
    await page.goto(f"{hub.origin}/account")
    await page.get_by_role("button", name="Take messages in this browser").click()
    await expect(page.get_by_role("button", name="Remove Chrome on Linux")).to_be_visible()
    asked = await page.evaluate("window.askedOfPush")
    hub_key = b64(base64.b64decode(asked["key"]))
    assert asked["visible"] is True
    await page.get_by_role("button", name="Notify me of alarms").click()
    await page.get_by_label("Gathered for (s)").fill("0")
    await page.get_by_role("button", name="Notify me", exact=True).click()
    await page.get_by_role("button", name="Send a test").click()
    await expect(page.get_by_text("the test was taken")).to_be_visible()
    assert "a test message" in await push_service.message(hub_key)

    # An alarm is raised.
    await gateway.samples(("power/voltage", time.time_ns() // 1000, 10.0))
    said = await push_service.message(hub_key)
    assert json.loads(said)["open"] == "/alarms?alarm=agv/low"
    await deliver(page, hub.origin, said)
    shown = await desktop.shown.get()
    assert "Battery low (critical)" in shown.title
    assert "Voltage is 10 V, below 11 V" in shown.text

    # Clicked on, it opens the alarm beside the page that is there.
    async with profile.expect_page() as opening:
        await desktop.click(shown)
    opened = await opening.value
    await opened.wait_for_url("**/alarms?alarm=agv/low")
    await expect(opened.locator("li[aria-current=true]")).to_contain_text("Battery low")
    await expect(opened.locator("li[aria-current=true]")).to_contain_text("raised")
    assert page.url == f"{hub.origin}/account"

    # The page of alarms goes to the next one; no other is opened.
    await gateway.samples(("power/voltage", time.time_ns() // 1000, 12.0))
    assert json.loads(await push_service.message(hub_key))["title"].startswith("over: ")
    await gateway.samples(("power/voltage", time.time_ns() // 1000, 21.0))
    said = await push_service.message(hub_key)
    await deliver(page, hub.origin, said)
    await desktop.click(await desktop.shown.get())
    await opened.wait_for_url("**/alarms?alarm=agv/high")
    await expect(opened.locator("li[aria-current=true]")).to_contain_text("Battery high")
    # The first blank page of the profile, the account's and the alarms'.
    assert len(profile.pages) == 3


async def test_whatever_a_message_says_a_click_stays_on_the_page_of_alarms(
    hub, profile, desktop
) -> None:
    page = await profile.new_page()
    page.set_default_timeout(PATIENCE_MS)
    await page.goto(f"{hub.origin}/login")
    await page.evaluate(
        "navigator.serviceWorker.register('/push.js').then(() => navigator.serviceWorker.ready)"
        ".then(() => true)"
    )
    for where in ("https://evil.test/alarms", "//evil.test/alarms", "/admin/people", 7):
        said = json.dumps({"key": f"about {where}", "title": "t", "open": where})
        await deliver(page, hub.origin, said)
        async with profile.expect_page() as opening:
            await desktop.click(await desktop.shown.get())
        opened = await opening.value
        # Nobody is signed in there: the way back is to the alarms.
        await opened.wait_for_url(f"{hub.origin}/login?return=%2Falarms")
        # Else the next click would find a page that is there.
        await opened.close()
