"""``talaia gateway enrol``: trade a one-time code for this gateway's own key.

The code carries the beginning of the hash of the hub's public key. The hub must show that very key
before it is told the code, so nobody between can take it.
"""

from __future__ import annotations

import argparse
import asyncio
import http.client
import json
import platform
import ssl
import sys
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple
from urllib.parse import urlsplit

from talaia.certificate_pin import hash_of_key
from talaia.errors import TalaiaError
from talaia.gateway.errors import EnrolRefused, HubUnreachable
from talaia.gateway.key_file import KeyFile, KeyPlace
from talaia.gateway.settings import HubAddress
from talaia.gateway.uplink.tls import HubTrust
from talaia.wire.enrolment import read_code

if TYPE_CHECKING:
    from collections.abc import Sequence

    from talaia.wire.enrolment import EnrolmentCode

__all__ = ["enrol_gateway", "main"]

# A hub on a slow line; a person waits at a terminal.
_WAIT_S = 20.0
# Bytes of an answer that are read; a hub's is a few hundred.
_LONGEST = 64 * 1024


class EnrolmentAnswer(NamedTuple):
    """What the hub said."""

    status: int
    body: dict[str, str]
    retry_s: str


def main(argv: Sequence[str]) -> int:
    """Enrol, keep the key, and say how to go on; 2 when that cannot be done."""
    options = _read_options(argv)
    try:
        found = _enrol_into(options)
    except TalaiaError as error:
        sys.stderr.write(f"talaia gateway enrol: {error}\n")
        return 2
    known = "the hub is known by its key" if found.fingerprint else "its authority is trusted"
    if found.hub.startswith("ws://"):
        known = "in clear text, on this machine only"
    sys.stdout.write(
        f"enrolled: this is the gateway of the site {found.site} at {found.hub} ({known})\n"
        f"start it: talaia gateway {found.site}.yaml --key-file {options.key_file}\n"
    )
    return 0


def _enrol_into(options: argparse.Namespace) -> KeyFile:
    # First: a code is used up by asking, and a key that cannot be kept would be lost.
    place = KeyPlace(options.key_file)
    try:
        found = enrol_gateway(
            options.hub,
            text=options.code,
            name=options.name,
            ca=options.ca,
            allow_plain=options.allow_plain,
        )
        place.save_key(found)
    # Also after a failure, so that no half-made file stays.
    finally:
        place.close()
    return found


def _read_options(argv: Sequence[str]) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        "talaia gateway enrol",
        description="Enrol this gateway with a one-time code from the hub's page.",
    )
    said = "https://host:port; of several hubs that are one, all addresses with commas between"
    parser.add_argument("hub", metavar="HUB", help=said)
    parser.add_argument("code", metavar="CODE", help="as the page shows it; good for 15 minutes")
    parser.add_argument(
        "--key-file", required=True, type=Path, metavar="FILE", help="where the key is kept"
    )
    parser.add_argument(
        "--name", default=platform.node()[:100], help="what the gateway is called (this machine)"
    )
    parser.add_argument(
        "--ca",
        type=Path,
        metavar="FILE",
        help="certificate authorities (PEM) for a code without the hub's key",
    )
    parser.add_argument("--allow-plain", action="store_true", help="permit http:// on loopback")
    return parser.parse_args(argv)


def enrol_gateway(
    url: str, *, text: str, name: str, ca: Path | None = None, allow_plain: bool = False
) -> KeyFile:
    """Trade a code for a key.

    Raises:
        CodeMistyped: the code cannot be one.
        SettingsError: the address is none, or is in clear text.
        HubUnreachable: the hub is not there, or is not the one that the code names.
        EnrolRefused: the hub does not take the code.

    """
    # Before anybody is asked: a slip of the finger shows in its last two characters.
    code = read_code(text)
    urls = [part if "://" in part else f"https://{part}" for part in url.split(",")]
    hub = HubAddress.from_text(",".join(urls), ca=ca, allow_plain=allow_plain)
    # The pin is a short hash: the full one is taken from the key itself and used from then on.
    if code.pin and not hub.plain:
        hub = replace(hub, fingerprint=_key_hash(hub, code), ca=None)
    # With the pin it accepts only a certificate of the key that was just looked at.
    context = asyncio.run(HubTrust(hub).context())
    answer = _request_key(hub, context, {"code": str(code), "name": name})
    if answer.status != http.HTTPStatus.OK:
        raise EnrolRefused(answer.body.get("code", ""), _refusal_words(hub, answer))
    # An authority's certificate is renewed with another key; ours keeps its own.
    pinned = bool(hub.fingerprint) and not _vouched_for(hub)
    try:
        return KeyFile(
            key=answer.body["key"],
            site=answer.body["site"],
            gateway=answer.body["gateway"],
            hub=hub.text,
            fingerprint=hub.fingerprint if pinned else "",
            # Absolute: the gateway may be started in another folder.
            ca=str(ca.absolute()) if ca is not None and not pinned else "",
        )
    except KeyError as error:
        raise EnrolRefused("", f"{hub.url} gave no {error}; is it a Talaia hub?") from error


def _key_hash(hub: HubAddress, code: EnrolmentCode) -> str:
    """Give the hash of the key the hub shows, if it is the one that the code names."""
    shown = asyncio.run(HubTrust(hub).shown())
    try:
        found = hash_of_key(shown)
    except ValueError as error:
        raise HubUnreachable(f"{hub.url} shows a certificate that cannot be read") from error
    # Before the request: an impostor is never told the code.
    if not code.matches_key(found):
        raise HubUnreachable(
            f"{hub.url} shows another key than the code names, so it was not told the code; "
            "is the address that of the hub whose page shows the code? If the hub's certificate "
            "was changed since, make a new code; if not, somebody stands between"
        )
    return found


def _vouched_for(hub: HubAddress) -> bool:
    """Tell whether the system's authorities vouch for the hub, too."""
    parts = urlsplit(hub.url)
    # The system's trust and no pin: does the hub's certificate hold up by itself?
    connection = http.client.HTTPSConnection(
        parts.hostname or "", parts.port, timeout=_WAIT_S, context=ssl.create_default_context()
    )
    try:
        connection.connect()
    # Its certificate does not hold up by itself, or it is gone: the pin stays.
    except OSError:
        return False
    finally:
        connection.close()
    return True


def _request_key(
    hub: HubAddress, context: ssl.SSLContext | None, said: dict[str, str]
) -> EnrolmentAnswer:
    parts = urlsplit(hub.url)
    host = parts.hostname or ""
    connection = (
        http.client.HTTPConnection(host, parts.port, timeout=_WAIT_S)
        if context is None
        else http.client.HTTPSConnection(host, parts.port, timeout=_WAIT_S, context=context)
    )
    try:
        connection.request(
            "POST", "/api/enrol", json.dumps(said), {"Content-Type": "application/json"}
        )
        response = connection.getresponse()
        # Bounded: whatever answers there may not be a hub.
        text = response.read(_LONGEST)
    # Before `OSError`, of which it is a kind.
    except ssl.SSLCertVerificationError as error:
        raise HubUnreachable(
            f"{hub.url} cannot be trusted: {error.verify_message}; copy the whole code, "
            "or give the authority with --ca"
        ) from error
    except (OSError, http.client.HTTPException) as error:
        raise HubUnreachable(
            f"{hub.url} cannot be reached: {str(error) or type(error).__name__}; "
            "check the address, and that the hub runs"
        ) from error
    finally:
        connection.close()
    return EnrolmentAnswer(
        response.status, _read_body(text), response.headers.get("Retry-After", "")
    )


def _read_body(text: bytes) -> dict[str, str]:
    # Not JSON: some other server, or a proxy's page.
    try:
        found = json.loads(text)
    except ValueError:
        return {}
    if not isinstance(found, dict):
        return {}
    # Other values are left out: all that is asked for is text.
    return {key: value for key, value in found.items() if isinstance(value, str)}


def _refusal_words(hub: HubAddress, answer: EnrolmentAnswer) -> str:
    said = answer.body.get("message", "")
    if not said:
        return f"{hub.url} answers HTTP {answer.status}; is it a Talaia hub?"
    if answer.retry_s:
        said += f" ({answer.retry_s} s)"
    return said
