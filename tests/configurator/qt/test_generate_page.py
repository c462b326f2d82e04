"""The second founding design's whole walk: a window, four pages, Generate, and live charts."""

from __future__ import annotations

import importlib.util
import os
import re
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from browser_program import FLAGS, find_browser
from patience import PATIENCE_MS, PATIENCE_S

pytest.importorskip("playwright.sync_api")

from playwright.sync_api import expect, sync_playwright

from talaia.configurator.program_run import ProgramPhase
from talaia.model.yaml_text.load import read_site
from talaia.sim import ros_domain

from ..conftest import answer, type_file, wait

pytestmark = [pytest.mark.robot, pytest.mark.browser, pytest.mark.timeout(240)]
PASSWORD = "a long enough password 7"  # noqa: S105 - of a hub that lives for one test


def missing(what: str) -> None:
    """Skip, or fail where nothing may be missing."""
    if os.environ.get("TALAIA_REQUIRE_ALL"):
        pytest.fail(f"{what} is missing, and TALAIA_REQUIRE_ALL is set")
    pytest.skip(f"{what} is missing")


@pytest.fixture
def chromium() -> str:
    found = find_browser()
    if found is None:
        missing("Chromium")
    return str(found)


@pytest.fixture
def robot(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """The founding robot, running; what this process starts then reaches it."""
    if not importlib.util.find_spec("rclpy"):
        missing("rclpy")
    with ros_domain.reserve_domain() as place:
        for key, value in ros_domain.domain_environment(place.domain).items():
            monkeypatch.setenv(key, value)
        script = Path(__file__).with_name("founding_robot.py")
        process = subprocess.Popen([sys.executable, str(script)], stdout=subprocess.PIPE, text=True)
        assert process.stdout is not None
        try:
            assert process.stdout.readline().strip() == "ready"
            yield
        finally:
            process.kill()
            process.wait()
            process.stdout.close()


def describe(window: Any) -> None:
    """AI services → sensors → services, as a person clicks through them."""
    window.ai.anomalies.click()
    window.next.click()
    page = window.sensors
    for name in ("Temperature", "Voltage", "Humidity"):
        page.kind.setCurrentText(name)
        page.add_button.click()
    page.kind.setCurrentText("Others")
    page.name.setText("Radiation")
    page.add_button.click()
    # The humidity was a mistake.
    page.select(("devices", "sensors", "signals", "humidity1"))
    page.remove_button.click()
    window.next.click()
    for service in (window.robot.actuate, window.robot.camera, window.robot.gps):
        service.switch.click()
    assert window.editor.document.problems == ()


@pytest.mark.usefixtures("robot")
def test_from_an_empty_window_to_live_charts_in_a_browser(
    make_window: Callable[..., Any],
    opened_pages: list[str],
    qt: Any,
    tmp_path: Path,
    chromium: str,
) -> None:
    window = make_window()
    describe(window)
    window.show_page(4)
    file = tmp_path / "robot.yaml"
    answer(qt, type_file(file))
    window.generate.start_button.click()
    run = window.generate.run
    wait(qt, lambda: run.phase is not ProgramPhase.STARTING, 90)
    assert run.phase is ProgramPhase.UP, "\n".join(run.lines)
    site = read_site(file)
    assert site.services is not None
    assert site.services.anomaly_detection
    assert list(site.devices["sensors"].signals) == ["temperature1", "voltage1", "radiation1"]
    # The browser was sent to where the first admin is made.
    assert len(opened_pages) == 1
    assert "/setup#" in opened_pages[0]
    with sync_playwright() as play:
        clean = {key: each for key, each in os.environ.items() if key != "LD_LIBRARY_PATH"}
        browser = play.chromium.launch(executable_path=chromium, args=FLAGS, env=clean)
        page = browser.new_page(viewport={"width": 1440, "height": 900})
        page.set_default_timeout(PATIENCE_MS)
        page.add_init_script(
            "window.__painted = {};"
            "window.__talaiaPainted = (at, us) => { (window.__painted[at] ??= []).push(us); }"
        )
        page.goto(opened_pages[0])
        page.get_by_label("Name").fill("ada")
        page.get_by_label("Password", exact=True).fill(PASSWORD)
        page.get_by_label("Password, once more").fill(PASSWORD)
        page.get_by_role("button", name="Make this admin").click()
        page.wait_for_url(re.compile("/home$"))
        page.goto(f"{run.address}/sites/robot/live")
        expect(page.get_by_text("Temperature 1").first).to_be_visible(timeout=PATIENCE_MS)
        for address in ("sensors/temperature1", "sensors/voltage1", "sensors/radiation1"):
            # Asked again and again from here: the page forbids itself to evaluate texts.
            deadline = time.monotonic() + PATIENCE_S
            while page.evaluate("(each) => (window.__painted[each] ?? []).length", address) <= 5:
                assert time.monotonic() < deadline, f"{address} is not drawn"
                page.wait_for_timeout(50)
        if folder := os.environ.get("TALAIA_PICTURES"):
            page.screenshot(path=f"{folder}/configure-dashboard.png")
        browser.close()
    window.generate.stop_button.click()
    wait(qt, lambda: not run.is_alive, 30)
    assert run.phase is ProgramPhase.ENDED
