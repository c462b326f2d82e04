"""Commands judged by the goal: what real drivers answered, and what a verdict must not be."""

# ruff: noqa: E501, UP031 - words of INDI as it sends them
from pathlib import Path

import pytest

from talaia.clock import SECOND
from talaia.gateway.adapters.indi.description.labels import word_of
from talaia.gateway.adapters.indi.discovery import devices_of
from talaia.gateway.adapters.indi.goals import IndiGoal, begin_goal
from talaia.gateway.adapters.indi.protocol import BlobEnd, BlobHead, BlobPart, IndiParser
from talaia.gateway.adapters.indi.standard_properties import read_number, read_state, read_text
from talaia.gateway.adapters.indi.state import IndiDeviceTree
from talaia.gateway.ports import CommandOutcome
from talaia.model.checks.site_checks import check_site
from talaia.model.site import Site
from talaia.model.yaml_text.load import dump_site, load_site
from talaia.wire.frames import CommandPhase

RECORDED = Path(__file__).parent / "recorded"
DOME, MOUNT, CAMERA = "Dome Simulator", "Telescope Simulator", "CCD Simulator"


class Server:
    """A book that a test fills, and its clock."""

    def __init__(self) -> None:  # noqa: D107
        self.book, self.reader, self.now_ns = IndiDeviceTree(), IndiParser(), 0
        self.says((RECORDED / "simulators.xml").read_bytes())
        self.passes(1)

    def says(self, data: bytes | str) -> None:
        for event in self.reader.parse_data(data.encode() if isinstance(data, str) else data):
            if not isinstance(event, BlobHead | BlobPart | BlobEnd):
                self.book.apply_event(event, self.now_ns)

    def sets(self, device: str, name: str, state: str, kind: str = "Switch", **values: str) -> None:
        members = "".join(f'<one{kind} name="{k}">{v}</one{kind}>' for k, v in values.items())
        self.says(
            f'<set{kind}Vector device="{device}" name="{name}" state="{state}">{members}'
            f"</set{kind}Vector>"
        )

    def passes(self, seconds: float) -> None:
        self.now_ns += round(seconds * SECOND)
        for device in self.book:
            device.heard_ns = self.now_ns

    def begin(self, device: str, target: str, **fields: object) -> IndiGoal:
        goal = begin_goal(
            book=self.book, device=device, target=target, fields=fields, now_ns=self.now_ns
        )
        assert isinstance(goal, IndiGoal), goal
        return goal

    def looks(self, goal: IndiGoal) -> CommandOutcome | None:
        return goal.evaluate_progress(self.book, self.now_ns)


@pytest.fixture
def server() -> Server:
    return Server()


def test_repeated_word_of_an_old_state_is_no_answer(server: Server) -> None:
    goal = server.begin(DOME, "DOME_SHUTTER", SHUTTER_OPEN=True)
    assert server.looks(goal) is None
    first, _, rest = (RECORDED / "dome-open.xml").read_text().partition("</setSwitchVector>")
    server.says(f"{first}</setSwitchVector>")
    outcome = server.looks(goal)
    assert outcome is not None
    assert (outcome.phase, outcome.message) == (CommandPhase.RUNNING, "Shutter is opening...")
    server.says(rest)
    assert server.looks(goal) == CommandOutcome(CommandPhase.SUCCEEDED, "Shutter is open.")


def test_parked_dome_is_not_done_while_its_shutter_moves(server: Server) -> None:
    goal = server.begin(DOME, "DOME_PARK", PARK=True)
    server.sets(DOME, "DOME_SHUTTER", "Busy", SHUTTER_CLOSE="On", SHUTTER_OPEN="Off")
    server.sets(DOME, "DOME_PARK", "Ok", PARK="On", UNPARK="Off")
    assert server.looks(goal).phase is CommandPhase.RUNNING
    server.sets(DOME, "DOME_SHUTTER", "Ok", SHUTTER_CLOSE="On", SHUTTER_OPEN="Off")
    assert server.looks(goal).phase is CommandPhase.SUCCEEDED


def test_aborted_motion_succeeds_though_its_driver_calls_it_an_alert(server: Server) -> None:
    server.sets(DOME, "DOME_SHUTTER", "Busy", SHUTTER_OPEN="On", SHUTTER_CLOSE="Off")
    opening = server.begin(DOME, "DOME_SHUTTER", SHUTTER_OPEN=True)
    goal = server.begin(DOME, "DOME_ABORT_MOTION", ABORT=True)
    server.says((RECORDED / "dome-open-abort.xml").read_bytes())
    assert server.looks(goal).phase is CommandPhase.SUCCEEDED
    ended = server.looks(opening)
    assert ended.phase is CommandPhase.FAILED
    assert "aborted" in ended.message
    states = ("closed", "opening", "open", "closing", "error", "unknown")
    reading = read_state(
        book=server.book, device=DOME, name="DOME_SHUTTER", element="", states=states
    )
    assert states[int(reading.value)] == "error"


def test_idle_with_a_warning_is_a_refusal_in_the_drivers_words(server: Server) -> None:
    goal = server.begin(MOUNT, "EQUATORIAL_EOD_COORD", RA=3.0, DEC=20.0)
    server.says(f'<message device="{MOUNT}" message="[WARNING] Please unpark the mount."/>')
    server.sets(MOUNT, "EQUATORIAL_EOD_COORD", "Idle", "Number", RA="9", DEC="90")
    outcome = server.looks(goal)
    assert outcome == CommandOutcome(CommandPhase.REFUSED, "Please unpark the mount.")


def test_ok_elsewhere_is_no_success_but_a_failure_once_it_stays(server: Server) -> None:
    goal = server.begin(DOME, "ABS_DOME_POSITION", DOME_ABSOLUTE_POSITION=90.0)
    server.sets(DOME, "ABS_DOME_POSITION", "Ok", "Number", DOME_ABSOLUTE_POSITION="0")
    assert server.looks(goal) is None
    server.passes(1)
    server.sets(DOME, "ABS_DOME_POSITION", "Busy", "Number", DOME_ABSOLUTE_POSITION="45")
    outcome = server.looks(goal)
    assert (outcome.phase, outcome.progress) == (CommandPhase.RUNNING, 0.5)
    server.sets(DOME, "ABS_DOME_POSITION", "Ok", "Number", DOME_ABSOLUTE_POSITION="45")
    assert server.looks(goal) is None
    server.passes(4)
    outcome = server.looks(goal)
    assert outcome.phase is CommandPhase.FAILED
    assert "45.00" in outcome.message


def test_goto_across_the_pole_and_across_zero_hours_is_measured_on_the_sky(server: Server) -> None:
    goal = server.begin(MOUNT, "EQUATORIAL_EOD_COORD", RA=23.9999, DEC=10.0)
    server.sets(MOUNT, "EQUATORIAL_EOD_COORD", "Ok", "Number", RA="0.0001", DEC="10")
    assert server.looks(goal).phase is CommandPhase.SUCCEEDED
    goal = server.begin(DOME, "ABS_DOME_POSITION", DOME_ABSOLUTE_POSITION=359.8)
    server.sets(DOME, "ABS_DOME_POSITION", "Ok", "Number", DOME_ABSOLUTE_POSITION="0.1")
    assert server.looks(goal).phase is CommandPhase.SUCCEEDED


def test_parking_under_way_is_waited_for_and_not_asked_for_again(server: Server) -> None:
    server.sets(MOUNT, "TELESCOPE_PARK", "Busy", PARK="On", UNPARK="Off")
    goal = server.begin(MOUNT, "TELESCOPE_PARK", PARK=True)
    assert goal.outgoing_bytes(server.book) == b""
    assert server.looks(goal).phase is CommandPhase.RUNNING
    server.sets(MOUNT, "TELESCOPE_PARK", "Ok", PARK="On", UNPARK="Off")
    assert server.looks(goal).phase is CommandPhase.SUCCEEDED


def test_exposure_ends_with_its_picture_and_not_with_its_state(server: Server) -> None:
    goal = server.begin(CAMERA, "CCD_EXPOSURE", CCD_EXPOSURE_VALUE=4.0)
    server.sets(CAMERA, "CCD_EXPOSURE", "Busy", "Number", CCD_EXPOSURE_VALUE="1")
    assert server.looks(goal).progress == 0.75
    server.sets(CAMERA, "CCD_EXPOSURE", "Ok", "Number", CCD_EXPOSURE_VALUE="0")
    assert server.looks(goal).phase is CommandPhase.RUNNING
    goal.handle_picture("")
    assert server.looks(goal).phase is CommandPhase.SUCCEEDED


def test_picture_of_no_use_fails_its_exposure(server: Server) -> None:
    goal = server.begin(CAMERA, "CCD_EXPOSURE", CCD_EXPOSURE_VALUE=4.0)
    goal.handle_picture("its base64 is cut short")
    assert server.looks(goal).phase is CommandPhase.FAILED


def test_device_that_goes_away_leaves_its_command_unknown(server: Server) -> None:
    goal = server.begin(DOME, "DOME_SHUTTER", SHUTTER_OPEN=True)
    server.says(f'<delProperty device="{DOME}"/>')
    assert server.looks(goal).phase is CommandPhase.UNKNOWN


@pytest.mark.parametrize(
    ("device", "target", "fields", "reason"),
    [
        ("Nobody", "DOME_SHUTTER", {"SHUTTER_OPEN": True}, "no device 'Nobody'"),
        (DOME, "NOTHING", {"A": True}, "no property NOTHING"),
        (DOME, "DOME_SHUTTER", {"HALF": True}, "has no HALF"),
        (DOME, "DRIVER_INFO", {"DRIVER_NAME": "x"}, "cannot be set"),
        (DOME, "ABS_DOME_POSITION", {"DOME_ABSOLUTE_POSITION": 361.0}, "not within 0 and 360"),
        (CAMERA, "CCD_EXPOSURE", {"CCD_EXPOSURE_VALUE": -1.0}, "not within"),
        (CAMERA, "CCD_EXPOSURE", {"CCD_FRAME_TYPE/*": "odd", "CCD_EXPOSURE_VALUE": 1.0}, "none of"),
        ("Baader Dome", "DOME_SHUTTER", {"SHUTTER_OPEN": True}, "not connected"),
    ],
)
def test_what_cannot_be_asked_is_refused_before_anything_is_sent(
    server: Server, device: str, target: str, fields: dict, reason: str
) -> None:
    problem = begin_goal(
        book=server.book, device=device, target=target, fields=fields, now_ns=server.now_ns
    )
    assert isinstance(problem, str)
    assert reason in problem


def test_frozen_driver_is_asked_nothing_that_it_would_do_much_later(server: Server) -> None:
    server.now_ns += 6 * SECOND
    problem = begin_goal(
        book=server.book,
        device=DOME,
        target="DOME_SHUTTER",
        fields={"SHUTTER_OPEN": True},
        now_ns=server.now_ns,
    )
    assert "has not answered for 6 s" in str(problem)


def test_what_is_set_before_goes_first_and_the_rest_of_a_vector_goes_along(server: Server) -> None:
    goal = server.begin(
        CAMERA, "CCD_EXPOSURE",
        **{"CCD_EXPOSURE_VALUE": 1.0, "FITS_HEADER/FITS_OBJECT": "M<31>", "CCD_FRAME_TYPE/*": "dark"},
    )  # fmt: skip
    sent = goal.outgoing_bytes(server.book).decode()
    assert sent.index("FITS_HEADER") < sent.index("FRAME_DARK") < sent.index("CCD_EXPOSURE")
    assert "M&lt;31&gt;" in sent
    assert "FITS_OBSERVER" in sent


def test_weather_is_as_old_as_its_values_however_often_its_driver_answers(server: Server) -> None:
    server.passes(100)
    reading = read_state(
        book=server.book,
        device="Weather Simulator",
        name="WEATHER_STATUS",
        element="",
        states=("a", "b", "c", "d"),
    )
    assert (reading.value, reading.mono_ns) == (1.0, 0)
    # Defined once more, as the answer to our own question is: no measurement.
    recorded = (RECORDED / "simulators.xml").read_text()
    begin_at = recorded.index('<defNumberVector device="Weather Simulator" name="WEATHER_PARAM')
    server.says(recorded[begin_at:].partition("</defNumberVector>")[0] + "</defNumberVector>")
    wind = ("Weather Simulator", "WEATHER_PARAMETERS", "WEATHER_WIND_SPEED")
    assert read_number(server.book, *wind).mono_ns == 0
    server.sets("Weather Simulator", "WEATHER_PARAMETERS", "Ok", "Number", WEATHER_WIND_SPEED="7")
    assert read_number(server.book, *wind) == (7.0, server.now_ns)
    server.sets("Weather Simulator", "WEATHER_PARAMETERS", "Alert", "Number")
    assert read_number(server.book, *wind) is None


def test_driver_that_leaves_its_hardware_leaves_no_value_behind(server: Server) -> None:
    server.sets(DOME, "CONNECTION", "Idle", CONNECT="Off", DISCONNECT="On")
    assert (
        read_state(
            book=server.book,
            device=DOME,
            name="DOME_SHUTTER",
            element="",
            states=("open", "closed"),
        )
        is None
    )
    assert read_text(server.book, DOME, "CONNECTION", "").value == "Disconnect"


def test_devices_that_are_found_make_a_description_that_holds(server: Server) -> None:
    devices = devices_of(server.book, "indi")
    assert len(devices) == 11
    text = "talaia: 1\nsite: a\nname: A\nconnections: {indi: {kind: indi}}\ndevices: {}\n"
    site = load_site(text)
    both = Site(**{**{f: getattr(site, f) for f in site.__struct_fields__}, "devices": devices})
    assert check_site(both) == []
    assert load_site(dump_site(both)) == both
    assert devices["telescope_simulator"].commands["goto"].arguments["ra"].maximum == 24
    assert devices["ccd_simulator"].signals["filter"].states[3] == "Blue"


def test_hostile_names_make_no_hostile_descriptions(server: Server) -> None:
    for name in (
        "../../etc",
        "<script>",
        "a" * 300,
        "\u202etxt",
        "Ωmega",
        "1.2.3",
        "dome simulator",
    ):
        server.says(
            "<defNumberVector device=%s name='P &amp; Q' state='Ok' perm='rw' label='&#8238;x'>"
            "<defNumber name='E[0]' label='&lt;b&gt;' min='0' max='1'>1</defNumber>"
            "</defNumberVector>" % repr(name.replace("<", "&lt;"))
        )  # fmt: skip
    devices = devices_of(server.book, "indi")
    text = "talaia: 1\nsite: a\nname: A\nconnections: {indi: {kind: indi}}\ndevices: {}\n"
    site = load_site(text)
    both = Site(**{**{f: getattr(site, f) for f in site.__struct_fields__}, "devices": devices})
    assert check_site(both) == []
    assert word_of("../../etc") == "etc"
    assert word_of("Ωmega") == "mega"
    assert word_of("日本") == "indi"
    assert word_of("Dome", ["dome"]) == "dome_2"
