"""Notices of GCN and VOEvent as values, and filters that say why."""

from __future__ import annotations

import contextlib
import json

import pytest
from hypothesis import given, strategies as st

from talaia.wire.alerts.filters import AlertFilter, preview_filter
from talaia.wire.alerts.gcn_json import parse_gcn_json
from talaia.wire.alerts.notice import AlertNotice
from talaia.wire.alerts.read_notice import parse_notice
from talaia.wire.alerts.voevent import parse_voevent
from talaia.wire.errors import PeerError

# Shortened from the form of GCN's notices of Swift's BAT.
VOEVENT = b"""<?xml version='1.0' encoding='UTF-8'?>
<voe:VOEvent ivorn='ivo://nasa.gsfc.gcn/SWIFT#BAT_GRB_Pos_1000-1' role='observation' version='2.0'
 xmlns:voe='http://www.ivoa.net/xml/VOEvent/v2.0'>
 <What><Param name='TrigID' value='1000' ucd='meta.id'/>
  <Group name='Solution_Status'><Param name='Point_Source' value='true'/></Group>
  <Param name='Rate_Signif' value='9.5'/></What>
 <WhereWhen><ObsDataLocation><ObservationLocation>
  <AstroCoordSystem id='UTC-FK5-GEO'/>
  <AstroCoords coord_system_id='UTC-FK5-GEO'>
   <Time unit='s'><TimeInstant><ISOTime>2026-11-23T01:02:03.4</ISOTime></TimeInstant></Time>
   <Position2D unit='deg'><Name1>RA</Name1><Name2>Dec</Name2>
    <Value2><C1>123.5</C1><C2>-22.25</C2></Value2><Error2Radius>0.05</Error2Radius></Position2D>
  </AstroCoords></ObservationLocation></ObsDataLocation></WhereWhen>
</voe:VOEvent>"""


def test_a_voevent_says_what_where_and_when() -> None:
    notice = parse_voevent(VOEVENT)
    assert (notice.ra, notice.dec, notice.error_radius) == (123.5, -22.25, 0.05)
    assert (notice.event, notice.source) == ("TrigID 1000", "nasa.gsfc.gcn/SWIFT")
    assert notice.parameters["Solution_Status/Point_Source"] == "true"
    assert notice.time == "2026-11-23T01:02:03.4"


@pytest.mark.parametrize(
    ("old", "new", "why"),
    [
        (b"<voe:VOEvent", b"<!DOCTYPE x [<!ENTITY a 'b'>]><voe:VOEvent", "no entities"),
        (b"123.5", b"423.5", "not in the sky"),
        (b"UTC-FK5-GEO'>", b"UTC-GAL-GEO'>", "are not read"),
        (b"role='observation'", b"role='party'", "role"),
        (b"unit='deg'", b"unit='rad'", "degrees"),
        (b"</voe:VOEvent>", b"", "no XML"),
    ],
)
def test_what_cannot_be_meant_is_refused_with_the_reason(old: bytes, new: bytes, why: str) -> None:
    with pytest.raises(PeerError, match=why):
        parse_voevent(VOEVENT.replace(old, new))


@pytest.mark.parametrize("encoding", ["utf-16", "utf-16-be"])
def test_entities_are_refused_however_the_notice_is_encoded(encoding: str) -> None:
    declared = VOEVENT.replace(b"<voe:VOEvent", b"<!DOCTYPE x [<!ENTITY a 'b'>]><voe:VOEvent")
    # Its declaration says another encoding: without one the first bytes count.
    text = "\ufeff" * (encoding != "utf-16") + declared.decode().partition("?>")[2].lstrip()
    with pytest.raises(PeerError, match="no entities"):
        parse_voevent(text.encode(encoding))


def test_a_notice_of_gcn_in_json_says_the_same() -> None:
    said = {
        "$schema": "https://gcn.nasa.gov/schema/v4.1.0/gcn/notices/einstein_probe/wxt/alert.schema.json",
        "instrument": "WXT",
        "id": ["01708973486"],
        "trigger_time": "2026-11-23T01:02:03Z",
        "ra": 120.0,
        "dec": 40.0,
        "ra_dec_error": 0.02,
        "image_snr": 5.0,
    }
    notice = parse_gcn_json(json.dumps(said).encode())
    assert (notice.ra, notice.dec, notice.event) == (120.0, 40.0, "01708973486")
    assert notice.parameters["image_snr"] == "5.0"
    with pytest.raises(PeerError, match="both ra and dec"):
        parse_gcn_json(json.dumps({**said, "dec": None}).encode())


@given(st.binary(max_size=300))
def test_any_bytes_are_a_notice_or_a_problem(data: bytes) -> None:
    for parse in (parse_voevent, parse_gcn_json):
        with contextlib.suppress(PeerError):
            parse(data)
        with contextlib.suppress(PeerError):
            parse(VOEVENT[: len(data) * 4] + data)


def test_a_preview_says_of_each_notice_once_why_it_does_not_pass() -> None:
    good = parse_voevent(VOEVENT)
    test = parse_voevent(VOEVENT.replace(b"observation'", b"test'").replace(b"1000-1", b"2"))
    nowhere = AlertNotice(id="3", source="nasa.gsfc.gcn/SWIFT")
    chosen = AlertFilter(
        sources=("*SWIFT",), largest_error=0.1, least={"Rate_Signif": 7.0}, declinations=(-30, 90)
    )
    verdicts = preview_filter(chosen, [good, good, test, nowhere])
    assert [verdict.refusal for verdict in verdicts] == [
        "",
        "its role is test, not observation",
        "it names no place",
    ]


@pytest.mark.parametrize(
    ("chosen", "why"),
    [
        (AlertFilter(sources=("*FERMI",)), "it comes from"),
        (AlertFilter(largest_error=0.01), "known to 0.05"),
        (AlertFilter(declinations=(0.0, 90.0)), "declination"),
        (AlertFilter(least={"Rate_Signif": 10.0}), "at least 10"),
        (AlertFilter(most={"Rate_Signif": 9.0}), "at most 9"),
        (AlertFilter(least={"Nothing": 1.0}), "no number"),
        (AlertFilter(equal={"TrigID": ("2*",)}), "not 2"),
    ],
)
def test_each_condition_of_a_filter_refuses(chosen: AlertFilter, why: str) -> None:
    assert why in chosen.refusal(parse_voevent(VOEVENT))


def test_notice_that_is_no_text_is_refused() -> None:
    with pytest.raises(PeerError, match="no notice of GCN"):
        parse_notice(b'{"$schema":"x","alert_type\xf0":1}')
