"""Whatever ends a machine, and whenever: a whole release runs at the next start."""

from __future__ import annotations

import contextlib
import shutil
import tempfile
from pathlib import Path

import pytest
from bare_release import bare_release
from hypothesis import settings, strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, rule

from talaia.updates.errors import UpdateError
from talaia.updates.slot_folder import SlotFolder
from talaia.updates.slots import (
    MOST_TRIES,
    SlotPhase,
    SlotState,
    begin_trial,
    begin_update,
    confirm_trial,
    end_trial,
    mark_allowed,
    mark_installed,
    recover_state,
    slot_to_run,
    version_order,
)

OLD, NEW = "1.0.0", "1.1.0"
# Each change is forced to the disk; some thousand of them need none.
MEMORY = "/dev/shm" if Path("/dev/shm").is_dir() else None  # noqa: S108 - of a test
VERSIONS = st.sampled_from(["0.9.0", OLD, NEW, "1.2.0rc1", "2.0"])


class PowerCut(Exception):
    """The machine has no power any more."""


def build_whole(_wheels: list[Path], slot: Path) -> None:
    """Write what makes a release whole, the program last."""
    (slot / "bin").mkdir()
    (slot / "lib").write_text("whole")
    (slot / "bin" / "talaia").write_text("program")


class UpdatesUnderPowerCuts(RuleBasedStateMachine):
    """Installs, tries, keeps and leaves releases, with a power cut after any change of the disk."""

    def __init__(self) -> None:
        """Begin on an empty disk."""
        super().__init__()
        self.root = Path(tempfile.mkdtemp(dir=MEMORY)) / "software"
        self.left: int | None = None
        self.seen_running: set[str] = set()

    def checkpoint(self, _what: str) -> None:
        """Cut the power once there are no changes left."""
        if self.left is not None:
            self.left -= 1
            if self.left < 0:
                raise PowerCut

    @contextlib.contextmanager
    def until_cut(self, changes: int | None):  # type: ignore[no-untyped-def]
        """Do something until the power is cut, or it is refused."""
        self.left = changes
        with contextlib.suppress(PowerCut, UpdateError):
            yield SlotFolder(self.root, self.checkpoint)
        self.left = None

    @initialize()
    def first_release(self) -> None:
        """Begin with a gateway that runs."""
        SlotFolder(self.root).set_up(bare_release(OLD), build_whole)

    @rule(version=VERSIONS, changes=st.none() | st.integers(0, 12), downgrade=st.booleans())
    def install(self, version: str, changes: int | None, *, downgrade: bool) -> None:
        """Install any release."""
        with self.until_cut(changes) as folder:
            folder.install_release(bare_release(version), build_whole, downgrade=downgrade)

    @rule(changes=st.none() | st.integers(0, 3))
    def allow(self, changes: int | None) -> None:
        """Be at rest."""
        with self.until_cut(changes) as folder:
            folder.allow_trial()

    @rule(changes=st.none() | st.integers(0, 8))
    def start(self, changes: int | None) -> None:
        """Start the machine."""
        with self.until_cut(changes) as folder:
            slot = folder.start_slot()
            assert (slot.program.parent.parent / "lib").read_text() == "whole"
            self.seen_running.add(slot.version)

    @rule(changes=st.none() | st.integers(0, 8))
    def keep(self, changes: int | None) -> None:
        """Have a link."""
        with self.until_cut(changes) as folder:
            folder.keep_candidate()

    @rule(changes=st.none() | st.integers(0, 8))
    def leave(self, changes: int | None) -> None:
        """Have none in time."""
        with self.until_cut(changes) as folder:
            folder.leave_candidate("no link")

    @invariant()
    def a_whole_release_would_run_now(self) -> None:
        """Start a copy of the disk as it is."""
        if not (self.root / "update.json").exists():
            return
        copy = Path(tempfile.mkdtemp(dir=MEMORY)) / "software"
        shutil.copytree(self.root, copy, symlinks=True)
        for _ in range(MOST_TRIES + 1):
            slot = SlotFolder(copy).start_slot()
            assert (slot.program.parent.parent / "lib").read_text() == "whole"
            # For service managers, which know no other way to it.
            assert (copy / "current" / "bin" / "talaia").exists()
        # After so many starts without a link it is the one that is known to work.
        assert not slot.on_trial
        assert slot.version == SlotFolder(copy).read_state().current
        shutil.rmtree(copy.parent)

    def teardown(self) -> None:
        """Leave nothing behind."""
        shutil.rmtree(self.root.parent)


UpdatesUnderPowerCuts.TestCase.settings = settings(
    max_examples=25, stateful_step_count=20, deadline=None
)
TestUpdatesUnderPowerCuts = UpdatesUnderPowerCuts.TestCase


def tried(version: str = NEW) -> SlotState:
    """Give a state in which a release is tried."""
    state = begin_update(SlotState(current=OLD), version, downgrade=True)
    return begin_trial(mark_allowed(mark_installed(state)))


def test_a_release_is_kept_when_its_link_is_there() -> None:
    kept = confirm_trial(tried())
    assert kept == SlotState(current=NEW, previous=OLD)
    assert slot_to_run(kept) == NEW


def test_a_release_without_a_link_is_left_with_the_reason() -> None:
    left = end_trial(tried(), "no link")
    assert (left.current, left.phase, left.failed) == (OLD, SlotPhase.IDLE, {NEW: "no link"})


def test_a_release_that_was_started_too_often_is_left() -> None:
    state = tried()
    for _ in range(MOST_TRIES - 1):
        assert slot_to_run(recover_state(state)) == NEW
        state = begin_trial(state)
    assert slot_to_run(recover_state(state)) == OLD


def test_what_waits_is_not_run_before_the_gateway_is_at_rest() -> None:
    waiting = mark_installed(begin_update(SlotState(current=OLD), NEW, downgrade=False))
    assert slot_to_run(recover_state(waiting)) == OLD
    with pytest.raises(UpdateError, match="does not fit"):
        begin_trial(waiting)


def test_an_older_release_needs_permission_and_the_same_is_none() -> None:
    current = SlotState(current=NEW)
    for older in (OLD, "1.1.0rc2", "1.1.0a1"):
        with pytest.raises(UpdateError, match="older"):
            begin_update(current, older, downgrade=False)
        assert begin_update(current, older, downgrade=True).candidate == older
    with pytest.raises(UpdateError, match="what runs"):
        begin_update(current, NEW, downgrade=True)


def test_another_update_waits_until_the_one_before_is_decided() -> None:
    with pytest.raises(UpdateError, match="under way"):
        begin_update(tried(), "2.0", downgrade=False)


def test_versions_have_an_order_and_are_no_paths() -> None:
    ordered = [
        "0.9", "1.0.0.dev3", "1.0.0.dev12+g8fd5cecf", "1.0.0a1", "1.0.0b1", "1.0.0rc1",
        "1.0.0rc2.dev4+g8fd5cecf", "1.0.0rc2", "1.0.0rc10", "1.0.0", "1.0.1.dev1", "1.0.1",
        "1.10.0",
    ]  # fmt: skip
    assert sorted(set(ordered), key=version_order) == ordered
    for wrong in ("", "..", "1", "1.0/..", "1.0.0.0", "1.0.0.dev1+../x", "1.0\n", "١.٢"):
        with pytest.raises(UpdateError):
            SlotFolder(Path("/x")).slot_path(wrong)
