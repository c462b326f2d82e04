"""Opening a description from its file: what is wrong in it is told with its lines, all of it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import pytest

from talaia.configurator.files import open_document, opening_problems
from talaia.model.errors import DescriptionError

if TYPE_CHECKING:
    from pathlib import Path

pytestmark = pytest.mark.pure

WRONG = """\
talaia: 1
site: lab
name: Lab
ros2: {}
devices:
  base:
    name: Base
    signals:
      words:
        name: Words
        type: txet
        source: {topic: /said, type: std_msgs/msg/String, field: data}
      speed:
        name: Speed
        unlt: m/s
        source: {topic: /speed, type: std_msgs/msg/Float64, field: data}
"""


def test_all_that_is_wrong_in_a_file_is_told_with_its_line(tmp_path: Path) -> None:
    file = tmp_path / "site.yaml"
    file.write_text(WRONG)
    with pytest.raises(DescriptionError):
        open_document(file)
    assert opening_problems(file) == [
        "line 11: unknown type 'txet'; did you mean 'text'?",
        "line 15: unknown key 'unlt'; did you mean 'unit'?",
    ]


def test_what_is_no_text_is_told_by_its_refusal_alone(tmp_path: Path) -> None:
    assert opening_problems(tmp_path / "gone.yaml") == []
