"""Envelopes, signatures and faults, by the examples of the specifications."""

from __future__ import annotations

import re
from base64 import b64decode
from datetime import UTC, datetime

import pytest

from talaia.gateway.adapters.onvif.soap import (
    CameraFault,
    Signature,
    content_type_of,
    envelope_of,
    fault_in,
    parse_answer,
)
from talaia.gateway.adapters.onvif.xml_nodes import UnreadableXml, parse_xml

pytestmark = pytest.mark.pure

BODY = (
    '<s:Envelope xmlns:s="http://www.w3.org/2003/05/soap-envelope"><s:Body>%s</s:Body></s:Envelope>'
)


def fault_of(inside: str) -> CameraFault:
    found = fault_in((BODY % f"<s:Fault>{inside}</s:Fault>").encode())
    assert found is not None
    return found


def test_a_signature_is_that_of_the_application_programmers_guide() -> None:
    # ONVIF Application Programmer's Guide 1.0, 6.1.1.3.
    nonce = b64decode("LKqI6G/AikKCQrN0zqZFlg==")
    at = datetime(2010, 9, 16, 7, 50, 45, tzinfo=UTC).timestamp()
    sent = envelope_of("<ptz:Stop/>", Signature("user", "userpassword", nonce, at))
    assert b"userpassword" not in sent
    header = parse_xml(sent).find_node("Header", "Security", "UsernameToken")
    assert header is not None
    assert header.text_at("Username") == "user"
    assert header.text_at("Created") == "2010-09-16T07:50:45Z"
    assert header.text_at("Password") == "tuOSpGlFlIXsozq4HFNeeGeFLEI="
    assert header.text_at("Nonce") == "LKqI6G/AikKCQrN0zqZFlg=="


def test_a_name_that_is_markup_stays_text() -> None:
    sent = envelope_of("", Signature('<a>&"', "p", b"n", 0.0))
    token = parse_xml(sent).find_node("Header", "Security", "UsernameToken")
    assert token is not None
    assert token.text_at("Username") == '<a>&"'


def test_the_content_names_the_action() -> None:
    assert re.search(
        'action="http://www.onvif.org/ver20/ptz/wsdl/Stop"', content_type_of("ptz", "Stop")
    )


def test_faults_of_both_versions_are_read() -> None:
    new = fault_of(
        "<s:Code><s:Value>s:Sender</s:Value><s:Subcode><s:Value>ter:InvalidArgVal</s:Value>"
        "<s:Subcode><s:Value>ter:NoToken</s:Value></s:Subcode></s:Subcode></s:Code>"
        "<s:Reason><s:Text>no such\n\x0bpreset</s:Text></s:Reason>".replace("\x0b", " ")
    )
    assert (new.code, str(new)) == ("NoToken", "the camera refuses (NoToken): no such preset")
    assert not new.unauthorized
    old = fault_of("<faultcode>s:Client</faultcode><faultstring>busy</faultstring>")
    assert str(old) == "the camera refuses: busy"
    for code in ("ter:NotAuthorized", "wsse:FailedAuthentication"):
        subcode = f"<s:Subcode><s:Value>{code}</s:Value></s:Subcode>"
        assert fault_of(f"<s:Code><s:Value>s:Sender</s:Value>{subcode}</s:Code>").unauthorized
    # Its words are a stranger's: cut, and on one line.
    assert len(str(fault_of(f"<faultstring>{'a' * 5000}</faultstring>"))) < 400


def test_an_answer_to_something_else_is_none() -> None:
    data = (BODY % "<x:StopResponse xmlns:x='urn:x'/>").encode()
    assert parse_answer(data, "Stop").name == "StopResponse"
    for wrong in (BODY % "", BODY % "<MoveResponse/>", "<html/>"):
        with pytest.raises(UnreadableXml):
            parse_answer(wrong.encode(), "Stop")
