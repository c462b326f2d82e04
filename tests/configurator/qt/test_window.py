"""The window without a screen: pages, keys, problems, files, and every field's name."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from talaia.configurator.description_paths import value_at
from talaia.model.ai_services import AiServices
from talaia.model.checks.site_checks import check_site
from talaia.model.yaml_text.load import load_site, read_site

from ..conftest import answer, choose, settle, type_file

pytest.importorskip("PySide6.QtCore", exc_type=ImportError)

from PySide6.QtCore import Qt
from PySide6.QtGui import QAccessible
from PySide6.QtTest import QTest
from PySide6.QtWidgets import QAbstractButton, QApplication, QComboBox, QWidget

AGV = Path(__file__).parents[3] / "examples/agv/site.yaml"
CTRL = Qt.KeyboardModifier.ControlModifier
SPEED = ("devices", "base", "signals", "speed")


def press(window: Any, key: Qt.Key, modifier: Any = Qt.KeyboardModifier.NoModifier) -> None:
    QTest.keyClick(QApplication.focusWidget() or window, key, modifier)
    settle(QApplication.instance())


def typed(widget: Any, text: str) -> None:
    # A dialog that was just closed had the focus.
    widget.window().activateWindow()
    settle(QApplication.instance())
    widget.setFocus()
    widget.selectAll()
    QTest.keyClicks(widget, text)
    QTest.keyClick(widget, Qt.Key.Key_Tab)
    settle(QApplication.instance())


def typed_lines(widget: Any, text: str) -> None:
    widget.window().activateWindow()
    settle(QApplication.instance())
    widget.setFocus()
    widget.setPlainText(text)
    QTest.keyClick(widget, Qt.Key.Key_Tab)
    settle(QApplication.instance())


def test_the_keyboard_alone_makes_a_robot_that_runs(window: Any) -> None:
    press(window, Qt.Key.Key_1, CTRL)
    assert QApplication.focusWidget() is window.ai.anomalies
    press(window, Qt.Key.Key_Space)
    press(window, Qt.Key.Key_2, CTRL)
    assert QApplication.focusWidget() is window.sensors.kind
    QTest.keyClicks(window.sensors.kind, "Volt")
    window.sensors.add_button.setFocus()
    press(window, Qt.Key.Key_Return)
    press(window, Qt.Key.Key_Return)
    press(window, Qt.Key.Key_3, CTRL)
    assert QApplication.focusWidget() is window.robot.actuate.switch
    press(window, Qt.Key.Key_Space)
    site = window.editor.site
    assert check_site(site) == []
    assert site.services.anomaly_detection
    assert list(site.devices["sensors"].signals) == ["voltage1", "voltage2"]
    assert site.devices["base"].drive is not None
    for _ in range(4):
        press(window, Qt.Key.Key_Z, CTRL)
    assert window.editor.site.devices == {}
    assert not window.editor.document.is_changed


def test_object_detection_is_switched_on_and_off(window: Any) -> None:
    switch = window.ai.objects
    switch.click()
    assert window.editor.site.services == AiServices(object_detection=True)
    assert switch.isChecked()
    switch.click()
    assert window.editor.site.services in (None, AiServices())


def test_a_camera_looks_for_what_is_written_and_is_saved_so(window: Any, tmp_path: Path) -> None:
    file = tmp_path / "site.yaml"
    file.write_text(AGV.read_text())
    window.open_file(file)
    window.show_page(3)
    camera = ("devices", "camera", "streams", "front")
    before = value_at(window.editor.site, (*camera, "detect"))
    window.devices.select(camera)
    form = window.devices.form
    if before is None:
        form.field("detect").click()
    assert form.field("detect").isChecked()
    typed_lines(form.field("detect.classes"), "person\nforklift")
    assert "forklift" in str(window.editor.document.problems[0])
    assert form.field("detect.classes").property("wrong") is True
    typed_lines(form.field("detect.classes"), "person\ntruck")
    typed(form.field("detect.confidence"), "0.6")
    assert window.editor.document.problems == ()
    assert window.save()
    saved = load_site(file.read_text()).devices["camera"].streams["front"].detect
    assert saved is not None
    assert (saved.classes, saved.confidence) == (("person", "truck"), 0.6)
    form.field("detect").click()
    assert value_at(window.editor.site, (*camera, "detect")) is None


def test_a_sensor_of_ones_own_has_the_name_number_and_unit_that_were_written(window: Any) -> None:
    page = window.sensors
    window.show_page(1)
    page.kind.setCurrentText("Others")
    page.add_button.click()
    assert "needs a name" in window.notice_text.text()
    assert QApplication.focusWidget() is page.name
    typed(page.name, "Radiation")
    page.number.setValue(7)
    page.unit.setCurrentIndex(page.unit.findData("ppm"))
    page.add_button.click()
    signal = window.editor.site.devices["sensors"].signals["radiation7"]
    assert (signal.name, signal.unit, signal.source.name) == ("Radiation 7", "ppm", "Radiation7")
    assert not window.notice.isVisible()


def test_sensors_are_removed_by_a_click_and_by_del_and_come_back(window: Any) -> None:
    window.open_file(AGV)
    window.show_page(1)
    settle(QApplication.instance())
    table = window.sensors.table
    place = window.sensors.click_remove(SPEED)
    QTest.mouseClick(table.viewport(), Qt.MouseButton.LeftButton, pos=place)
    assert "speed" not in window.editor.site.devices["base"].signals
    table.setFocus()
    press(window, Qt.Key.Key_Delete)
    assert "turn_rate" not in window.editor.site.devices["base"].signals
    assert window.editor.document.problems == ()
    window.editor.undo()
    window.editor.undo()
    assert window.editor.site == read_site(AGV)


def test_one_click_on_a_problem_leads_to_its_field(window: Any) -> None:
    window.open_file(AGV)
    for path, wrong in (
        (SPEED, "max_age"),
        (("devices", "base", "drive"), "max_turn"),
        (("devices", "base", "commands", "wander", "arguments", "active"), "default"),
        ((), "zone"),
    ):
        page = window.devices if path else window.ai
        window.show_page(3 if path else 0)
        if path:
            window.devices.select(path)
        typed(page.form.field(wrong), "-1")
        window.show_page(4)
        settle(QApplication.instance())
        assert not window.generate.start_button.isEnabled()
        assert window.problems.list.count() == 1
        row = window.problems.list.visualItemRect(window.problems.list.item(0)).center()
        QTest.mouseClick(window.problems.list.viewport(), Qt.MouseButton.LeftButton, pos=row)
        settle(QApplication.instance())
        focused = QApplication.focusWidget()
        assert focused is not None
        assert focused.objectName() == wrong
        assert focused.property("wrong") is True
        window.editor.undo()
        assert not window.problems.list.isVisible()


def test_what_is_no_number_is_told_at_its_field_and_changes_nothing(window: Any) -> None:
    window.open_file(AGV)
    window.go_to(SPEED, ("maximum",))
    field = window.sensors.form.field("maximum")
    typed(field, "fast")
    assert field.property("wrong") is True
    assert "expected a number" in field.accessibleDescription()
    assert window.editor.site == read_site(AGV)
    typed(field, "0,5")
    assert value_at(window.editor.site, (*SPEED, "maximum")) == 0.5


def test_the_file_is_saved_with_its_comments_and_only_asked_about_when_it_is_changed(
    window: Any, qt: Any, tmp_path: Path
) -> None:
    file = tmp_path / "site.yaml"
    file.write_text(AGV.read_text())
    assert window.open_file(file)
    assert "site.yaml" in window.windowTitle()
    assert not window.isWindowModified()
    window.go_to(SPEED, ("name",))
    field = window.sensors.form.field("name")
    settle(qt)
    field.selectAll()
    # Nothing is left out of what was typed before Ctrl+S, though the field has the focus still.
    QTest.keyClicks(field, "Velocity")
    press(window, Qt.Key.Key_S, CTRL)
    assert file.read_text() == AGV.read_text().replace("name: Speed\n", "name: Velocity\n", 1)
    assert not window.isWindowModified()
    window.editor.undo()
    answer(qt, choose("Cancel"))
    window.new()
    assert window.editor.file == file
    answer(qt, choose("Discard"))
    window.new()
    assert window.editor.file is None
    assert "Velocity" in file.read_text()


def test_what_somebody_else_wrote_is_not_written_over_without_a_question(
    window: Any, qt: Any, tmp_path: Path
) -> None:
    file = tmp_path / "site.yaml"
    file.write_text(AGV.read_text())
    window.open_file(file)
    window.robot.gps.switch.click()
    file.write_text(AGV.read_text() + "# a colleague was here\n")
    answer(qt, choose("Cancel"))
    assert not window.save()
    assert "a colleague" in file.read_text()
    answer(qt, choose("Save"))
    assert window.save()
    assert "fix" not in load_site(file.read_text()).devices["sensors"].signals


def test_a_file_that_cannot_be_opened_says_where_and_leaves_what_is_open(
    window: Any, tmp_path: Path
) -> None:
    bad = tmp_path / "bad.yaml"
    bad.write_text(AGV.read_text().replace("unit: m/s\n", "unlt: m/s\n", 1))
    window.open_file(AGV)
    assert not window.open_file(bad)
    line = bad.read_text().splitlines().index("        unlt: m/s") + 1
    said = f"line {line}: unknown key 'unlt'; did you mean 'unit'?"
    assert said in window.notice_text.text()
    assert window.editor.file == AGV


def test_a_new_description_is_saved_where_the_person_says(
    window: Any, qt: Any, tmp_path: Path
) -> None:
    window.sensors.add_button.click()
    answer(qt, type_file(tmp_path / "robot.yaml"))
    assert window.save()
    assert load_site((tmp_path / "robot.yaml").read_text()) == window.editor.site


def test_devices_and_commands_are_added_by_name_and_removed(window: Any, qt: Any) -> None:
    window.open_file(AGV)
    window.show_page(3)
    answer(qt, lambda dialog: (dialog.setTextValue("Arm lift"), dialog.accept()))
    groups = {each.key: each for each in window.devices._show_groups()}
    window.devices._ask(groups["devices"])
    assert window.devices.selected() == ("devices", "arm_lift")
    window.devices.add("commands", "Raise")
    assert window.devices.selected() == ("devices", "arm_lift", "commands", "raise")
    assert [each.where for each in window.editor.document.problems] != []
    typed(window.devices.form.field("target"), "/arm/raise")
    typed(window.devices.form.field("type"), "std_srvs/srv/Trigger")
    assert window.editor.document.problems == ()
    window.devices.select(("devices", "arm_lift"))
    window.devices.tree.setFocus()
    press(window, Qt.Key.Key_Delete)
    assert window.editor.site == read_site(AGV)


def test_each_field_that_the_keyboard_reaches_says_its_name(window: Any) -> None:
    window.open_file(AGV)
    QAccessible.setActive(True)
    for number in range(5):
        window.show_page(number)
        if number == 1:
            window.sensors.select(SPEED)
        if number == 3:
            window.devices.select(("devices", "base", "drive"))
        settle(QApplication.instance())
        reached = _tab_around(window)
        assert len(reached) > 8
        for widget in reached:
            said = QAccessible.queryAccessibleInterface(widget).text(QAccessible.Text.Name)
            assert said, f"page {number}: {widget} {widget.objectName()}"


def _tab_around(window: QWidget) -> list[QWidget]:
    """Press Tab until the focus is where it began."""
    first = QApplication.focusWidget()
    assert first is not None
    reached = [first]
    while len(reached) < 200:
        QTest.keyClick(QApplication.focusWidget(), Qt.Key.Key_Tab)
        now = QApplication.focusWidget()
        if now is None or now in reached:
            return reached
        reached.append(now)
    raise AssertionError("Tab never comes round")


def test_nothing_is_cut_off_on_a_small_laptop(window: Any) -> None:
    window.open_file(AGV)
    for number in range(5):
        window.show_page(number)
        settle(QApplication.instance())
        assert (window.width(), window.height()) == (1024, 700)
        page = window.pages.currentWidget()
        assert page.horizontalScrollBar().maximum() == 0
        for widget in page.findChildren(QAbstractButton):
            if widget.isVisible() and not isinstance(widget.parent(), QComboBox) and widget.text():
                assert widget.width() >= widget.minimumSizeHint().width(), widget.text()


def test_colours_follow_the_machine_and_the_pages_tokens(window: Any) -> None:
    from talaia.configurator.qt.palette import DARK, LIGHT, colours_now

    tokens = (Path(__file__).parents[3] / "web/src/elements/base/tokens.css").read_text()
    _, light, dark, *_ = tokens.split("/* theme ")
    for colours, theme in ((LIGHT, light), (DARK, dark)):
        for name, value in colours._asdict().items():
            assert f"--t-{name.replace('_', '-')}: {value};" in theme
    window.paint(DARK)
    assert colours_now() is DARK
    window.paint(LIGHT)
    assert colours_now() is LIGHT


def test_thousands_of_signals_are_opened_and_changed(window: Any, tmp_path: Path) -> None:
    source = "{topic: /metric, type: std_msgs/msg/String, name: s%d}"
    rows = [f"      s{n}: {{name: S {n}, source: {source % n}}}\n" for n in range(4_000)]
    file = tmp_path / "big.yaml"
    file.write_text(
        "talaia: 1\nsite: big\nname: Big\nros2: {}\ndevices:\n  d:\n    name: D\n    signals:\n"
        + "".join(rows)
    )
    assert window.open_file(file)
    window.show_page(1)
    path = ("devices", "d", "signals", "s3777")
    assert window.sensors.select(path, ("name",))
    typed(window.sensors.form.field("name"), "Renamed")
    assert value_at(window.editor.site, (*path, "name")) == "Renamed"


def test_none_outlives_more_calls_than_it_has_references(qt: Any) -> None:
    # PySide6 6.12.0 ends the test run here on Python 3.11, for it forgets to count them.
    for _ in range(30_000):
        assert qt.activeModalWidget() is None
