"""Lists of other programs, read: what they hold, what is wrong where, and whatever bytes come."""

from __future__ import annotations

import json
from zoneinfo import ZoneInfo

import msgspec
import pytest
from hypothesis import given, strategies as st

from talaia.hub.request_files.imported import (
    ImportDefaults,
    Misread,
    read_declination,
    read_right_ascension,
)
from talaia.hub.request_files.readers import FileKind, read_request_file
from talaia.model.observing.requests import (
    Configuration,
    GroupOperator,
    Guiding,
    ImageType,
    RequestGroup,
    Urgency,
    Window,
)

DEFAULTS = ImportDefaults("P1", Window(start=1_800_000_000.0, end=1_800_100_000.0))

# As the documentation of LCO's portal has it (developers.lco.global).
LCO = {
    "name": "Example Request 1",
    "proposal": "LCO2026-001",
    "ipp_value": 1.05,
    "operator": "SINGLE",
    "observation_type": "NORMAL",
    "requests": [
        {
            "configurations": [
                {
                    "type": "EXPOSE",
                    "instrument_type": "1M0-SCICAM-SINISTRO",
                    "target": {
                        "name": "m83", "type": "ICRS", "ra": 204.253, "dec": -29.865,
                        "epoch": 2000,
                    },
                    "constraints": {"max_airmass": 1.6, "min_lunar_distance": 30},
                    "acquisition_config": {},
                    "guiding_config": {},
                    "instrument_configs": [
                        {
                            "exposure_time": 30, "exposure_count": 10,
                            "optical_elements": {"filter": "v"},
                        }
                    ],
                }
            ],
            "windows": [{"start": "2027-01-30 00:00:00", "end": "2027-02-02 00:00:00"}],
            "location": {"telescope_class": "1m0"},
        }
    ],
}  # fmt: skip

CSV = """name;RA;dec;filter;exposure;count;min_altitude
M 42;05:35:17.3;-05:23:28;R;30;10;25
M 31;10.6847;+41.269;;;;
M 45;25:00:00;24;;;;
NGC 1;0;95;;;;
;;12;;;;
M 1;83.6;22;B;thirty;;
"""

NINA = {
    "$id": "1",
    "$type": "NINA.Sequencer.Container.SequenceRootContainer, NINA.Sequencer",
    "Name": "Tonight",
    "Items": {
        "$values": [
            {
                "$type": "NINA.Sequencer.Container.DeepSkyObjectContainer, NINA.Sequencer",
                "Target": {
                    "TargetName": "M 42",
                    "InputCoordinates": {
                        "RAHours": 5, "RAMinutes": 35, "RASeconds": 17.3, "NegativeDec": True,
                        "DecDegrees": 0, "DecMinutes": 23, "DecSeconds": 28.0,
                    },
                },
                "Items": {
                    "$values": [
                        {"$type": "NINA.Sequencer.SequenceItem.Camera.CoolCamera, NINA.Sequencer"},
                        {
                            "$type": "NINA.Sequencer.SequenceItem.Imaging.SmartExposure, N",
                            "Conditions": {
                                "$values": [
                                    {
                                        "$type": "NINA.Sequencer.Conditions.LoopCondition, N",
                                        "Iterations": 20,
                                    }
                                ]
                            },
                            "Items": {
                                "$values": [
                                    {
                                        "$type": "NINA.Sequencer.SequenceItem.FilterWheel."
                                        "SwitchFilter, NINA.Sequencer",
                                        "Filter": {"_name": "L"},
                                    },
                                    {
                                        "$type": "NINA.Sequencer.SequenceItem.Imaging."
                                        "TakeExposure, NINA.Sequencer",
                                        "ExposureTime": 300.0, "Gain": 100,
                                        "Binning": {"X": 2, "Y": 2}, "ImageType": "LIGHT",
                                    },
                                ]
                            },
                        },
                    ]
                },
            }
        ]
    },
}  # fmt: skip

EKOS = """<?xml version="1.0" encoding="UTF-8"?>
<SchedulerList version='1.4'>
<Profile>Default</Profile>
<Job>
<Name>M 31</Name>
<Priority>10</Priority>
<Coordinates>
<J2000RA>0.712314</J2000RA>
<J2000DE>41.26875</J2000DE>
</Coordinates>
<Sequence>/sequences/one.esq</Sequence>
<StartupCondition><Condition>ASAP</Condition></StartupCondition>
<Constraints>
<Constraint value='30'>MinimumAltitude</Constraint>
<Constraint value='40'>MoonSeparation</Constraint>
<Constraint>EnforceTwilight</Constraint>
</Constraints>
<Steps><Step>Track</Step></Steps>
</Job>
<Job>
<Name>Nowhere</Name>
</Job>
</SchedulerList>
"""


def read(kind: str, said: object):
    text = said if isinstance(said, str) else json.dumps(said)
    return read_request_file(FileKind(kind), text, DEFAULTS)


def test_a_group_as_las_cumbres_documents_it_is_read_whole() -> None:
    (group,), problems = read("lco", LCO)
    assert problems == []
    (request,) = group.requests
    assert (group.name, group.operator, group.urgency) == (
        "Example Request 1", GroupOperator.SINGLE, Urgency.NORMAL,
    )  # fmt: skip
    assert (group.priority, group.proposal) == (10.5, "P1")
    assert (request.target.name, request.target.ra, request.target.dec) == ("m83", 204.253, -29.865)
    assert request.configurations == (Configuration(filter="v", exposure=30.0, count=10),)
    assert (request.constraints.max_airmass, request.constraints.min_moon_distance) == (1.6, 30.0)
    # 2027-01-30T00:00:00Z, three days.
    assert request.windows == (Window(start=1_801_267_200.0, end=1_801_526_400.0),)


def changed(where: list[object], value: object) -> dict[str, object]:
    said = json.loads(json.dumps(LCO))
    inside = said
    for step in where[:-1]:
        inside = inside[step]
    inside[where[-1]] = value
    return said


CONFIGURATION = ["requests", 0, "configurations", 0]


@pytest.mark.parametrize(
    ("where", "value", "path", "said"),
    [
        ([*CONFIGURATION, "target", "ra"], "m83", "configurations[0].target.ra", "a number"),
        ([*CONFIGURATION, "target", "dec"], -95, "requests[0]", ">= -90"),
        ([*CONFIGURATION, "target", "type"], "ORBITAL_ELEMENTS", "target.type", "expected ICRS"),
        ([*CONFIGURATION, "type"], "REPEAT_EXPOSE", "configurations[0].type", "expected EXPOSE"),
        ([*CONFIGURATION, "instrument_configs"], [], "instrument_configs", "an empty list"),
        (["requests", 0, "windows", 0, "end"], "2020-01-01", "windows[0]", "before it begins"),
        (["requests", 0, "windows", 0, "end"], "soon", "windows[0].end", "found 'soon'"),
        (["requests"], None, "$.requests", "found nothing"),
        (["operator"], "ALL", "$.operator", "expected SINGLE or MANY"),
        (["observation_type"], "DIRECT", "$.observation_type", "expected NORMAL"),
    ],
)
def test_what_is_wrong_in_a_group_is_said_with_its_path(where, value, path, said) -> None:
    groups, (problem,) = read("lco", changed(where, value))
    assert groups == []
    assert problem.where.endswith(path)
    assert said in problem.message


def test_a_cadence_becomes_its_visits_and_guiding_is_kept() -> None:
    said = changed(
        ["requests", 0, "cadence"],
        {"start": "2027-01-30 00:00:00", "end": "2027-02-02 00:00:00", "period": 24, "jitter": 6},
    )
    said["requests"][0]["configurations"][0]["guiding_config"] = {"mode": "ON", "optional": False}
    (group,), problems = read("lco", {"count": 1, "results": [said]})
    assert problems == []
    assert (group.operator, len(group.requests)) == (GroupOperator.MANY, 4)
    lengths = [one.windows[0].end - one.windows[0].start for one in group.requests]
    assert lengths == [3 * 3600.0] + [6 * 3600.0] * 3
    assert group.requests[0].configurations[0].guiding is Guiding.ON


def test_each_line_of_a_spreadsheet_is_read_or_said_to_be_wrong() -> None:
    (group,), problems = read("csv", CSV)
    orion, andromeda = group.requests
    assert orion.target.ra == pytest.approx(83.822, abs=0.001)
    assert orion.target.dec == pytest.approx(-5.391, abs=0.001)
    assert orion.configurations == (Configuration(filter="R", exposure=30.0, count=10),)
    assert orion.constraints.min_altitude == 25.0
    assert (andromeda.target.ra, andromeda.configurations) == (10.6847, DEFAULTS.configurations)
    assert [problem.where for problem in problems] == [
        "line 4, ra", "line 5, dec", "line 6", "line 7, exposure",
    ]  # fmt: skip
    groups, (problem,) = read("csv", "name,ra,decl\nM 1,1,2\n")
    assert (groups, problem.where) == ([], "line 1")
    assert "no column 'decl'; expected name, ra, dec" in problem.message


def test_a_sequence_of_nina_has_its_target_filters_and_loops() -> None:
    (group,), problems = read("nina", NINA)
    assert problems == []
    (request,) = group.requests
    assert request.target.ra == pytest.approx(83.822, abs=0.001)
    # The sign stands beside degrees that are 0.
    assert request.target.dec == pytest.approx(-0.391, abs=0.001)
    assert request.configurations == (
        Configuration(
            type=ImageType.LIGHT, filter="L", exposure=300.0, count=20, binning=2, gain=100.0
        ),
    )
    assert "no target" in read("nina", {"Name": "empty"}).problems[0].message


def test_a_list_of_ekos_has_targets_and_constraints_and_says_what_has_none() -> None:
    (group,), (problem,) = read("ekos", EKOS)
    (request,) = group.requests
    assert (request.target.name, request.target.dec) == ("M 31", 41.26875)
    assert request.target.ra == pytest.approx(10.6847, abs=0.0001)
    assert (request.constraints.min_altitude, request.constraints.min_moon_distance) == (30, 40)
    assert problem.where == "line 20, J2000RA"


def test_entities_and_other_documents_are_refused() -> None:
    bomb = '<!DOCTYPE x [<!ENTITY a "b">]><SchedulerList><Job>&a;</Job></SchedulerList>'
    assert "document type" in read("ekos", bomb).problems[0].message
    assert "expected <SchedulerList>" in read("ekos", "<html></html>").problems[0].message
    assert "no XML" in read("ekos", "").problems[0].message


@pytest.mark.parametrize(
    ("text", "degrees"),
    [("05:35:17.3", 83.8221), ("5h35m17.3s", 83.8221), ("83.5", 83.5), ("23 59 59", 359.9958)],
)
def test_right_ascension_is_hours_where_it_has_colons_and_degrees_else(text, degrees) -> None:
    assert read_right_ascension("here", text) == pytest.approx(degrees, abs=1e-3)


def test_a_declination_of_minus_nothing_keeps_its_sign() -> None:
    assert read_declination("here", "-00:30:00") == -0.5
    for wrong in ("12:61", "nan", "1e400", "", "-91", "٣"):
        with pytest.raises(Misread, match="here"):
            read_declination("here", wrong)


def follows_its_bounds(group: RequestGroup) -> None:
    assert msgspec.convert(msgspec.to_builtins(group), RequestGroup) == group


JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=8),
    lambda inside: st.lists(inside, max_size=3) | st.dictionaries(st.text(max_size=8), inside),
    max_leaves=8,
)
KEYS = [
    ["requests"], ["requests", 0], CONFIGURATION, [*CONFIGURATION, "target"], ["ipp_value"],
    [*CONFIGURATION, "target", "ra"], [*CONFIGURATION, "constraints"], ["name"],
    [*CONFIGURATION, "instrument_configs", 0], [*CONFIGURATION, "guiding_config"],
    [*CONFIGURATION, "instrument_configs", 0, "exposure_count"],
    ["requests", 0, "windows"], ["requests", 0, "windows", 0, "start"], ["requests", 0, "cadence"],
]  # fmt: skip


@given(st.sampled_from(KEYS), JSON)
def test_whatever_stands_in_a_group_it_is_read_or_a_problem(where, value) -> None:
    found = read("lco", changed(where, value))
    assert found.groups or found.problems
    for group in found.groups:
        follows_its_bounds(group)


@given(st.sampled_from(FileKind), st.text(max_size=200))
def test_whatever_text_comes_it_is_read_or_a_problem(kind, text) -> None:
    found = read_request_file(kind, text, DEFAULTS)
    assert found.groups or found.problems or text.strip() == "[]"


def nina_with(target: dict[str, float], *kinds: str) -> dict[str, object]:
    said = json.loads(json.dumps(NINA))
    (container,) = said["Items"]["$values"]
    container["Target"] |= target
    container["Items"]["$values"] += [{"$type": f"NINA.Platesolving.{kind}, N"} for kind in kinds]
    return said


def lco_with(**setting: object) -> dict[str, object]:
    return changed([*CONFIGURATION, "instrument_configs"], [{"exposure_time": 30, **setting}])


EKOS_ALIGNED = EKOS.replace("<Step>Track</Step>", "<Step>Align</Step>").replace(
    "</Coordinates>", "</Coordinates><PositionAngle>-30</PositionAngle>"
)


@pytest.mark.parametrize(
    ("kind", "said", "angle"),
    [
        ("lco", lco_with(rotator_mode="SKY", extra_params={"rotator_angle": 90}), 90.0),
        ("lco", lco_with(rotator_mode="SKY"), None),
        ("csv", "ra,dec,position_angle\n1,2,-10\n", 350.0),
        ("csv", "ra,dec,position_angle\n1,2,\n", None),
        ("nina", nina_with({"PositionAngle": 137.5}, "CenterAndRotate"), 137.5),
        # What framing showed is no wish to turn the camera.
        ("nina", nina_with({"PositionAngle": 137.5}, "Center"), None),
        ("nina", nina_with({"Rotation": 30.0}, "CenterAndRotate"), 330.0),
        ("ekos", EKOS_ALIGNED, 330.0),
        ("ekos", EKOS_ALIGNED.replace("-30", "-181"), None),
        ("ekos", EKOS_ALIGNED.replace("Align", "Track"), None),
    ],
)
def test_the_angle_that_a_list_turns_the_camera_to_is_kept(kind, said, angle) -> None:
    target = read(kind, said).groups[0].requests[0].target
    assert target.position_angle == (None if angle is None else pytest.approx(angle))


@pytest.mark.parametrize(
    ("kind", "said", "where"),
    [
        ("lco", lco_with(rotator_mode="VFLOAT"), "rotator_mode"),
        ("lco", lco_with(rotator_mode="SKY", extra_params={"rotator_angle": "N"}), "rotator_angle"),
        ("csv", "ra,dec,position_angle\n1,2,400\n", "line 2, position_angle"),
    ],
)
def test_an_angle_that_is_none_on_the_sky_is_said_with_its_place(kind, said, where) -> None:
    groups, (problem,) = read(kind, said)
    assert groups == []
    assert problem.where.endswith(where)


CELL = st.sampled_from(["", "1", "-5:30", "1e9", "nan", "=1", '"', "R", "2026-12-04", "x" * 300])


@given(st.lists(st.lists(CELL, min_size=11, max_size=12), max_size=4))
def test_whatever_cells_a_spreadsheet_has_its_requests_are_in_their_bounds(rows) -> None:
    head = "name,ra,dec,filter,exposure,count,binning,min_altitude,min_moon_distance,start,end"
    text = "\n".join([head, *(",".join(row) for row in rows)])
    found = read("csv", text)
    for group in found.groups:
        follows_its_bounds(group)
    assert found.groups or found.problems


def nina_exposure(**said: object) -> dict[str, object]:
    kind = "NINA.Sequencer.SequenceItem.Imaging.TakeExposure, NINA.Sequencer"
    return {"$type": kind, "ExposureTime": 60.0, "ImageType": "LIGHT", **said}


def test_a_filter_that_nina_wrote_once_and_refers_to_later_is_known_each_time() -> None:
    switch = "NINA.Sequencer.SequenceItem.FilterWheel.SwitchFilter, NINA.Sequencer"
    items = [
        {"$type": switch, "Filter": {"$id": "57", "_name": "Ha", "_position": 3}},
        nina_exposure(Binning={"$id": "58", "X": 2, "Y": 2}),
        {"$type": switch, "Filter": {"$id": "60", "_name": "L", "Self": {"$ref": "60"}}},
        nina_exposure(ImageType="SNAPSHOT", Binning={"$ref": "58"}),
        {"$type": switch, "Filter": {"$ref": "57"}},
        nina_exposure(ImageType="DARKFLAT"),
        {"$type": switch, "Filter": {"$ref": "none"}},
        nina_exposure(),
    ]
    loop = {"$type": "NINA.Sequencer.Conditions.LoopCondition, NINA.Sequencer", "Iterations": 3}
    said = json.loads(json.dumps(NINA))
    (container,) = said["Items"]["$values"]
    # Other programs write plain lists; a target's own loop counts, too.
    container |= {"Items": items, "Conditions": [loop]}
    (group,), problems = read("nina", said)
    assert problems == []
    found = [
        (one.filter, one.binning, one.count, one.type) for one in group.requests[0].configurations
    ]
    assert found == [
        ("Ha", 2, 3, ImageType.LIGHT),
        ("L", 2, 3, ImageType.LIGHT),
        ("Ha", 1, 3, ImageType.DARK),
        ("", 1, 3, ImageType.LIGHT),
    ]


def test_ekos_times_are_those_of_the_site_and_also_end_a_window() -> None:
    text = EKOS.replace(
        "<Condition>ASAP</Condition>", "<Condition value='2027-01-15T22:00:00'>At</Condition>", 1
    ).replace(
        "</StartupCondition>",
        "</StartupCondition><CompletionCondition>"
        "<Condition value='2027-01-15T23:30:00'>At</Condition></CompletionCondition>",
        1,
    )
    window = Window(start=1_800_000_000.0, end=1_800_100_000.0)
    madrid = ImportDefaults("P1", window, zone=ZoneInfo("Europe/Madrid"))
    (group,), _ = read_request_file("ekos", text, madrid)
    # 21:00 and 22:30 in UTC.
    assert group.requests[0].windows == (Window(start=1_800_046_800.0, end=1_800_052_200.0),)
    early = text.replace("2027-01-15T23:30:00", "2026-01-15T23:30:00")
    _, problems = read_request_file("ekos", early, madrid)
    assert "before the window's begin" in problems[0].message
