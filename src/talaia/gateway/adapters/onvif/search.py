"""Finds ONVIF cameras in the network by WS-Discovery, a multicast over UDP. Blocks.

Everybody in the network may answer, with anything. So an answer counts only for the question that
was asked, its addresses only where they are the sender's own, and all of it has an end. Nobody is
signed in at here: a password goes to an address that a person has named, and to no other.
"""

from __future__ import annotations

import contextlib
import ipaddress
import socket
import time
import uuid
from typing import TYPE_CHECKING, NamedTuple
from urllib.parse import unquote, urlsplit

from talaia.gateway.adapters.onvif.soap import shown_words
from talaia.gateway.adapters.onvif.xml_nodes import UnreadableXml, parse_xml
from talaia.model.camera_addresses import why_no_camera

if TYPE_CHECKING:
    from talaia.gateway.adapters.onvif.xml_nodes import XmlNode

__all__ = ["DISCOVERY_PORT", "FoundCamera", "parse_matches", "probe_message", "search_cameras"]

# WS-Discovery 1.0 (April 2005), 2.4, with which ONVIF's Core Specification goes (7.3).
DISCOVERY_PORT = 3702
GROUP = "239.255.255.250"
# The network of the machine's first way out, and programs on the machine itself.
_INTERFACES = ("0.0.0.0", "127.0.0.1")  # noqa: S104 - an interface to send by, and none to listen at
# Asked twice, for a datagram may be lost (s).
_AGAIN_S = 0.3
_MOST_CAMERAS = 200
_MOST_ANSWERS = 2000
_MOST_ADDRESSES = 16
_LONGEST = 65_535
_SCOPE = "onvif://www.onvif.org/"


class FoundCamera(NamedTuple):
    """A camera that has answered.

    Attributes:
        url: of its device service.
        name: what it calls itself; empty where it does not.
        hardware: which model it says that it is.

    """

    url: str
    name: str
    hardware: str


def probe_message(message_id: str) -> bytes:
    """Write the question for network video transmitters."""
    return (
        '<?xml version="1.0" encoding="UTF-8"?>'
        '<s:Envelope xmlns:s="http://www.w3.org/2003/05/soap-envelope"'
        ' xmlns:a="http://schemas.xmlsoap.org/ws/2004/08/addressing"'
        ' xmlns:d="http://schemas.xmlsoap.org/ws/2005/04/discovery"'
        ' xmlns:dn="http://www.onvif.org/ver10/network/wsdl"><s:Header>'
        "<a:Action>http://schemas.xmlsoap.org/ws/2005/04/discovery/Probe</a:Action>"
        f"<a:MessageID>{message_id}</a:MessageID>"
        "<a:To>urn:schemas-xmlsoap-org:ws:2005:04:discovery</a:To></s:Header>"
        "<s:Body><d:Probe><d:Types>dn:NetworkVideoTransmitter</d:Types></d:Probe></s:Body>"
        "</s:Envelope>"
    ).encode()


def parse_matches(data: bytes, sender: str, message_id: str) -> list[FoundCamera]:
    """Read an answer; give the cameras in it, none where it is no answer to this question.

    Args:
        data: a datagram.
        sender: the IP address that it came from.
        message_id: of the question.

    """
    try:
        root = parse_xml(data)
    except UnreadableXml:
        return []
    # Some cameras leave the list around their match out.
    matches = root.find_node("Body", "ProbeMatches") or root.find_node("Body")
    if matches is None or root.text_at("Header", "RelatesTo") != message_id:
        return []
    found = []
    for match in matches.all_named("ProbeMatch")[:_MOST_ADDRESSES]:
        url = _own_address(match.text_at("XAddrs"), sender)
        if url:
            scopes = _scopes_of(match)
            found.append(FoundCamera(url, scopes.get("name", ""), scopes.get("hardware", "")))
    return found


def _own_address(addresses: str, sender: str) -> str:
    """Choose the address that is the sender's own; empty where all lead elsewhere."""
    for address in addresses.split()[:_MOST_ADDRESSES]:
        try:
            parts = urlsplit(address)
            own = ipaddress.ip_address(parts.hostname or "") == ipaddress.ip_address(sender)
            # To read ``port`` raises `ValueError` where that is no number of a port.
            fits = parts.port != 0 and not (parts.username or parts.query or parts.fragment)
        except ValueError:
            continue
        plain = address.isascii() and address.isprintable() and len(address) <= 300
        if own and fits and plain and parts.scheme in ("http", "https"):
            return address
    return ""


def _scopes_of(match: XmlNode) -> dict[str, str]:
    found: dict[str, str] = {}
    for scope in match.text_at("Scopes").split()[:100]:
        if scope.startswith(_SCOPE):
            key, _, value = scope.removeprefix(_SCOPE).partition("/")
            found.setdefault(key, shown_words(unquote(value))[:60])
    return found


def search_cameras(
    seconds: float, *, group: str = GROUP, port: int = DISCOVERY_PORT
) -> list[FoundCamera]:
    """Ask who is there.

    Args:
        seconds: how long to wait for answers (s).
        group: the multicast address of the question.
        port: its port.

    Raises:
        OSError: nothing can be sent.

    """
    message_id = f"urn:uuid:{uuid.uuid4()}"
    question = probe_message(message_id)
    found: dict[str, FoundCamera] = {}
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as line:
        line.bind(("", 0))
        began, again, answers = time.monotonic(), True, 0
        _send_question(line, question, (group, port))
        while len(found) < _MOST_CAMERAS and answers < _MOST_ANSWERS:
            passed = time.monotonic() - began
            if passed >= seconds:
                break
            if again and passed >= _AGAIN_S:
                again = False
                _send_question(line, question, (group, port))
            line.settimeout(min(_AGAIN_S, seconds - passed))
            with contextlib.suppress(TimeoutError):
                data, (sender, _) = line.recvfrom(_LONGEST)
                answers += 1
                # On this computer only a program of its own can answer from there.
                if not why_no_camera(sender, here=True):
                    for camera in parse_matches(data, sender, message_id):
                        found.setdefault(camera.url, camera)
    return list(found.values())


def _send_question(line: socket.socket, question: bytes, where: tuple[str, int]) -> None:
    sent = 0
    for interface in _INTERFACES:
        try:
            line.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_IF, socket.inet_aton(interface))
            line.sendto(question, where)
        except OSError:
            # A machine without a network has the other one yet.
            continue
        sent += 1
    if not sent:
        raise OSError("no network takes a multicast")
