"""Take the documentation's pictures: every page of the demo, phone and desktop, light and dark.

    .venv/bin/python tools/take_pictures.py [PAGE …]

Starts the demo, lets the vehicle wander so that there is something to see, and writes
docs/pictures/<page>-<width>-<theme>.png.
"""

from __future__ import annotations

import json
import math
import os
import re
import secrets
import shutil
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import psutil
from playwright.sync_api import Browser, Page, sync_playwright

from talaia.sim.ros_domain import domain_environment

if TYPE_CHECKING:
    from collections.abc import Iterator

ROOT = Path(__file__).resolve().parent.parent
TARGET = ROOT / "docs" / "pictures"
WIDTHS = {"desktop": (1440, 900), "phone": (390, 844)}
THEMES = ("light", "dark")
# The tests' own list, which stands beside what finds their browser.
sys.path.append(str(ROOT / "tests"))
from browser_program import FLAGS, SPACE_FLAGS  # noqa: E402


def main(wanted: list[str]) -> int:
    """Take them all, or those that are named."""
    with running_demo() as (address, passwords, folder):
        if not wanted or "storage" in wanted:
            past_week(folder)
        take(address, passwords, wanted)
    return 0


@contextmanager
def running_demo(*options: str) -> Iterator[tuple[str, dict[str, str], Path]]:
    """Run the demo; give its address, the passwords by name, and its folder."""
    folder = tempfile.mkdtemp(prefix="talaia-pictures-")
    process = subprocess.Popen(
        [sys.executable, "-m", "talaia", "demo", "--no-browser", "--data", folder, *options],
        stdout=subprocess.PIPE, text=True, start_new_session=True,
    )  # fmt: skip
    alarm = threading.Timer(240, process.kill)
    alarm.start()
    said = ""
    for line in process.stdout or ():
        said += line
        if "Ctrl-C" in line:
            break
    alarm.cancel()
    try:
        address = re.search(r"\):\s+(\S+)", said)
        passwords = dict(re.findall(r"^    (admin|operator|guest)\s+(\S+)$", said, re.MULTILINE))
        if address is None or len(passwords) < 3:
            raise SystemExit(said)
        yield address[1], passwords, Path(folder)
    finally:
        process.send_signal(signal.SIGINT)
        process.wait(20)
        shutil.rmtree(folder, ignore_errors=True)


def take(address: str, passwords: dict[str, str], wanted: list[str]) -> None:
    """Walk through the pages."""
    TARGET.mkdir(parents=True, exist_ok=True)
    path = shutil.which("chromium") or shutil.which("google-chrome")
    clean = {k: v for k, v in os.environ.items() if k != "LD_LIBRARY_PATH"}
    with sync_playwright() as play:
        browser = play.chromium.launch(executable_path=path, args=FLAGS, env=clean)
        if not wanted or "setup" in wanted:
            set_up(browser)
        if not wanted or {*wanted} & SEEING:
            # From where it starts the vehicle sees somebody.
            shown = [each for each in ("objects", "sightings") if not wanted or each in wanted]
            walk(browser, address, "operator", passwords["operator"], shown)
        for name in ("drive", "wander", "others"):
            if name == "wander":
                if not wanted or {*wanted} & MOVING:
                    wander(browser, address, passwords["operator"])
                continue
            shown = [each for each in PAGES if (each == "drive") == (name == "drive")]
            shown = [each for each in shown if not wanted or each in wanted]
            shown = [each for each in shown if each not in SEEING]
            walk(browser, address, "operator", passwords["operator"], shown)
        shown = [each for each in OBSERVATORY_PAGES if not wanted or each in wanted]
        if shown:
            observe(browser, address, passwords["operator"])
            walk(browser, address, "operator", passwords["operator"], shown)
        for who, pages in (("admin", ADMIN_PAGES), ("guest", GUEST_PAGES)):
            shown = [each for each in pages if not wanted or each in wanted]
            if shown and who == "admin":
                people(browser, address, passwords["admin"])
            if shown:
                walk(browser, address, who, passwords[who], shown)
        shown = [each for each in TOPIC_PAGES if not wanted or each in wanted]
        if shown:
            with telling("diagnostics_robot.py", [json.dumps(STATUSES)]):
                walk(browser, address, "admin", passwords["admin"], shown)
        shown = [each for each in LOG_PAGES if not wanted or each in wanted]
        if shown:
            with telling("log_robot.py", [json.dumps(line) for line in LOG_LINES]):
                walk(browser, address, "admin", passwords["admin"], shown)
        browser.close()
        shown = [each for each in SPACE_PAGES if not wanted or each in wanted]
        if shown:
            browser = play.chromium.launch(executable_path=path, args=SPACE_FLAGS, env=clean)
            walk(browser, address, "operator", passwords["operator"], shown)
            browser.close()


@contextmanager
def telling(robot_file: str, lines: list[str]) -> Iterator[None]:
    """Let a robot in the demo's own ROS domain say these lines in turn, one a second."""
    below = psutil.Process().children(recursive=True)
    # The browser leaves some of its own behind.
    alive = [process for process in below if process.status() != psutil.STATUS_ZOMBIE]
    commands = [process.cmdline() for process in alive]
    vehicle = next(words for words in commands if "vehicle" in words and "--domain" in words)
    domain = int(vehicle[vehicle.index("--domain") + 1])
    script = ROOT / "tests" / "system" / robot_file
    robot = subprocess.Popen(
        [sys.executable, str(script)],
        stdin=subprocess.PIPE,
        stdout=subprocess.DEVNULL,
        text=True,
        env={**os.environ, **domain_environment(domain)},
    )
    ended = threading.Event()

    def publish() -> None:
        turn = 0
        while robot.stdin is not None and not ended.wait(1.0):
            robot.stdin.write(lines[turn % len(lines)] + "\n")
            robot.stdin.flush()
            turn += 1

    thread = threading.Thread(target=publish)
    thread.start()
    try:
        yield
    finally:
        ended.set()
        thread.join()
        # Both end with what they read.
        if robot.stdin is not None:
            robot.stdin.close()
        robot.wait(20)


def past_week(folder: Path) -> None:
    """Import a week of some signals: what each takes is known once there is much of it."""
    table = folder / "week.csv"
    now, step_s = time.time(), 10
    with table.open("w") as lines:
        lines.write("time,power/charge,power/voltage,sensors/temperature\n")
        for age_s in range(7 * 86_400, 600, -step_s):
            turn = 2 * math.pi * age_s / 86_400
            charge, warm = 60 + 35 * math.cos(turn), 21 + 3 * math.sin(turn) + age_s % 7 / 20
            lines.write(
                f"{round((now - age_s) * 1000)},{charge:.2f},{11 + charge / 70:.3f},{warm:.2f}\n"
            )
    subprocess.run(
        [sys.executable, "-m", "talaia", "import", str(table), "--site", "agv",
         "--data", str(folder)],
        check=True, stdout=subprocess.DEVNULL,
    )  # fmt: skip


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


def walk(browser: Browser, address: str, who: str, password: str, shown: list[str]) -> None:
    """Take some pages' pictures in every width and theme."""
    pages = {**PAGES, **OBSERVATORY_PAGES, **ADMIN_PAGES, **GUEST_PAGES}
    pages |= {**TOPIC_PAGES, **LOG_PAGES, **SPACE_PAGES}
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
            sign_in(page, address, password, who)
            for name in shown:
                if name != "login":
                    pages[name](page, address, password)
                    page.screenshot(path=TARGET / f"{name}-{width}-{theme}.png")
                if name in RED and theme == "dark":
                    page.get_by_role("button", name="Red screen").click()
                    page.wait_for_timeout(500)
                    page.screenshot(path=TARGET / f"{name}-{width}-red.png")
                    page.get_by_role("button", name="Leave red").click()
            page.keyboard.up("w")
            context.close()


def sign_in(page: Page, address: str, password: str, who: str = "operator") -> None:
    """Sign in."""
    page.goto(f"{address}/login")
    page.get_by_label("Name").fill(who)
    page.get_by_label("Password").fill(password)
    page.get_by_role("button", name="Sign in", exact=True).click()
    page.wait_for_url(re.compile("/(home|public)$"))


def wander(browser: Browser, address: str, password: str) -> None:
    """Let the vehicle drive about for a while, so that charts and trail show something."""
    page = browser.new_page()
    sign_in(page, address, password)
    page.goto(f"{address}/sites/agv/drive")
    film = page.locator("t-film-button button")
    film.click()
    page.get_by_role("button", name="Send").first.click()
    time.sleep(100)
    film.click()
    # It goes to the hub behind everything else.
    time.sleep(30)
    page.close()


def observe(browser: Browser, address: str, password: str) -> None:
    """Open the dome, turn it, and point the telescope to where the Sun never is."""
    page = browser.new_page()
    sign_in(page, address, password)
    part = "/sites/observatory/devices"
    page.goto(f"{address}{part}/dome")
    # Its rules have to have been safe for a minute.
    page.locator("t-part-dome t-button:not([disabled])", has_text="Open").first.click(
        timeout=180_000
    )
    page.locator("t-deeds t-dialog").get_by_role("button", name="Open").click()
    page.get_by_label("Azimuth (°)").fill("215")
    page.get_by_role("button", name="Send").click()
    page.goto(f"{address}{part}/telescope")
    page.get_by_role("button", name="Unpark").click()
    page.wait_for_timeout(3000)
    # It goes to places on the sky and rates, too, each with a form of its own.
    form = page.locator("t-command", has=page.get_by_label("Altitude (°)"))
    form.get_by_label("Altitude (°)").fill("60")
    form.get_by_label("Azimuth (°)").fill("35")
    form.get_by_role("button", name="Send").click()
    page.wait_for_timeout(25_000)
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


def fleet(page: Page, address: str, _password: str) -> None:
    """Choose a robot and a command, and show who would do it."""
    page.goto(f"{address}/fleet")
    page.get_by_role("checkbox", name="House vehicle").check()
    command = page.get_by_role("region", name="Command", exact=True).get_by_role("combobox")
    command.select_option(label="Vehicle base: Wander about (1 of 1)")
    page.get_by_role("list", name="Who will do it").wait_for()
    page.wait_for_timeout(500)


def missions(page: Page, address: str, _password: str) -> None:
    """Show a mission after its run, written once through the form's own way to the hub."""
    page.goto(f"{address}/sites/agv/missions")
    page.get_by_role("heading", name="Missions", exact=True).first.wait_for()
    row = page.get_by_role("button", name="Start Morning round")
    page.wait_for_timeout(1500)
    if not row.is_visible():
        answer = page.request.post(
            f"{address}/api/sites/agv/missions",
            data={"mission": ROUND},
            headers={"Origin": address},
        )
        if not answer.ok:
            raise SystemExit(answer.text())
        page.reload()
        row.click()
        page.locator("summary").first.wait_for(timeout=120_000)
    page.locator("summary").first.click()
    page.wait_for_timeout(500)


def night(page: Page, address: str, _password: str) -> None:
    """Show an observatory's night on one screen."""
    page.goto(f"{address}/sites/observatory/night")
    page.locator("t-night-glance t-part-dome").wait_for()
    page.wait_for_timeout(4000)


def scene(page: Page, address: str, _password: str) -> None:
    """Show the vehicle in its house, with its scan and the frames."""
    page.goto(f"{address}/sites/agv/scene")
    page.locator("t-scene canvas").wait_for()
    page.get_by_text("live", exact=True).first.wait_for()
    page.wait_for_timeout(4000)


def log(page: Page, address: str, _password: str) -> None:
    """Show what the robot's nodes wrote."""
    page.goto(f"{address}/sites/agv/log")
    # Of those that are kept without being asked for: warnings, and what is worse.
    page.get_by_text(LOG_LINES[5][2]).first.wait_for(timeout=60_000)
    page.wait_for_timeout(500)


def support(page: Page, address: str, _password: str) -> None:
    """Show what is in the file for whoever helps."""
    page.goto(f"{address}/admin/support")
    page.get_by_role("button", name="Make a support bundle").wait_for()
    page.wait_for_timeout(300)


def objects(page: Page, address: str, _password: str) -> None:
    """Show what the camera sees, each in its frame."""
    page.goto(f"{address}/sites/agv/devices/camera")
    page.locator("t-camera .box").first.wait_for(timeout=60_000)
    page.wait_for_timeout(2500)


def sightings(page: Page, address: str, _password: str) -> None:
    """Show what was seen."""
    page.goto(f"{address}/sites/agv/sightings")
    page.locator("t-sighting").first.wait_for()
    page.wait_for_timeout(1500)


def films(page: Page, address: str, _password: str) -> None:
    """Show a film at the cursor of the charts."""
    made = page.request.get(f"{address}/api/sites/agv/films").json()["films"]
    begin_us, end_us = made[0]["begin_us"], made[0]["end_us"]
    at_us = begin_us + (end_us - begin_us) // 3
    page.goto(
        f"{address}/sites/agv/history?c=base/speed&c=base/turn_rate"
        f"&from={begin_us - 5_000_000}&to={end_us + 5_000_000}&at={at_us}"
    )
    page.wait_for_timeout(6000)


def gallery(page: Page, address: str, _password: str) -> None:
    """Show each element in each state."""
    page.goto(f"{address}/gallery")
    time.sleep(2)


def people(browser: Browser, address: str, password: str) -> None:
    """Make a role and two people, so that the admin's pages show more than the seeded ones."""
    page = browser.new_page()
    sign_in(page, address, password, "admin")
    view = {"right": "view", "site": "agv", "device": "*"}
    use = {"right": "use", "site": "agv", "device": "power"}
    asks = [
        ("roles", {"name": "battery crew", "permissions": [view, use]}),
        ("people", {"name": "Ada", "password": secrets.token_urlsafe(9), "role": "battery crew"}),
        ("people", {"name": "Grace", "password": secrets.token_urlsafe(9), "role": "operator"}),
    ]
    for path, body in asks:
        answer = page.request.post(f"{address}/api/{path}", data=body, headers={"Origin": address})
        if not answer.ok:
            print(path, answer.status, answer.text())
    for protocol in ("foxglove", "metrics"):
        answer = page.request.put(
            f"{address}/api/client-protocols/{protocol}",
            data={"open": True},
            headers={"Origin": address},
        )
        if not answer.ok:
            print(protocol, answer.status, answer.text())
    low = {"name": "Battery is not full", "kind": "limit", "signal": "power/charge", "below": 99.9,
           "severity": "warning", "advice": "Drive it to its charger."}  # fmt: skip
    answer = page.request.put(
        f"{address}/api/sites/agv/alarms/to_the_charger", data=low, headers={"Origin": address}
    )
    if not answer.ok:
        print("alarm", answer.status, answer.text())
    page.close()


def devices(page: Page, address: str, _password: str) -> None:
    """Show every device that is open to the operator."""
    page.goto(f"{address}/devices")
    page.get_by_role("heading", name="Vehicle base").wait_for()
    page.wait_for_timeout(500)


def board(page: Page, address: str, _password: str) -> None:
    """Show the board that is made of the vehicle's description."""
    page.goto(f"{address}/boards/template:agv")
    page.locator("t-board-tile").first.wait_for()
    page.wait_for_timeout(4000)


def device(page: Page, address: str, _password: str) -> None:
    """Show one device."""
    page.goto(f"{address}/sites/agv/devices/base")
    page.get_by_role("heading", name="Speed").wait_for()
    page.wait_for_timeout(2500)


def dome(page: Page, address: str, _password: str) -> None:
    """Show the dome, open."""
    page.goto(f"{address}/sites/observatory/devices/dome")
    page.get_by_text("looking to").wait_for()
    page.wait_for_timeout(2500)


def telescope(page: Page, address: str, _password: str) -> None:
    """Show the sky, and a galaxy through the night."""
    page.goto(f"{address}/sites/observatory/devices/telescope")
    page.locator("t-goto input[name=name]").fill("M31")
    page.get_by_role("button", name="Find").click()
    page.locator("t-night-curve svg").first.wait_for()
    page.evaluate("scrollTo(0, 0)")
    page.wait_for_timeout(1500)


def weather(page: Page, address: str, _password: str) -> None:
    """Show the verdict with the rules that decide."""
    page.goto(f"{address}/sites/observatory/devices/weather")
    page.get_by_role("heading", name="What closes the roof").wait_for()
    page.wait_for_timeout(2500)


def power(page: Page, address: str, _password: str) -> None:
    """Show the outlets."""
    page.goto(f"{address}/sites/observatory/devices/power")
    page.get_by_role("heading", name="Outlets").wait_for()
    page.wait_for_timeout(2500)


def public(page: Page, address: str, _password: str) -> None:
    """Show the guest's page."""
    page.goto(f"{address}/public")
    page.get_by_role("heading", name="Vehicle base").wait_for()
    page.wait_for_timeout(1500)


def account(page: Page, address: str, _password: str) -> None:
    """Show the account of whoever looks."""
    page.goto(f"{address}/account")
    page.get_by_text("this one").wait_for()
    page.wait_for_timeout(300)


def people_page(page: Page, address: str, _password: str) -> None:
    """Show the people, one unfolded."""
    page.goto(f"{address}/admin/people")
    page.get_by_role("button", name="Edit Ada").click()
    page.wait_for_timeout(400)


def roles(page: Page, address: str, _password: str) -> None:
    """Show the matrix with a change that is not saved."""
    page.goto(f"{address}/admin/roles")
    crew = page.get_by_role("radio", name="battery crew")
    page.get_by_role("heading", name="Roles").wait_for()
    page.get_by_text("Every site", exact=True).first.wait_for()
    if crew.is_visible():
        crew.check(force=True)
    page.get_by_label(re.compile("^battery crew on Camera")).select_option("use")
    page.wait_for_timeout(400)


def gateways(page: Page, address: str, _password: str) -> None:
    """Show a fresh code, and the demo's gateway."""
    page.goto(f"{address}/admin/gateways")
    page.get_by_role("button", name="Enrol a gateway").click()
    page.locator("t-enrol #site").fill("dome")
    page.get_by_role("button", name="Make a code").click()
    page.get_by_text("waiting for the gateway").wait_for()
    page.wait_for_timeout(500)


def clients(page: Page, address: str, _password: str) -> None:
    """Show which tools may connect, and who may drive by them."""
    page.goto(f"{address}/admin/clients")
    page.get_by_text("Foxglove").first.wait_for()
    page.wait_for_timeout(500)


def storage(page: Page, address: str, _password: str) -> None:
    """Show what each signal takes."""
    page.goto(f"{address}/admin/storage")
    page.locator("t-storage-table").wait_for()
    page.wait_for_timeout(300)


def audit(page: Page, address: str, _password: str) -> None:
    """Show the newest rows and the verified chain."""
    page.goto(f"{address}/admin/audit")
    page.get_by_role("button", name="Verify the chain").click()
    page.get_by_text("The chain holds").wait_for()
    page.wait_for_timeout(300)


def alarms(page: Page, address: str, _password: str) -> None:
    """Show an alarm that stands, and its bar."""
    page.goto(f"{address}/alarms")
    page.get_by_role("heading", name="Alarms", exact=True).wait_for()
    page.get_by_text("Battery is not full").first.wait_for()
    page.wait_for_timeout(500)


def logbook(page: Page, address: str, _password: str) -> None:
    """Show what happened at the vehicle."""
    page.goto(f"{address}/sites/agv/logbook")
    page.get_by_role("heading", name="Logbook").wait_for()
    page.wait_for_timeout(800)


def description(page: Page, address: str, _password: str) -> None:
    """Open the form of the description."""
    page.goto(f"{address}/admin/description")
    page.get_by_text("in use").first.wait_for()
    page.get_by_text("Edit", exact=True).first.click()
    page.get_by_text("nothing changed yet").wait_for()
    page.wait_for_timeout(500)


def topics(page: Page, address: str, _password: str) -> None:
    """Show the topics, and one laser scan as a tree."""
    page.goto(f"{address}/sites/agv/topics?topic=/scan")
    page.locator("t-message-tree").get_by_text("ranges", exact=True).wait_for()
    page.wait_for_timeout(2500)


def diagnostics(page: Page, address: str, _password: str) -> None:
    """Show diagnostics as a tree, with the values of what is in trouble."""
    page.goto(f"{address}/sites/agv/topics?topic=/diagnostics")
    page.locator("t-diagnostics").get_by_role("button", name="wheel left").click()
    page.wait_for_timeout(1500)


# Off and on: it ends by itself.
STEP = {
    "kind": "command", "device": "base", "command": "wander", "units": {}, "condition": "",
    "seconds": 60, "goes_on": False,
}  # fmt: skip
WAIT = {**STEP, "kind": "pause", "name": "", "device": "", "command": "", "args": {}, "seconds": 2}
ROUND = {
    "name": "Morning round",
    "note": "A look at every room before the house wakes.",
    "steps": [
        {**STEP, "name": "Set off", "args": {"active": True}},
        WAIT,
        {**STEP, "name": "Stand still", "args": {"active": False}},
    ],
    "schedule": {"at": "06:30", "days": ["mon", "wed", "fri"], "date": ""},
}
PAGES = {
    "login": login, "home": home, "board": board, "live": live, "history": history, "drive": drive,
    "gallery": gallery, "devices": devices, "device": device, "objects": objects,
    "sightings": sightings, "films": films, "night": night, "fleet": fleet, "missions": missions,
}  # fmt: skip
OBSERVATORY_PAGES = {"dome": dome, "telescope": telescope, "weather": weather, "power": power}
ADMIN_PAGES = {
    "account": account, "people": people_page, "roles": roles, "gateways": gateways,
    "alarms": alarms, "logbook": logbook, "description": description, "storage": storage,
    "audit": audit, "clients": clients, "support": support,
}  # fmt: skip
TOPIC_PAGES = {"topics": topics, "diagnostics": diagnostics}
LOG_PAGES = {"log": log}
# In these a graphics card is stood in for.
SPACE_PAGES = {"scene": scene}
# Taken in red besides.
RED = ("night",)
# Name, level, message and values of what `diagnosing` publishes.
STATUSES = [
    [
        "/Vehicle/Drive/wheel left",
        2,
        "Over-current, switched off",
        {"current": "7.4 A", "limit": "5 A"},
    ],
    ["/Vehicle/Drive/wheel right", 0, "In order", {"current": "0.6 A"}],
    ["/Vehicle/Battery", 1, "18 % left", {"voltage": "11.1 V", "charge": "18 %"}],
    ["lidar: rate", 0, "9.98 Hz", {"wanted": "10 Hz"}],
    ["lidar: connection", 0, "Connected", {"port": "/dev/ttyUSB0"}],
]
# Node, level and text of what the robot's log says, one after the other.
LOG_LINES: list[tuple[str, int, str]] = [
    ("bt_navigator", 20, "Begin navigating from (0.61, 0.42) to (3.20, -1.05)"),
    ("controller_server", 20, "Received a goal, begin computing control effort"),
    ("planner_server", 30, "GridBased: goal is 0.14 m beyond the known map, tolerance 0.25 m"),
    ("amcl", 10, "Resampled 1842 particles"),
    ("controller_server", 30, "Control loop missed its desired rate of 20 Hz: 17.4 Hz"),
    ("lidar", 40, "No answer from /dev/ttyUSB0 for 0.5 s, asking again"),
    ("lidar", 20, "Connected to /dev/ttyUSB0, 10.0 Hz"),
    ("bt_navigator", 20, "Goal succeeded"),
]
# Of these the vehicle should have driven about before.
MOVING = {"home", "board", "live", "history", "devices", "device", "films"}
SEEING = {"objects", "sightings"}
GUEST_PAGES = {"public": public}


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
