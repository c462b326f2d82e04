"""XML of strangers: bounded, and without anything that expands or leads elsewhere."""

from __future__ import annotations

import contextlib

import pytest
from hypothesis import given, strategies as st

from talaia.gateway.adapters.onvif.xml_nodes import UnreadableXml, parse_xml

pytestmark = pytest.mark.pure

NINES = "".join(f'<!ENTITY x{n} "{f"&x{n - 1};" * 10}">' for n in range(1, 10))
HOSTILE = {
    "entities that grow": f'<!DOCTYPE e [<!ENTITY x0 "ha">{NINES}]><e>&x9;</e>',
    "a file": '<!DOCTYPE e [<!ENTITY f SYSTEM "file:///etc/passwd">]><e>&f;</e>',
    "a type elsewhere": '<!DOCTYPE e SYSTEM "http://192.0.2.1/e.dtd"><e/>',
    "a type in UTF-16": "<!DOCTYPE e><e/>",
    "an instruction": '<?xml-stylesheet href="http://192.0.2.1/"?><e/>',
    "too deep": "<e>" * 41 + "</e>" * 41,
    "too many": "<e>" + "<f/>" * 20_000 + "</e>",
    "attributes": "<e " + " ".join(f"a{n}=''" for n in range(65)) + "/>",
    "two roots": "<e/><e/>",
    "nothing": "",
    "a colour": "<e>&nbsp;</e>",
}


@pytest.mark.parametrize("name", HOSTILE)
def test_what_would_grow_lead_elsewhere_or_never_end_is_refused(name: str) -> None:
    coding = "utf-16" if "UTF-16" in name else "utf-8"
    with pytest.raises(UnreadableXml):
        parse_xml(HOSTILE[name].encode(coding))


def test_more_than_a_mebibyte_is_not_even_read() -> None:
    with pytest.raises(UnreadableXml, match="1048577 bytes"):
        parse_xml(b" " * 1_048_577)


def test_elements_are_told_by_their_own_names_whatever_the_prefix() -> None:
    root = parse_xml(
        b'<a:E xmlns:a="urn:a" xmlns="urn:b"><b:F t:token="7" xmlns:t="urn:t"> one </b:F><F/></a:E>'
    )
    assert root.name == "E"
    assert root.text_at("F") == "one"
    assert root.all_named("F")[0].attributes == {"token": "7"}
    assert (len(root.all_named("F")), root.find_node("F", "G"), root.text_at("H")) == (2, None, "")
    assert [node.name for node in root.walk_nodes()] == ["E", "F", "F"]


@given(st.binary(max_size=200) | st.text("<>/&; =\"'abxml!?-[]", max_size=200).map(str.encode))
def test_any_bytes_are_read_or_refused(data: bytes) -> None:
    with contextlib.suppress(UnreadableXml):
        parse_xml(data)
