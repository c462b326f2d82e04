"""First page: what is done with the data, and what the robot is called."""

from __future__ import annotations

from typing import TYPE_CHECKING

import msgspec

from talaia.configurator.description_paths import with_value
from talaia.configurator.edits import ai_services, with_services
from talaia.configurator.form_rows import Row, rows_at
from talaia.configurator.qt.form import Form
from talaia.configurator.qt.widgets import Card, Page, Switch, make_label

if TYPE_CHECKING:
    from talaia.configurator.description_paths import Path
    from talaia.configurator.qt.editor import Editor

__all__ = ["AiPage"]

_SHOWN = ("name", "site", "zone")


class AiPage(Page):
    """Switches of the AI services, and the site's own fields."""

    def __init__(self, editor: Editor) -> None:
        """Show the open document."""
        super().__init__("AI services", "What Talaia computes from the robot's data.")
        self._editor = editor
        card = Card()
        self.visualization = Switch("Visualization")
        self.visualization.setChecked(True)
        # Shown for the list to be whole; there is nothing to switch.
        self.visualization.setEnabled(False)
        self.anomalies = Switch("&Anomaly detection")
        self.objects = Switch("&Object detection")
        for switch, sentence in (
            (self.visualization, "Live charts, history, camera and map. Always on."),
            (self.anomalies, "Marks unusual readings."),
            (self.objects, "Counts persons, vehicles and animals on every camera."),
        ):
            switch.setAccessibleName(switch.text().replace("&", ""))
            switch.setAccessibleDescription(sentence)
            card.body.addWidget(switch)
            told = make_label(sentence, "muted", wrap=True)
            told.setIndent(50)
            card.body.addWidget(told)
        self.anomalies.clicked.connect(
            lambda on=False: self._switch_service("anomaly_detection", on=on)
        )
        self.objects.clicked.connect(
            lambda on=False: self._switch_service("object_detection", on=on)
        )
        self.body.addWidget(card)
        robot = Card("The robot")
        self.form = Form()
        self.form.edited.connect(self._apply_edit)
        robot.body.addWidget(self.form)
        self.body.addWidget(robot)
        self.body.addStretch(1)
        editor.changed.connect(self.show_site)
        self.show_site()

    def show_site(self) -> None:
        """Show the site as it is now."""
        services = ai_services(self._editor.site)
        self.anomalies.setChecked(services.anomaly_detection)
        self.objects.setChecked(services.object_detection)
        rows = [row for row in rows_at(self._editor.site, ()) if row.key in _SHOWN]
        wrong = {
            ".".join(problem.spot.field): str(problem)
            for problem in self._editor.document.problems
            # Problems of the site itself have the empty path.
            if not problem.spot.node
        }
        self.form.show_thing(
            [row._replace(label=_LABELS[row.key]) for row in rows], self._editor.site, wrong
        )

    def go_to(self, field: Path) -> bool:
        """Put the focus into a field of the site; false where this page has it not."""
        return self.form.go_to(".".join(field))

    def _switch_service(self, key: str, *, on: bool) -> None:
        wanted = msgspec.structs.replace(ai_services(self._editor.site), **{key: on})
        word = "switch on" if on else "switch off"
        self._editor.apply(
            f"{word} {key.replace('_', ' ')}", lambda site: with_services(site, wanted)
        )

    def _apply_edit(self, row: Row, value: object) -> None:
        self._editor.apply(
            f"change {row.label.lower()}", lambda site: with_value(site, row.path, value)
        )


_LABELS = {"name": "Name", "site": "Short name, for addresses", "zone": "Time zone"}
