"""Find on robot in the window: what is run, its progress, its end, and what it says of failures."""

from __future__ import annotations

import stat
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import msgspec
import pytest
from sqlalchemy import make_url

from talaia.configurator.program_run import ProgramPhase
from talaia.configurator.robot_discovery import DiscoveryPhase
from talaia.model.checks.site_checks import check_site
from talaia.model.discovery.probe_report import FieldFound, Found, TopicFound

from ..conftest import wait

pytest.importorskip("PySide6.QtCore", exc_type=ImportError)

FIELDS = (FieldFound("data", "number"),)
FOUND = Found(1, "ros2", "ROS 2, domain 0", 5.0, domain=0, topics=(
    TopicFound("/height", "std_msgs/msg/Float64", 1, rate=10, fields=FIELDS),
    TopicFound("/images", "sensor_msgs/msg/Image", 1, rate=10),
    TopicFound("/odd", "odd_msgs/msg/Odd", 1, problem="the type is not known here"),
))  # fmt: skip
SAID = msgspec.json.encode(FOUND).decode()


@pytest.fixture
def scripted(tmp_path: Path, make_window: Callable[..., Any]) -> Callable[[str], Any]:
    """Makes a window whose Talaia is a script that says what a real one would."""

    def make(text: str) -> Any:
        script = tmp_path / "scripted.py"
        script.write_text(text)
        return make_window(sys.executable, str(script))

    return make


def finished(dialog: Any) -> bool:
    return dialog.look.phase not in (DiscoveryPhase.RUNNING, DiscoveryPhase.CANCELLING)


def test_what_is_found_fills_the_description_as_one_step(scripted: Any, qt: Any) -> None:
    window = scripted(f"print({SAID!r})")
    dialog = window.finder
    dialog.open()
    dialog.start_button.click()
    assert dialog.bar.isVisible()
    assert not dialog.start_button.isEnabled()
    wait(qt, lambda: finished(dialog))
    assert dialog.told.text() == "Added 1 sensors, 1 cameras. Undo reverts it."
    assert "/odd: the type is not known here" in dialog.left_out.toPlainText()
    assert check_site(window.editor.site) == []
    assert window.sensors.table.model().rowCount() == 1
    dialog.start_button.click()
    wait(qt, lambda: finished(dialog))
    assert "Nothing new: all 2" in dialog.told.text()
    window.editor.undo()
    assert window.editor.site.devices == {}
    dialog.close()


def test_a_cancelled_look_ends_its_process_and_changes_nothing(scripted: Any, qt: Any) -> None:
    window = scripted("import signal; signal.pause()")
    dialog = window.finder
    dialog.open()
    dialog.start_button.click()
    wait(qt, lambda: dialog.bar.value() > 5)
    dialog.close_button.click()
    wait(qt, lambda: finished(dialog))
    assert dialog.look.phase is DiscoveryPhase.CANCELLED
    assert "nothing was changed" in dialog.told.text()
    assert dialog.isVisible()
    assert not window.editor.document.is_changed
    dialog.close_button.click()
    assert not dialog.isVisible()


def test_a_failure_is_told_with_its_last_words(scripted: Any, qt: Any) -> None:
    window = scripted("import sys; sys.exit('the graph cannot be joined')")
    dialog = window.finder
    dialog.start()
    wait(qt, lambda: finished(dialog))
    assert "the graph cannot be joined" in dialog.problem.text()
    assert dialog.start_button.isEnabled()


def test_a_bad_host_is_told_before_anything_is_run(window: Any) -> None:
    dialog = window.finder
    dialog.open()
    dialog.there.setChecked(True)
    for host in ("", "-oProxyCommand=x", "a b"):
        dialog.host.setText(host)
        dialog.start_button.click()
        assert "not a computer's name" in dialog.problem.text()
        assert dialog.look.phase is DiscoveryPhase.IDLE
    dialog.close()


def test_over_ssh_the_words_are_arguments_and_no_shell_sees_them(
    qt: Any, make_window: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    # Stands where ssh would, writes down what it was given, and answers as the robot would.
    (tmp_path / "answer.json").write_text(SAID)
    ssh = tmp_path / "ssh"
    ssh.write_text(
        f'#!/bin/sh\nprintf "%s\\n" "$@" > {tmp_path}/given\ncat {tmp_path}/answer.json\n'
    )
    ssh.chmod(ssh.stat().st_mode | stat.S_IXUSR)
    monkeypatch.setenv("PATH", f"{tmp_path}:/usr/bin:/bin")
    window = make_window()
    dialog = window.finder
    dialog.there.setChecked(True)
    dialog.host.setText("ana@robot.local:2222")
    dialog.program.setText("/opt/talaia/bin/talaia")
    dialog.start()
    wait(qt, lambda: finished(dialog))
    assert dialog.look.phase is DiscoveryPhase.DONE
    assert (tmp_path / "given").read_text().splitlines() == [
        "-T", "-o", "BatchMode=yes", "-o", "ConnectTimeout=10", "-p", "2222", "--",
        "ana@robot.local", "/opt/talaia/bin/talaia", "probe", "--json", "--seconds", "5",
    ]  # fmt: skip


def test_a_start_that_fails_says_why_and_leaves_the_log(
    scripted: Any, qt: Any, tmp_path: Path
) -> None:
    window = scripted("import sys; print('one'); sys.exit('talaia up: port 8470 is taken')")
    window.sensors.add_button.click()
    window.editor.file = tmp_path / "site.yaml"
    page = window.generate
    page.start_button.click()
    assert not page.start_button.isEnabled()
    wait(qt, lambda: not page.run.is_alive)
    assert page.problem.text() == "talaia up: port 8470 is taken"
    assert "one" in page.log.toPlainText()
    assert page.start_button.isEnabled()
    assert (tmp_path / "site.yaml").exists()


def test_this_machine_offers_a_file_or_a_database_server_and_asks_where_it_is(
    window: Any, tmp_path: Path
) -> None:
    window.sensors.add_button.click()
    window.editor.file = tmp_path / "site.yaml"
    page = window.generate
    choice = page.local_database
    assert choice.environment() == {"TALAIA_DATABASE_URL": "", "TALAIA_DATABASE_URL_FILE": ""}
    for kind in ("mariadb", "postgresql"):
        choice.kind.setCurrentIndex(choice.kind.findData(kind))
        choice.address.setText("here")
        page.start_button.click()
        assert page.run.phase is ProgramPhase.IDLE
        assert "user@host/database" in page.problem.text()
        choice.address.setText(" talaia@db.example:4711/rover ")
        choice.password.setText("p@ss/word")
        url = f"{kind}://talaia:p%40ss%2Fword@db.example:4711/rover"
        assert choice.environment() == {"TALAIA_DATABASE_URL": url}
        # The hub reads it as it was meant.
        assert make_url(url).render_as_string(hide_password=False) == url


def test_the_started_hub_keeps_its_data_where_it_was_chosen(
    window: Any, qt: Any, tmp_path: Path
) -> None:
    window.sensors.add_button.click()
    window.editor.file = tmp_path / "site.yaml"
    page = window.generate
    choice = page.local_database
    choice.kind.setCurrentIndex(choice.kind.findData("postgresql"))
    # Nobody listens there: the hub itself says so, with the place and without the password.
    choice.address.setText("talaia@127.0.0.1:9/rover")
    choice.password.setText("secret-word")
    page.start_button.click()
    wait(qt, lambda: not page.run.is_alive, 60)
    said = page.log.toPlainText()
    assert page.run.phase is ProgramPhase.FAILED
    assert "127.0.0.1" in said
    assert "secret-word" not in said


def test_a_deployment_is_written_by_the_real_generator(
    window: Any, qt: Any, tmp_path: Path
) -> None:
    window.sensors.add_button.click()
    window.editor.file = tmp_path / "site.yaml"
    page = window.generate
    page.make_button.click()
    assert "choose a folder" in page.made_problem.text()
    page.folder.setText(str(tmp_path / "out"))
    page.database.setCurrentIndex(page.database.findData("postgresql"))
    page.make_button.click()
    wait(qt, lambda: not page.made.is_alive, 60)
    assert page.made_problem.text() == ""
    assert "README.md" in page.made_state.text()
    assert (tmp_path / "out/README.md").exists()
    page.make_button.click()
    wait(qt, lambda: not page.made.is_alive, 60)
    assert "--force" in page.made_problem.text()


def test_what_stop_goes_by_is_asked_and_a_yes_is_written(scripted: Any, qt: Any) -> None:
    driven = msgspec.structs.replace(FOUND, topics=(
        TopicFound("/cmd_vel", "geometry_msgs/msg/Twist", 0, 1),
        TopicFound("/e_stop", "std_msgs/msg/Bool", 0, 1),
    ))  # fmt: skip
    window = scripted(f"print({msgspec.json.encode(driven).decode()!r})")
    dialog, asked = window.finder, []
    dialog.confirm = lambda question: asked.append(question) or True
    dialog.open()
    dialog.start_button.click()
    wait(qt, lambda: finished(dialog))
    assert asked == ["/e_stop listens. Does `true` on it stop the robot, and `false` let it go?"]
    (drive,) = [one.drive for one in window.editor.site.devices.values() if one.drive]
    assert drive.stop.topic == "/e_stop"
    dialog.close()
