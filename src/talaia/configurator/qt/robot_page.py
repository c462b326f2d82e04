"""Third page: what the robot offers beside sensors: actuate, camera, GPS."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

from PySide6.QtWidgets import QComboBox, QGridLayout, QLabel, QLineEdit, QWidget

from talaia.configurator import edits
from talaia.configurator.description_paths import value_at, with_value
from talaia.configurator.errors import BadValue
from talaia.configurator.form_rows import parse_text, rows_of
from talaia.configurator.qt.palette import SPACE
from talaia.configurator.qt.widgets import (
    Card,
    ComboBox,
    Page,
    Switch,
    make_button,
    make_label,
    make_row,
    mark_wrong,
)
from talaia.model.site import Drive, DriveMessage

if TYPE_CHECKING:
    from collections.abc import Callable

    from talaia.configurator.description_paths import Path
    from talaia.configurator.qt.editor import Editor
    from talaia.model.site import Site

__all__ = ["RobotPage"]

_MESSAGES = {
    DriveMessage.KEYS: "keys w x a d s (std_msgs/String)",
    DriveMessage.TWIST: "velocity (geometry_msgs/Twist)",
    DriveMessage.TWIST_STAMPED: "velocity with time (geometry_msgs/TwistStamped)",
    DriveMessage.ACKERMANN: "steered wheels (ackermann_msgs/AckermannDrive)",
    DriveMessage.ACKERMANN_STAMPED: "steered wheels (ackermann_msgs/AckermannDriveStamped)",
    DriveMessage.JOINT_JOG: "joints (control_msgs/JointJog)",
    DriveMessage.JOINT_VELOCITIES: "joints (std_msgs/Float64MultiArray)",
    DriveMessage.PTZ: "pan, tilt and zoom (ONVIF)",
}


class _Entry(NamedTuple):
    """A field of a card: its words, its widget, and what it fills in the thing."""

    text: str
    widget: QLineEdit | QComboBox
    field: Path


class _Service(Card):
    """One service: a switch, its fields, and a way to the rest of them."""

    def __init__(
        self,
        editor: Editor,
        name: str,
        sentence: str,
        *,
        found: Callable[[Site], list[Path]],
        added: Callable[[Site], Site],
        entries: tuple[_Entry, ...],
    ) -> None:
        super().__init__()
        self._editor, self._name = editor, name
        # How its things are found in a site, how one is added, and the fields on the card.
        self._found, self._added, self._entries = found, added, entries
        self.switch = Switch(name)
        self.switch.setAccessibleDescription(sentence)
        self.switch.clicked.connect(lambda on=False: self._switch_service(on=on))
        self.more = make_button(f"More of {name} …", self._show_more)
        self.where = make_label("", "muted", wrap=True)
        self.wrong = make_label("", "bad", wrap=True)
        self.buttons = make_row(self.switch, 1, self.more)
        self.body.addLayout(self.buttons)
        self.body.addWidget(make_label(sentence, "muted", wrap=True))
        self._fields = QWidget()
        grid = QGridLayout(self._fields)
        grid.setContentsMargins(0, 0, 0, 0)
        grid.setHorizontalSpacing(SPACE[1])
        for column, entry in enumerate(entries):
            title = QLabel(entry.text)
            title.setBuddy(entry.widget)
            entry.widget.setAccessibleName(f"{name}: {entry.text}")
            grid.addWidget(title, 0, column)
            grid.addWidget(entry.widget, 1, column)
            grid.setColumnStretch(column, 3 if entry.field[-1] in ("topic", "message") else 1)
            self._connect_entry(entry)
        self.body.addWidget(self._fields)
        self.body.addWidget(self.where)
        self.body.addWidget(self.wrong)

    def _connect_entry(self, entry: _Entry) -> None:
        widget = entry.widget
        if isinstance(widget, QComboBox):
            # Activated: by a person only, not when a value is shown.
            widget.activated.connect(lambda _: self._apply_text(entry, widget.currentData()))
        else:
            widget.editingFinished.connect(lambda: self._apply_text(entry, widget.text()))

    def show_site(self) -> None:
        site = self._editor.site
        paths = self._found(site)
        self.switch.setChecked(bool(paths))
        self._fields.setEnabled(bool(paths))
        self.more.setEnabled(bool(paths))
        names = ", ".join("/".join(path[1::2]) for path in paths[:4])
        rest = f" and {len(paths) - 4} more" if len(paths) > 4 else ""
        self.where.setText(f"{names}{rest}")
        self.where.setVisible(len(paths) > 1)
        problems = [
            problem
            for problem in self._editor.document.problems
            if paths and problem.spot.node == paths[0]
        ]
        self.wrong.setText("\n".join(map(str, problems)))
        self.wrong.setVisible(bool(problems))
        for entry in self._entries:
            if not paths:
                continue
            value = value_at(site, (*paths[0], *entry.field))
            if isinstance(entry.widget, QComboBox):
                entry.widget.setCurrentIndex(entry.widget.findData(str(value)))
            else:
                text = f"{value:.15g}" if isinstance(value, float) else str(value)
                if entry.widget.text() != text:
                    entry.widget.setText(text)
            wrong = any(problem.spot.field == entry.field for problem in problems)
            mark_wrong(entry.widget, wrong=wrong)

    def _switch_service(self, *, on: bool) -> None:
        if on:
            done = self._editor.apply(f"add {self._name.lower()}", self._added)
        else:
            done = self._editor.apply(
                f"remove {self._name.lower()}",
                lambda site: edits.without_things(site, self._found(site)),
            )
        # The switch has moved by itself; a change that was refused must move it back.
        if not done:
            self.show_site()

    def _apply_text(self, entry: _Entry, text: str) -> None:
        paths = self._found(self._editor.site)
        if not paths:
            return
        value: object = DriveMessage(text) if entry.field == ("message",) else text.strip()
        # Numbers are read by the form's own rule, so that both fields take the same.
        if entry.field[-1].startswith("max_"):
            kind = next(setting for setting in rows_of(Drive) if setting.path == entry.field)
            try:
                value = parse_text(kind, text)
            except BadValue as error:
                self.wrong.setText(f"{entry.text}: {error}")
                self.wrong.show()
                mark_wrong(entry.widget, wrong=True)
                return
        self._editor.apply(
            f"change {entry.text.lower()} of {self._name.lower()}",
            lambda site: with_value(site, (*paths[0], *entry.field), value),
        )
        self.show_site()

    def _show_more(self) -> None:
        self._editor.show_thing(self._found(self._editor.site)[0])


class RobotPage(Page):
    """Switches for the three services of the founding vehicle."""

    def __init__(self, editor: Editor) -> None:
        """Show the open document."""
        super().__init__(
            "Services",
            "What else the robot offers. The topics are those of CloudConnect; "
            "write your robot's own.",
        )
        message = ComboBox()
        for kind, text in _MESSAGES.items():
            message.addItem(text, str(kind))
        self.actuate = _Service(
            editor,
            "Actuate",
            "Drive the robot from the dashboard: hold to run, one driver at a time, with STOP. "
            "Raise the careful limits to what your robot may do.",
            found=lambda site: [
                ("devices", device, "drive") for device in edits.driven_devices(site)
            ],
            added=edits.with_drive,
            entries=(
                _Entry("Topic", QLineEdit(edits.CONTROL), ("topic",)),
                _Entry("Message", message, ("message",)),
                _Entry("Speed (m/s)", QLineEdit(f"{edits.CAREFUL_SPEED}"), ("max_speed",)),
                _Entry("Turn (rad/s)", QLineEdit(f"{edits.CAREFUL_TURN}"), ("max_turn",)),
            ),
        )
        self.camera = _Service(
            editor,
            "Camera",
            "Show live pictures (sensor_msgs/Image).",
            found=edits.camera_paths,
            added=edits.with_camera,
            entries=(
                _Entry("Topic", QLineEdit(edits.IMAGES), ("source", "topic")),
                _Entry("Name", QLineEdit("Front camera"), ("name",)),
            ),
        )
        self.gps = _Service(
            editor,
            "GPS",
            "Show the robot on the map of the Earth (sensor_msgs/NavSatFix).",
            found=edits.position_paths,
            added=edits.with_gps,
            entries=(
                _Entry("Topic", QLineEdit(edits.FIX), ("source", "topic")),
                _Entry("Name", QLineEdit("Geographic position"), ("name",)),
            ),
        )
        self.another = make_button(
            "Add another", lambda: editor.apply("add camera", edits.with_camera)
        )
        self.camera.buttons.insertWidget(2, self.another)
        self._editor = editor
        for card in (self.actuate, self.camera, self.gps):
            self.body.addWidget(card)
        self.body.addStretch(1)
        editor.changed.connect(self.show_site)
        self.show_site()

    def show_site(self) -> None:
        """Show the site as it is now."""
        for card in (self.actuate, self.camera, self.gps):
            card.show_site()
        self.another.setVisible(bool(edits.camera_paths(self._editor.site)))
