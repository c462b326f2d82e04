"""The Alpaca API as an ASGI application: requests in, answers out.

After "ASCOM Alpaca API Reference": a question that cannot be read is answered 400 with plain text,
what a device has to say 200 with ASCOM's error number. Alpaca has no sign-in, and a browser sends a
form to any address without asking: whatever names an ``Origin`` is a page and is refused, and so is
a ``Host`` that is none of ours.
"""

from __future__ import annotations

import itertools
import json
from typing import TYPE_CHECKING, Any, NamedTuple
from urllib.parse import parse_qsl

from talaia import __version__
from talaia.hub.clients.alpaca.device_answers import (
    AlpacaDevice,
    DeviceError,
    alpaca_devices,
    answer_property,
    asked_command,
)

if TYPE_CHECKING:
    from collections.abc import Awaitable, Callable, Collection, Mapping

    from talaia.hub.clients.alpaca.device_answers import DomeCommand
    from talaia.hub.clients.alpaca.site_values import SiteValues

__all__ = ["AlpacaApplication", "AlpacaParts"]

_MOST_BODY = 8 * 1024
_MOST_NUMBER = 2**32 - 1
# All PUT methods of the three kinds of devices, so that what is not ours is told apart from what
# does not exist.
_METHOD_NAMES = frozenset(
    {
        "abortslew",
        "action",
        "averageperiod",
        "closeshutter",
        "commandblind",
        "commandbool",
        "commandstring",
        "connect",
        "connected",
        "disconnect",
        "findhome",
        "openshutter",
        "park",
        "refresh",
        "setpark",
        "slaved",
        "slewtoaltitude",
        "slewtoazimuth",
        "synctoazimuth",
    }
)


class AlpacaParts(NamedTuple):
    """What answers come from.

    Attributes:
        values: gives the site now, as the account sees it; none while there is no such site, or
            the account may not see it.
        permits: tells of a device and command whether clients may call it.
        call: calls a command for a client's address; raises `DeviceError`.
        refuse: is told what was refused: the client's address, the device, and why.
        hosts: names and addresses that a request may be for, in small letters.

    """

    values: Callable[[], SiteValues | None]
    permits: Callable[[str, str], bool]
    call: Callable[[DomeCommand, str], Awaitable[None]]
    refuse: Callable[[str, str, str], None]
    hosts: Collection[str]


class _Unreadable(Exception):
    """The request is answered with a status and plain text."""

    def __init__(self, status: int, words: str) -> None:
        super().__init__(words)
        self.status = status


class _Question(NamedTuple):
    method: str
    path: str
    arguments: dict[str, str]
    client: str

    def number(self, name: str) -> int:
        """Give a number that identifies the client or its question; 0 where there is none."""
        text = self.arguments.get(name, "0")
        if not text.isascii() or not text.isdigit() or int(text) > _MOST_NUMBER:
            raise _Unreadable(400, f"{name}: expected a whole number from 0 on")
        return int(text)


class AlpacaApplication:
    """Answers each request from what is so at that moment."""

    def __init__(self, parts: AlpacaParts) -> None:
        """Answer from ``parts``."""
        self._parts = parts
        # ASCOM wants a number of ours in each answer, which rises; it starts anew with the hub.
        self._transactions = itertools.count(1)

    async def __call__(
        self,
        scope: Mapping[str, Any],
        receive: Callable[[], Awaitable[Mapping[str, Any]]],
        send: Callable[[dict[str, Any]], Awaitable[None]],
    ) -> None:
        """Serve a request; see ASGI."""
        if scope["type"] != "http":
            return
        try:
            question = await _read_question(scope, receive, self._parts.hosts)
            answer: object = await self._answer(question)
            status, kind, body = 200, b"application/json", json.dumps(answer).encode()
        except _Unreadable as error:
            status, kind, body = error.status, b"text/plain; charset=utf-8", str(error).encode()
        headers = [
            (b"content-type", kind),
            (b"content-length", str(len(body)).encode()),
            (b"cache-control", b"no-store"),
            (b"x-content-type-options", b"nosniff"),
        ]
        await send({"type": "http.response.start", "status": status, "headers": headers})
        await send({"type": "http.response.body", "body": body})

    async def _answer(self, question: _Question) -> dict[str, object]:
        transaction = question.number("clienttransactionid")
        # Read for its errors only: Alpaca demands a number, and nothing here depends on it.
        question.number("clientid")
        answer: dict[str, object] = {
            "ClientTransactionID": transaction,
            "ServerTransactionID": next(self._transactions) & _MOST_NUMBER,
            "ErrorNumber": 0,
            "ErrorMessage": "",
        }
        values = self._parts.values()
        if question.path.startswith("/management/"):
            return {**answer, "Value": _management_answer(question, values)}
        # Found in the site as it is now: a description that has changed changes the devices.
        device, name = _find_device(question.path, values)
        try:
            # `values` is there: else no device was found.
            answer |= await self._answer_device(question, device, name)
        except DeviceError as error:
            answer |= {"ErrorNumber": error.number, "ErrorMessage": str(error)}
        return answer

    async def _answer_device(
        self, question: _Question, device: AlpacaDevice, name: str
    ) -> dict[str, object]:
        values = self._parts.values()
        if values is None:
            raise _Unreadable(400, "there is no such device")
        if question.method == "GET":
            value = answer_property(
                device, name, question.arguments, values=values, permits=self._parts.permits
            )
            return {"Value": value}
        if name not in _METHOD_NAMES:
            raise _Unreadable(400, f"there is no method {name[:40]!r}")
        try:
            asked = asked_command(
                device, name, question.arguments, values=values, permits=self._parts.permits
            )
            if asked is not None:
                await self._parts.call(asked, question.client)
        except DeviceError as error:
            self._parts.refuse(question.client, device.device, f"{name}: {error}")
            raise
        return {}


async def _read_question(
    scope: Mapping[str, Any],
    receive: Callable[[], Awaitable[Mapping[str, Any]]],
    hosts: Collection[str],
) -> _Question:
    headers = {key.decode("latin-1"): value.decode("latin-1") for key, value in scope["headers"]}
    # Programs send none. A page of any web site could else close somebody's dome from their
    # browser.
    if "origin" in headers:
        raise _Unreadable(403, "pages of browsers are not served")
    host = headers.get("host", "").lower()
    # Without its port. A name of a stranger that was made to point here (DNS rebinding) is none of
    # ours.
    bare = host.rpartition(":")[0] if host.rpartition(":")[2].isdigit() else host
    if bare.strip("[]") not in hosts:
        raise _Unreadable(403, "the Host of the request is not this server")
    method = scope["method"]
    if method not in ("GET", "PUT"):
        raise _Unreadable(405, "expected GET or PUT")
    # Parameters of a question stand in its address, those of a method in its form.
    text = scope["query_string"].decode("latin-1")
    if method == "PUT":
        text = (await _read_body(receive)).decode("utf-8", "replace")
    try:
        pairs = parse_qsl(text, keep_blank_values=True, max_num_fields=20)
    except ValueError as error:
        raise _Unreadable(400, "the parameters cannot be read") from error
    client = scope.get("client") or ("",)
    # Names of parameters are not told apart by their case in a question; we are as lenient in PUT.
    return _Question(method, scope["path"], {k.lower(): v for k, v in pairs}, str(client[0]))


async def _read_body(receive: Callable[[], Awaitable[Mapping[str, Any]]]) -> bytes:
    body = bytearray()
    while True:
        message = await receive()
        if message["type"] == "http.disconnect":
            raise _Unreadable(400, "the request ended early")
        body += message.get("body", b"")
        # Judged while it comes: what it says of its length may be a lie.
        if len(body) > _MOST_BODY:
            raise _Unreadable(413, f"expected {_MOST_BODY} bytes at the most")
        if not message.get("more_body"):
            return bytes(body)


def _management_answer(question: _Question, values: SiteValues | None) -> object:
    if question.method != "GET":
        raise _Unreadable(405, "expected GET")
    match question.path:
        case "/management/apiversions":
            return [1]
        case "/management/v1/description":
            return {
                "ServerName": "Talaia",
                "Manufacturer": "Talaia",
                "ManufacturerVersion": __version__,
                "Location": "" if values is None else values.live.description.name,
            }
        case "/management/v1/configureddevices":
            return [
                {
                    "DeviceName": device.name,
                    "DeviceType": _TYPE_NAMES[device.type],
                    "DeviceNumber": device.number,
                    "UniqueID": f"talaia-{_site_of(values)}-{device.type}-{device.device}",
                }
                for device in ([] if values is None else alpaca_devices(values))
            ]
        case _:
            pass
    raise _Unreadable(404, "there is no such address")


# As ASCOM writes them in its list; addresses have small letters.
_TYPE_NAMES = {
    "dome": "Dome",
    "observingconditions": "ObservingConditions",
    "safetymonitor": "SafetyMonitor",
}


def _site_of(values: SiteValues | None) -> str:
    return "" if values is None else values.live.name


def _find_device(path: str, values: SiteValues | None) -> tuple[AlpacaDevice, str]:
    parts = path.strip("/").split("/")
    if len(parts) != 5 or parts[:2] != ["api", "v1"]:
        raise _Unreadable(404, "there is no such address")
    kind, number, name = parts[2:]
    for device in [] if values is None else alpaca_devices(values):
        if (device.type, str(device.number)) == (kind, number):
            return device, name
    raise _Unreadable(400, "there is no such device")
