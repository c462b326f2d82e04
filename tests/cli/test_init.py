"""``talaia init``: names that are refused before anything is written, and what is asked of STOP."""

from __future__ import annotations

from pathlib import Path

import msgspec
import pytest
from described_robot import found_of, read_robot

from talaia.cli.describing.init_questions import (
    ask_about_devices,
    ask_about_stop,
    ask_for_name,
    names_called,
)
from talaia.cli.main import main
from talaia.model.checks.site_checks import check_site
from talaia.model.discovery.generate_description import propose_description
from talaia.model.discovery.probe_report import DeviceFound, Found
from talaia.model.yaml_text.load import load_site


@pytest.fixture
def report(tmp_path: Path) -> Path:
    path = tmp_path / "found.json"
    path.write_bytes(msgspec.json.encode(found_of(read_robot("chosen", "jackal"))))
    return path


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--site", "Rover 1"], "--site: 'Rover 1' cannot be a name in an address; use a small"),
        (["--zone", "Mars/Olympus"], "--zone: "),
        (["--name", " "], "--name: "),
    ],
)
def test_a_name_that_check_would_refuse_is_refused_and_nothing_is_written(
    words: list[str], said: str, report: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "site.yaml"
    assert main(["init", "--found", str(report), "-o", str(out), *words]) == 2
    assert said in capsys.readouterr().err
    assert not out.exists()


def test_without_a_terminal_nothing_is_asked_and_the_file_says_what_stop_may_be(
    report: Path, tmp_path: Path
) -> None:
    out = tmp_path / "site.yaml"
    assert main(["init", "--found", str(report), "-o", str(out), "--site", "jackal"]) == 0
    text = out.read_text()
    assert "stop: {topic: /e_stop} if `true` on it stops the robot" in text
    site = load_site(text)
    (drive,) = [device.drive for device in site.devices.values() if device.drive]
    assert (drive.stop.topic, drive.stop.confirmed_by) == ("", ())
    # Each reason is there, however many they are.
    assert "/jackal_velocity_controller/cmd_vel_unstamped: a velocity that" in text


def test_stop_goes_by_what_its_owner_answers_and_no_answer_is_no() -> None:
    made = propose_description(found_of(read_robot("chosen", "jackal")), "j", "J", "UTC")
    asked: list[str] = []

    def answer(question: str) -> str:
        asked.append(question)
        if "/e_stop" in question:
            return "Y"
        return "yes" if "Odometry speed" in question else ""

    answers = ask_about_stop(made, answer)
    assert answers.topic == "/e_stop"
    assert answers.confirmed_by == ("base/odometry_speed",)
    assert len(asked) == 1 + len(made.stops[0].signals)

    def leave(_: str) -> str:
        raise EOFError

    assert ask_about_stop(made, leave) == ("", ())


def test_devices_are_listed_and_those_that_are_not_wanted_are_named_as_left_out(
    capsys: pytest.CaptureFixture[str],
) -> None:
    robot = found_of(read_robot("chosen", "jackal"))
    made = propose_description(robot, "j", "J", "UTC")
    assert made.site.devices["base"].drive.picture.startswith("front_camera/")
    words = list(made.site.devices)
    lines = iter([f"{words.index('navsat') + 1}, 99", f"{words.index('navsat') + 1} front_camera"])
    without = ask_about_devices(made, lambda _: next(lines))
    assert without == {"navsat", "front_camera"}
    said = capsys.readouterr().err
    assert "There is no device 99" in said
    assert "driven by /cmd_vel" in said
    short = propose_description(robot, "j", "J", "UTC", without=without)
    assert set(words) - set(short.site.devices) == {"navsat", "front_camera"}
    assert {"navsat: not wanted", "front_camera: not wanted"} <= set(short.left_out)
    assert check_site(short.site) == []
    # It is driven still, without a picture.
    assert short.site.devices["base"].drive.picture == ""
    assert ask_about_devices(made, lambda _: "") == frozenset()


def test_the_name_that_people_say_is_asked_and_an_empty_line_takes_the_machines() -> None:
    assert ask_for_name("vm-domain-4", lambda _: " Rover ") == "Rover"
    assert ask_for_name("vm-domain-4", lambda _: "") == "vm-domain-4"

    def leave(_: str) -> str:
        raise EOFError

    assert ask_for_name("vm-domain-4", leave) == "vm-domain-4"


@pytest.mark.parametrize(
    ("name", "site", "short"),
    [
        ("Ròver del camp", None, "rover_del_camp"),
        ("Rover", "dome", "vm_domain_4"),
        ("Марсоход", None, "vm_domain_4"),
        ("", None, "vm_domain_4"),
    ],
)
def test_the_short_name_of_a_site_follows_what_people_call_it_unless_it_was_given(
    name: str, site: str | None, short: str
) -> None:
    named = names_called(("vm_domain_4", "vm-domain-4", "UTC"), name, site)
    assert named == (short, name or "vm-domain-4", "UTC")


def test_drivers_without_hardware_are_told_at_once_and_nothing_is_asked_of_them(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    device = DeviceFound(device="Dome Simulator", driver="", connected=False)
    found = Found(
        talaia_probe=1,
        protocol="indi",
        where="INDI server hut:7624",
        host="hut",
        port=7624,
        seconds=1,
        devices=(device,),
    )
    made = propose_description(found, "hut", "Hut", "UTC")

    def ask(_: str) -> str:
        raise AssertionError("there is nothing to choose from")

    assert ask_about_devices(made, ask) == frozenset()
    path = tmp_path / "found.json"
    path.write_bytes(msgspec.json.encode(found))
    assert main(["init", "--found", str(path), "-o", str(tmp_path / "site.yaml")]) == 0
    assert "note: Dome Simulator: not connected to the hardware yet" in capsys.readouterr().err


def test_nothing_is_asked_of_a_robot_that_is_not_there(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "found.json"
    path.write_bytes(
        msgspec.json.encode(
            Found(talaia_probe=1, protocol="ros2", where="ROS 2, domain 3", seconds=5, domain=3)
        )
    )
    assert main(["init", "--found", str(path), "-o", str(tmp_path / "site.yaml")]) == 2
    said = capsys.readouterr().err
    assert "it may be in another domain (its ROS_DOMAIN_ID, here --domain N) or network" in said
    assert not (tmp_path / "site.yaml").exists()
