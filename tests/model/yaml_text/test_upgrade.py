"""An older description is brought up to date, and whoever wrote it finds it as it was otherwise."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest
from hypothesis import given, settings, strategies as st

from talaia.model.errors import DescriptionError
from talaia.model.site import LinkLoss
from talaia.model.yaml_text.load import load_site
from talaia.model.yaml_text.upgrade import STEPS, Tree, UpgradeStep, upgrade_text
from talaia.model.yaml_text.version import FORMAT

EXAMPLES = sorted((Path(__file__).parents[3] / "examples").glob("*/site.yaml"))
OLD = """\
# Bought in May.
talaia: 1
site: cart    # on the door
name: "Cart"
ros2: {domain: 7}
devices:
  base:
    name: Base
    drive:
      topic: /cmd_vel
      max_speed: 1.50   # m/s
      max_turn: 1
      # it coasts
      link_loss: nothing
"""


def renamed(tree: Tree) -> Iterator[str]:
    """What a version 2 could do: another name for the key ``zone``."""
    if "zone" in tree:
        tree["time_zone"] = tree.pop("zone")
        yield "$.zone: is now time_zone"


def halved(tree: Tree) -> Iterator[str]:
    """What a version 3 could do."""
    if isinstance(tree.get("rate"), int):
        tree["rate"] = tree["rate"] // 2
        yield "$.rate: is now half of it"


LATER = (*STEPS, UpgradeStep(2, renamed), UpgradeStep(3, halved))


def test_an_older_word_is_written_as_today_and_one_line_has_changed() -> None:
    after, changes = upgrade_text(OLD)
    assert changes == ("$.devices.base.drive.link_loss: nothing is now written hold",)
    assert after == OLD.replace("link_loss: nothing", "link_loss: hold")
    drive = load_site(after).devices["base"].drive
    assert drive is not None
    assert drive.link_loss is LinkLoss.HOLD


def test_what_was_upgraded_has_nothing_left_to_upgrade() -> None:
    after = upgrade_text(OLD).text
    assert upgrade_text(after) == (after, ())


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.parent.name)
def test_the_examples_are_written_as_today(path: Path) -> None:
    assert upgrade_text(path.read_text()).changes == ()


def test_a_description_two_versions_old_goes_through_every_step_in_its_order() -> None:
    text = "talaia: 1\n# where it stands\nzone: Europe/Madrid\nrate: 8 # Hz\n"
    after, changes = upgrade_text(text, LATER, 3)
    assert [each.split(":")[0] for each in changes] == ["$.zone", "$.rate", "$.talaia"]
    assert after.startswith("talaia: 3\n# where it stands\n")
    assert "rate: 4 # Hz" in after
    assert "time_zone: Europe/Madrid" in after


def test_a_description_of_the_version_between_takes_the_later_steps() -> None:
    after, changes = upgrade_text("talaia: 2\nrate: 8\n", LATER, 3)
    assert after == "talaia: 3\nrate: 4\n"
    assert len(changes) == 2


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (f"talaia: {FORMAT + 1}\n", "newer Talaia"),
        ("talaia: 0\n", "never was"),
        ("talaia: new\n", "found 'new'"),
        ("site: cart\n", "it is missing"),
        ("- talaia\n", "expected a mapping"),
        ("talaia: [", "not YAML"),
    ],
)
def test_what_cannot_be_upgraded_says_why(text: str, said: str) -> None:
    with pytest.raises(DescriptionError, match=said):
        upgrade_text(text)


def test_two_places_that_are_one_by_an_alias_change_together() -> None:
    text = "talaia: 1\ndevices:\n  a: &a\n    drive: {link_loss: nothing}\n  b: *a\n"
    after = upgrade_text(text).text
    assert after == text.replace("nothing", "hold")


def test_line_ends_of_another_system_stay() -> None:
    text = OLD.replace("\n", "\r\n")
    assert upgrade_text(text).text == text.replace("nothing", "hold")


shapes = st.recursive(
    st.none() | st.booleans() | st.just("nothing") | st.text(max_size=5),
    lambda inner: (
        st.lists(inner, max_size=2)
        | st.dictionaries(
            st.sampled_from(["devices", "drive", "link_loss", "a"]), inner, max_size=3
        )
    ),
    max_leaves=8,
)


@settings(deadline=None)
@given(shapes)
def test_whatever_stands_in_a_description_a_step_only_raises_what_it_says(shape: object) -> None:
    tree: Tree = {"talaia": 1, "devices": shape}
    for step in STEPS:
        list(step.change(tree))
        assert list(step.change(tree)) == []
