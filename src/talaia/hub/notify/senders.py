"""One message by one way, in a process of its own; see `child`."""

from __future__ import annotations

import asyncio
import json
import os
import sys
from enum import StrEnum
from typing import TYPE_CHECKING, NamedTuple

from talaia.hub.store.alarms.notification_channels import WayKind

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from talaia.hub.notify.address_policy import Network
    from talaia.hub.notify.message import AlarmMessage
    from talaia.hub.store.alarms.notification_channels import PushBrowser, Way

__all__ = ["DeliveryResult", "Outcome", "Sender"]

_LONGEST_S = 60.0  # for a child as a whole; then it is ended
# Where to is said by a person's browser there, not by an admin: public addresses only.
_NETWORKS_OF_PUSH: tuple[str, ...] = ()
# What a child needs of our surroundings; secrets of the hub's are not among it.
_SURROUNDINGS = (
    "PATH",
    # Where this package itself may come from.
    "PYTHONPATH",
    "LANG",
    # Authorities that the administrator of this machine has added.
    "SSL_CERT_FILE",
    "SSL_CERT_DIR",
    "REQUESTS_CA_BUNDLE",
    "SYSTEMROOT",
)


class Outcome(StrEnum):
    """How it went."""

    SENT = "sent"
    # It has certainly not arrived; another try may do.
    AGAIN = "again"
    # It has not arrived, and another try will not do.
    FAILED = "failed"
    # It may have arrived.
    UNSURE = "unsure"


class DeliveryResult(NamedTuple):
    """How it went, why not, and which browsers take no messages any more."""

    outcome: Outcome
    problem: str = ""
    gone: tuple[int, ...] = ()


class Sender:
    """Sends messages."""

    def __init__(self, networks: Sequence[Network]) -> None:
        """Reach public addresses, and those in ``networks``."""
        self._networks = [str(network) for network in networks]

    async def send_message(
        self,
        way: Way,
        secrets: Mapping[str, str],
        *,
        target: str,
        message: AlarmMessage,
        browsers: Sequence[PushBrowser] = (),
    ) -> DeliveryResult:
        """Send a message; everything that goes wrong is in the answer."""
        push = way.kind is WayKind.PUSH
        # On its input, not among its arguments, which everybody on this machine can list.
        job = {
            **way.settings,
            **secrets,
            **message._asdict(),
            "kind": way.kind.value,
            "target": target,
            "networks": list(_NETWORKS_OF_PUSH) if push else self._networks,
            "browsers": [(browser.id, dict(browser.subscription)) for browser in browsers],
        }
        return await _run_child(json.dumps(job).encode())

    async def mail_file(
        self,
        way: Way,
        secrets: Mapping[str, str],
        *,
        target: str,
        message: AlarmMessage,
        file: tuple[str, str],
    ) -> DeliveryResult:
        """Mail a message with a text attached; ``file`` is its name and what is in it."""
        job = {
            **way.settings,
            **secrets,
            **message._asdict(),
            "kind": WayKind.MAIL.value,
            "target": target,
            "file": file,
            "networks": self._networks,
        }
        return await _run_child(json.dumps(job).encode())

    async def post_document(
        self, url: str, *, token: str, key: str, document: Mapping[str, object]
    ) -> str:
        """Post any JSON to a webhook; gives why it was not taken for certain, or nothing."""
        job = {
            "kind": WayKind.WEBHOOK.value,
            "url": url,
            "token": token,
            "key": key,
            "document": dict(document),
            "networks": self._networks,
        }
        result = await _run_child(json.dumps(job).encode())
        if result.outcome is Outcome.SENT:
            return ""
        return result.problem or result.outcome.value


async def _run_child(job: bytes) -> DeliveryResult:
    kept = {name: os.environ[name] for name in _SURROUNDINGS if name in os.environ}
    try:
        child = await asyncio.create_subprocess_exec(
            sys.executable,
            "-m",
            "talaia.hub.notify.child",
            stdin=asyncio.subprocess.PIPE,
            stdout=asyncio.subprocess.PIPE,
            stderr=asyncio.subprocess.PIPE,
            env=kept,
        )
    except OSError as error:
        # No process, so certainly nothing was sent.
        return DeliveryResult(Outcome.AGAIN, f"the process could not be started: {error}")
    try:
        async with asyncio.timeout(_LONGEST_S):
            said, wrong = await child.communicate(job)
    except TimeoutError:
        return DeliveryResult(
            Outcome.UNSURE, f"no end after {_LONGEST_S:g} s: it may have been delivered"
        )
    finally:
        # Also when this task is cancelled: no child outlives the hub's wish to send.
        if child.returncode is None:
            child.kill()
            await child.wait()
    try:
        told = json.loads(said)
        gone = tuple(int(browser) for browser in told.get("gone", "").split(",") if browser)
        return DeliveryResult(Outcome(told["outcome"]), told["problem"], gone)
    except (ValueError, KeyError):
        # It was killed or died: how far it had come is not known.
        last = wrong.decode("utf-8", "replace").strip().splitlines()[-1:]
        return DeliveryResult(Outcome.UNSURE, f"it ended badly: {''.join(last)[:500]}")
