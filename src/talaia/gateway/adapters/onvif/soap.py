"""SOAP 1.2 as ONVIF speaks it: envelopes with a signature, answers, and faults. Pure.

After the ONVIF Core Specification, 5 and 5.9, and OASIS' Username Token Profile 1.1: the digest is
Base64(SHA-1(nonce + created + password)), and ``created`` is of the camera's own clock.
"""

from __future__ import annotations

import hashlib
from base64 import b64encode
from datetime import UTC, datetime
from typing import NamedTuple
from xml.sax.saxutils import escape

from talaia.gateway.adapters.onvif.xml_nodes import UnreadableXml, XmlNode, parse_xml
from talaia.gateway.errors import GatewayError

__all__ = [
    "NAMESPACES",
    "CameraFault",
    "Signature",
    "content_type_of",
    "envelope_of",
    "fault_in",
    "parse_answer",
    "shown_words",
]

# By the prefix that bodies are written with. ``ptz`` is of version 2, as all cameras speak it.
NAMESPACES = {
    "device": "http://www.onvif.org/ver10/device/wsdl",
    "media": "http://www.onvif.org/ver10/media/wsdl",
    "ptz": "http://www.onvif.org/ver20/ptz/wsdl",
    "tt": "http://www.onvif.org/ver10/schema",
}
_ENVELOPE = "http://www.w3.org/2003/05/soap-envelope"
_SECURITY = (
    "http://docs.oasis-open.org/wss/2004/01/oasis-200401-wss-wssecurity-secext-1.0.xsd",
    "http://docs.oasis-open.org/wss/2004/01/oasis-200401-wss-wssecurity-utility-1.0.xsd",
)
_DIGEST = (
    "http://docs.oasis-open.org/wss/2004/01/"
    "oasis-200401-wss-username-token-profile-1.0#PasswordDigest"
)
_BASE64 = (
    "http://docs.oasis-open.org/wss/2004/01/oasis-200401-wss-soap-message-security-1.0#Base64Binary"
)
_MOST_WORDS = 300


class CameraFault(GatewayError):
    """A camera answers that it does not do it.

    Attributes:
        code: the last part of its subcode, ``NoToken``; empty where it gives none.
        unauthorized: it does not take the signature, or the user has no right.

    """

    def __init__(self, code: str, words: str, *, unauthorized: bool = False) -> None:
        """Keep the code beside the sentence."""
        named = f" ({code})" if code else ""
        super().__init__(f"the camera refuses{named}{f': {words}' if words else ''}")
        self.code, self.unauthorized = code, unauthorized


class Signature(NamedTuple):
    """Who signs, with what and when by the camera's clock (s since the epoch)."""

    user: str
    password: str
    nonce: bytes
    at: float


def envelope_of(body: str, signature: Signature | None = None) -> bytes:
    """Write an envelope around a body, which is written with the prefixes of `NAMESPACES`."""
    prefixes = "".join(f' xmlns:{prefix}="{space}"' for prefix, space in NAMESPACES.items())
    header = "" if signature is None else f"<s:Header>{_security_of(signature)}</s:Header>"
    return (
        '<?xml version="1.0" encoding="UTF-8"?>'
        f'<s:Envelope xmlns:s="{_ENVELOPE}"{prefixes}>{header}<s:Body>{body}</s:Body></s:Envelope>'
    ).encode()


def content_type_of(service: str, action: str) -> str:
    """Name the content of a question: ``ptz`` and ``Stop`` make its action."""
    return f'application/soap+xml; charset=utf-8; action="{NAMESPACES[service]}/{action}"'


def _security_of(signature: Signature) -> str:
    created = datetime.fromtimestamp(signature.at, UTC).strftime("%Y-%m-%dT%H:%M:%SZ")
    digest = hashlib.sha1(
        signature.nonce + created.encode() + signature.password.encode(), usedforsecurity=False
    ).digest()
    secext, utility = _SECURITY
    return (
        f'<w:Security s:mustUnderstand="true" xmlns:w="{secext}" xmlns:u="{utility}">'
        f"<w:UsernameToken><w:Username>{escape(signature.user)}</w:Username>"
        f'<w:Password Type="{_DIGEST}">{b64encode(digest).decode()}</w:Password>'
        f'<w:Nonce EncodingType="{_BASE64}">{b64encode(signature.nonce).decode()}</w:Nonce>'
        f"<u:Created>{created}</u:Created></w:UsernameToken></w:Security>"
    )


def parse_answer(data: bytes, action: str) -> XmlNode:
    """Read an answer; give what is in its body: the ``<action>Response``.

    Raises:
        CameraFault: it is a fault.
        UnreadableXml: it is no answer to this.

    """
    if (fault := fault_in(data)) is not None:
        raise fault
    body = parse_xml(data).find_node("Body")
    answer = None if body is None else body.find_node(f"{action}Response")
    if answer is None:
        raise UnreadableXml(f"it is no answer to {action}")
    return answer


def fault_in(data: bytes) -> CameraFault | None:
    """Find the fault of an answer; none where it is another one.

    Raises:
        UnreadableXml: it is no envelope.

    """
    root = parse_xml(data)
    if root.name != "Envelope":
        raise UnreadableXml(f"expected an envelope of SOAP, found <{root.name[:40]}>")
    fault = root.find_node("Body", "Fault")
    if fault is None:
        return None
    codes = [node.text.rpartition(":")[2] for node in fault.walk_nodes() if node.name == "Value"]
    # SOAP 1.1, which a few cameras answer with in their faults.
    codes += [fault.text_at("faultcode").rpartition(":")[2]]
    named = [code for code in codes if code and code not in ("Sender", "Receiver", "Client")]
    words = fault.text_at("Reason", "Text") or fault.text_at("faultstring")
    unauthorized = any(code in ("NotAuthorized", "FailedAuthentication") for code in named)
    code = shown_words(named[-1] if named else "")[:60]
    return CameraFault(code, shown_words(words), unauthorized=unauthorized)


def shown_words(text: str) -> str:
    """Give a camera's words as one line that can be shown."""
    plain = "".join(letter if letter.isprintable() else " " for letter in text)
    return " ".join(plain.split())[:_MOST_WORDS]
