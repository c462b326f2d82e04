"""Take the documentation's pictures: every page of the demo, phone and desktop, light and dark.

    .venv/bin/python tools/take_pictures.py [PAGE …]

Starts the demo, lets the vehicle wander so that there is something to see, and writes
docs/pictures/<page>-<width>-<theme>.png.
"""

from __future__ import annotations

import os
import re
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path

from playwright.sync_api import Browser, Page, sync_playwright

ROOT = Path(__file__).resolve().parent.parent
TARGET = ROOT / "docs" / "pictures"
WIDTHS = {"desktop": (1440, 900), "phone": (390, 844)}
THEMES = ("light", "dark")
FLAGS = [
    "--no-sandbox", "--disable-gpu", "--no-first-run", "--disable-background-networking",
    "--disable-component-update", "--disable-sync",
]  # fmt: skip


def main(wanted: list[str]) -> int:
    """Take them all, or those that are named."""
    process = subprocess.Popen(
        [sys.executable, "-m", "talaia", "demo", "--no-browser"],
        stdout=subprocess.PIPE, text=True, start_new_session=True,
    )  # fmt: skip
    alarm = threading.Timer(60, process.kill)
    alarm.start()
    said = ""
    for line in process.stdout or ():
        said += line
        if "Ctrl-C" in line:
            break
    alarm.cancel()
    try:
        address = re.search(r"\):\s+(\S+)", said)
        password = re.search(r"operator\s+(\S+)", said)
        if address is None or password is None:
            print(said)
            return 1
        take(address[1], password[1], wanted)
    finally:
        process.send_signal(signal.SIGINT)
        process.wait(20)
    return 0


def take(address: str, password: str, wanted: list[str]) -> None:
    """Walk through the pages."""
    TARGET.mkdir(parents=True, exist_ok=True)
    path = shutil.which("chromium") or shutil.which("google-chrome")
    clean = {k: v for k, v in os.environ.items() if k != "LD_LIBRARY_PATH"}
    with sync_playwright() as play:
        browser = play.chromium.launch(executable_path=path, args=FLAGS, env=clean)
        if not wanted or "setup" in wanted:
            set_up(browser)
        for name in ("drive", "wander", "others"):
            if name == "wander":
                wander(browser, address, password)
                continue
            shown = [each for each in PAGES if (each == "drive") == (name == "drive")]
            shown = [each for each in shown if not wanted or each in wanted]
            walk(browser, address, password, shown)
        browser.close()


def set_up(browser: Browser) -> None:
    """Show the page that a new hub's one-time link opens."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = str(probe.getsockname()[1])
    with tempfile.TemporaryDirectory() as folder:
        hub = subprocess.Popen(
            [sys.executable, "-m", "talaia", "hub", "--plain", "--host", "127.0.0.1",
             "--port", port, "--data", folder],
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, start_new_session=True,
        )  # fmt: skip
        alarm = threading.Timer(60, hub.kill)
        alarm.start()
        try:
            lines = hub.stdout or ()
            links = (re.search(r"http\S+/setup\S+", line) for line in lines)
            link = next(found[0] for found in links if found)
            for width, size in WIDTHS.items():
                for theme in THEMES:
                    page = browser.new_page(
                        viewport={"width": size[0], "height": size[1]},
                        color_scheme=theme,  # type: ignore[arg-type]
                    )
                    page.goto(link)
                    page.get_by_label("Name").wait_for()
                    page.wait_for_timeout(500)
                    page.screenshot(path=TARGET / f"setup-{width}-{theme}.png")
                    page.close()
        finally:
            alarm.cancel()
            hub.terminate()
            hub.wait(20)


def walk(browser: Browser, address: str, password: str, shown: list[str]) -> None:
    """Take some pages' pictures in every width and theme."""
    for width, size in WIDTHS.items():
        for theme in THEMES:
            context = browser.new_context(
                viewport={"width": size[0], "height": size[1]},
                color_scheme=theme,  # type: ignore[arg-type]
                has_touch=width == "phone",
            )
            page = context.new_page()
            if "login" in shown:
                login(page, address, password)
                page.screenshot(path=TARGET / f"login-{width}-{theme}.png")
            sign_in(page, address, password)
            for name in shown:
                if name != "login":
                    PAGES[name](page, address, password)
                    page.screenshot(path=TARGET / f"{name}-{width}-{theme}.png")
            page.keyboard.up("w")
            context.close()


def sign_in(page: Page, address: str, password: str) -> None:
    """Sign in as the operator."""
    page.goto(f"{address}/login")
    page.get_by_label("Name").fill("operator")
    page.get_by_label("Password").fill(password)
    page.get_by_role("button", name="Sign in").click()
    page.wait_for_url("**/home")


def wander(browser: Browser, address: str, password: str) -> None:
    """Let the vehicle drive about for a while, so that charts and trail show something."""
    page = browser.new_page()
    sign_in(page, address, password)
    page.goto(f"{address}/sites/agv/drive")
    page.get_by_role("button", name="Send").first.click()
    time.sleep(100)
    page.close()


def login(page: Page, address: str, _password: str) -> None:
    """Show the sign-in page."""
    page.goto(f"{address}/login")
    page.get_by_label("Name").wait_for()


def home(page: Page, address: str, _password: str) -> None:
    """Show the sites."""
    page.goto(f"{address}/home")
    page.get_by_role("heading", name="House vehicle").wait_for()
    time.sleep(1.5)


def live(page: Page, address: str, _password: str) -> None:
    """Show the charts with some of their past."""
    page.goto(f"{address}/sites/agv/live")
    time.sleep(6)


def history(page: Page, address: str, _password: str) -> None:
    """Show the last minutes."""
    page.goto(f"{address}/sites/agv/history?last=300")
    time.sleep(4)


def drive(page: Page, address: str, _password: str) -> None:
    """Show camera, pad and map while driving; the key is let go by the caller."""
    page.goto(f"{address}/sites/agv/drive")
    page.get_by_role("button", name="Take control").click()
    page.wait_for_timeout(2500)
    page.keyboard.down("w")
    page.wait_for_timeout(1500)


def gallery(page: Page, address: str, _password: str) -> None:
    """Show each element in each state."""
    page.goto(f"{address}/gallery")
    time.sleep(2)


PAGES = {
    "login": login, "home": home, "live": live, "history": history, "drive": drive,
    "gallery": gallery,
}  # fmt: skip


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
