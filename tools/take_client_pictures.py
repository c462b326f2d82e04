"""Take the documentation's pictures of other tools that are connected to the demo.

    .venv/bin/python tools/take_client_pictures.py [NAME …]

Starts the demo, opens each protocol as its admin, and writes docs/pictures/client-<name>.png: pages
with npm's roslib, socket.io-client and @foxglove/ws-protocol, unchanged, which list what they are
told; the metrics as a browser shows them; what `talaia watch` prints; what `mosquitto_sub` prints
and pysparkplug reads of a Mosquitto that the demo's hub publishes to; cards of protocols.
"""

from __future__ import annotations

import contextlib
import functools
import html
import http.server
import os
import shutil
import socket
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path
from typing import TYPE_CHECKING

from playwright.sync_api import Browser, Page, sync_playwright
from take_pictures import FLAGS, ROOT, TARGET, running_demo, sign_in

from talaia.hub.clients.catalog import CLIENT_PROTOCOLS

if TYPE_CHECKING:
    from collections.abc import Iterator

WEB = ROOT / "web"
SITE = "agv"
PROTOCOLS = tuple(CLIENT_PROTOCOLS)
# Of which the documentation shows the card.
CARDS = ("foxglove", "mqtt")
# What the demo's hub publishes, by a token that is written once there is one.
BROKER = """\
broker: {{host: 127.0.0.1, port: {port}, tls: false}}
token_file: mqtt.token
sparkplug: {{group: plant}}
sites:
  agv: {{signals: ["sensors/*", "power/*", "base/speed"]}}
"""
# Every metric that comes, as pysparkplug reads it: births have names, later messages aliases.
SPARKPLUG = """\
import asyncio, sys, time

import aiomqtt
from pysparkplug import DBirth, DData, DataType, MessageType, Metric, NCmd, Topic

NOW_MS = round(time.time() * 1000)
REBIRTH = Metric(NOW_MS, "Node Control/Rebirth", DataType.BOOLEAN, value=True)


def show(topic, payload):
    for metric in payload.metrics:
        if not metric.name.startswith("Device Control"):
            said = metric.value
            said = round(said, 4) if isinstance(said, float) else said
            row = f"{topic.message_type.name:<6}  {topic.device_id:<12}  {metric.name:<13} {said}"
            print(row, flush=True)


async def main():
    births = {}
    async with aiomqtt.Client("127.0.0.1", int(sys.argv[1])) as client:
        await client.subscribe("spBv1.0/plant/+/talaia/+")
        asked = NCmd(NOW_MS, (REBIRTH,)).encode(include_dtypes=True)
        await client.publish(str(Topic("plant", MessageType.NCMD, "talaia")), asked, qos=1)
        async for message in client.messages:
            topic = Topic.from_str(str(message.topic))
            if topic.message_type is MessageType.DBIRTH:
                births[topic.device_id] = DBirth.decode(message.payload)
                show(topic, births[topic.device_id])
            elif topic.message_type is MessageType.DDATA and topic.device_id in births:
                show(topic, DData.decode(message.payload, birth=births[topic.device_id]))


asyncio.run(main())
"""
# A tool's own page: a table that its script fills.
PAGE = """<!doctype html><meta charset="utf-8"><title>{title}</title>
<style>
body {{ font: 15px/1.45 system-ui, sans-serif; margin: 1.5rem; background: #fff; color: #111; }}
h1 {{ font-size: 1.15rem; }} code, td {{ font-family: ui-monospace, monospace; font-size: 13px; }}
td, th {{ text-align: left; padding: 0.15rem 1.2rem 0.15rem 0; vertical-align: top; }}
td:last-child {{ max-width: 34rem; overflow-wrap: anywhere; }}
main {{ display: flex; gap: 2rem; align-items: start; }} img {{ width: 320px; }}
</style>
<h1>{title}</h1><p><code id="from"></code></p>
<main><table><thead><tr><th>{columns}</tr></thead><tbody></tbody></table></main>
<script src="library.js"></script>
<script>
const rows = new Map();
function show(name, kind, value) {{
  let row = rows.get(name);
  if (row === undefined) {{
    row = document.querySelector("tbody").insertRow();
    for (const _ of [0, 1, 2]) row.insertCell();
    rows.set(name, row);
  }}
  [name, kind, value].forEach((text, at) => (row.cells[at].textContent = text));
}}
function begin(address) {{
  document.getElementById("from").textContent = address.replace(/tal_[^&]*/, "tal_…");
  connect(address);
}}
{script}
</script>"""
ROSLIB = """
function connect(address) {
  const ros = new ROSLIB.Ros({url: address});
  ros.on("connection", () => ros.getTopics(({topics, types}) => topics.forEach((name, at) => {
    if (!name.startsWith("/talaia/") || name.endsWith("/drive") || rows.size > 17) return;
    show(name, types[at], "");
    new ROSLIB.Topic({ros, name, messageType: types[at], compression: "cbor"}).subscribe(
      (message) => show(name, types[at], message.data));
  })));
}"""
SOCKETIO = """
function connect(address) {
  const {origin, search} = new URL(address);
  const picture = document.querySelector("main").appendChild(new Image());
  io(`${origin}/sensedData${search}`).on("sensedData", ({name, magnitude}) => {
    if (rows.has(name) || rows.size < 16) show(name, "sensedData", magnitude);
  });
  io(`${origin}/server2web${search}`).on("server2web", (jpeg) => {
    picture.src = `data:image/jpeg;base64,${jpeg}`;
  });
}"""
FOXGLOVE = """
function connect(address) {
  const ws = new WebSocket(address, ["foxglove.sdk.v1"]);
  const client = new FOXGLOVE.FoxgloveClient({ws});
  const topics = new Map();
  client.on("advertise", (channels) => channels.forEach((channel) => {
    if (channel.encoding !== "json" || topics.size > 13) return;
    show(channel.topic, channel.schemaName, "");
    topics.set(client.subscribe(channel.id), channel);
  }));
  client.on("message", ({subscriptionId, data}) => {
    const {topic, schemaName} = topics.get(subscriptionId);
    const {timestamp: _, ...rest} = JSON.parse(new TextDecoder().decode(data));
    show(topic, schemaName, JSON.stringify(rest).slice(0, 110));
  });
}"""
COLUMNS = "topic<th>type<th>last message"
# By name: the title, its columns, the script, the module of npm and the name it gets; and where.
TOOLS = {
    "roslib": ("roslibjs (npm roslib)", COLUMNS, ROSLIB, "roslib/dist/RosLib.js", "ROSLIB"),
    "socketio": (
        "socket.io-client (npm)", "name<th>event<th>magnitude", SOCKETIO,
        "socket.io-client/dist/socket.io.esm.min.js", "SOCKETIO",
    ),
    "foxglove": (
        "@foxglove/ws-protocol (npm)", COLUMNS, FOXGLOVE,
        "@foxglove/ws-protocol/dist/esm/src/index.js", "FOXGLOVE",
    ),
}  # fmt: skip
PATHS = {
    "roslib": "/clients/rosbridge/agv?",
    "socketio": "/?site=agv&",
    "foxglove": "/clients/foxglove/agv?",
}


def main(wanted: list[str]) -> int:
    """Take them all, or those that are named."""
    path = shutil.which("chromium") or shutil.which("google-chrome")
    clean = {key: value for key, value in os.environ.items() if key != "LD_LIBRARY_PATH"}
    with (
        tempfile.TemporaryDirectory() as folder,
        running_broker(Path(folder)) as port,
        running_demo("--mqtt", f"{folder}/mqtt.yaml") as (address, passwords, _),
        sync_playwright() as play,
    ):
        browser = play.chromium.launch(executable_path=path, args=FLAGS, env=clean)
        page = browser.new_page(viewport={"width": 1440, "height": 900})
        sign_in(page, address, passwords["admin"], "admin")
        handler = functools.partial(QuietHandler, directory=folder)
        with http.server.ThreadingHTTPServer(("127.0.0.1", 0), handler) as server:
            threading.Thread(target=server.serve_forever, daemon=True).start()
            origin = f"http://127.0.0.1:{server.server_address[1]}"
            token = open_protocols(page, origin)
            Path(folder, "mqtt.token").write_text(token)
            for name in TOOLS:
                if not wanted or name in wanted:
                    take_tool(browser, Path(folder), name, (origin, address, token))
            server.shutdown()
        for name, picture in (("metrics", take_metrics), ("watch", take_watch)):
            if not wanted or name in wanted:
                picture(browser, address, token)
        for name, terminal in (("mqtt", take_mqtt), ("sparkplug", take_sparkplug)):
            if not wanted or name in wanted:
                terminal(browser, Path(folder), port)
        if not wanted or "cards" in wanted:
            take_cards(page, address)
        browser.close()
    return 0


class QuietHandler(http.server.SimpleHTTPRequestHandler):
    """Serves a folder and prints nothing."""

    def log_message(self, *_about: object) -> None:
        """Print nothing."""


def open_protocols(page: Page, origin: str) -> str:
    """Open the protocols to pages of an origin; give a token."""
    ends_us = round((time.time() + 3600) * 1e6)
    rights = [{"right": right, "site": "*", "device": "*"} for right in ("view", "metrics")]
    token: str = page.evaluate(
        """async ([protocols, origin, asked]) => {
          const send = async (method, path, body) => {
            const headers = {"Content-Type": "application/json"};
            const answer = await fetch(path, {method, headers, body: JSON.stringify(body)});
            if (!answer.ok) throw Error(`${path}: ${await answer.text()}`);
            return answer;
          };
          for (const name of protocols) {
            const origins = ["foxglove", "rosbridge", "socketio"].includes(name) ? [origin] : [];
            await send("PUT", `/api/client-protocols/${name}`, {open: true, origins});
          }
          return (await (await send("POST", "/api/me/tokens", asked)).json()).token;
        }""",
        [
            PROTOCOLS,
            origin,
            {"name": f"pictures {origin}"[:50], "ends_us": ends_us, "permissions": rights},
        ],
    )
    return token


def take_tool(browser: Browser, folder: Path, name: str, at: tuple[str, str, str]) -> None:
    """Take a page with a tool's own library, once it shows values."""
    origin, hub, token = at
    title, columns, script, module, known_as = TOOLS[name]
    subprocess.run(
        [
            str(WEB / "node_modules" / ".bin" / "rolldown"),
            str(WEB / "node_modules" / module), "--format=iife", f"--name={known_as}",
            "--platform=browser", f"--file={folder / 'library.js'}",
        ],
        check=True, cwd=WEB, stdout=subprocess.DEVNULL,
    )  # fmt: skip
    script = script.replace("io(`", "SOCKETIO.io(`")
    text = PAGE.format(title=title, columns=columns, script=script)
    (folder / "index.html").write_text(text)
    page = browser.new_page(viewport={"width": 1100, "height": 620})
    page.goto(origin)
    scheme = hub if name == "socketio" else hub.replace("http", "ws", 1)
    page.evaluate("(address) => begin(address)", f"{scheme}{PATHS[name]}token={token}")
    page.wait_for_function(
        "[...rows.values()].filter((row) => row.cells[2].textContent).length > 7"
    )
    if name == "socketio":
        page.wait_for_function("document.querySelector('img')?.naturalWidth > 0")
    page.wait_for_timeout(2000)
    page.screenshot(path=TARGET / f"client-{name}.png")
    page.close()


def take_metrics(browser: Browser, address: str, token: str) -> None:
    """Take the metrics as a browser shows their text."""
    context = browser.new_context(
        viewport={"width": 1100, "height": 620},
        extra_http_headers={"Authorization": f"Bearer {token}"},
    )
    page = context.new_page()
    page.goto(f"{address}/metrics?site={SITE}")
    page.wait_for_function("document.body.innerText.includes('talaia_signal_value')")
    place = "document.body.innerText.indexOf('# HELP talaia_signal_value')"
    page.evaluate(f"document.body.innerText = document.body.innerText.slice({place})")
    page.add_style_tag(content="body { white-space: pre; font: 13px/1.4 monospace }")
    page.screenshot(path=TARGET / "client-metrics.png")
    context.close()


def take_watch(browser: Browser, address: str, token: str) -> None:
    """Take what `talaia watch` prints."""
    asked = [f"{SITE}/sensors/*"]
    process = subprocess.Popen(
        [sys.executable, "-m", "talaia", "watch", *asked],
        env={**os.environ, "TALAIA_HUB": address, "TALAIA_TOKEN": token},
        stdout=subprocess.PIPE, text=True,
    )  # fmt: skip
    take_terminal(browser, "watch", f"talaia watch '{asked[0]}'", process)


def take_terminal(
    browser: Browser, name: str, command: str, process: subprocess.Popen[str], width: int = 800
) -> None:
    """Take the first lines that a program prints, below the words that started it; end it."""
    lines = [next(process.stdout or iter(())) for _ in range(26)]
    process.terminate()
    process.wait(10)
    page = browser.new_page(viewport={"width": width, "height": 540})
    page.set_content(
        "<body style='margin: 0; background: #1c1c1c; color: #ddd'>"
        "<pre style='margin: 1rem; font: 13px/1.45 monospace'>"
        f"$ {html.escape(command)}\n{html.escape(''.join(lines))}</pre>"
    )
    page.screenshot(path=TARGET / f"client-{name}.png")
    page.close()


@contextlib.contextmanager
def running_broker(folder: Path) -> Iterator[int]:
    """Run Mosquitto on loopback, and write what the hub is to publish there; give its port."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port: int = probe.getsockname()[1]
    (folder / "mqtt.yaml").write_text(BROKER.format(port=port))
    conf = folder / "mosquitto.conf"
    conf.write_text(f"listener {port} 127.0.0.1\nallow_anonymous true\n")
    program = shutil.which("mosquitto", path=f"{os.environ['PATH']}:/usr/sbin") or "mosquitto"
    broker = subprocess.Popen([program, "-c", str(conf)], stderr=subprocess.DEVNULL)
    try:
        yield port
    finally:
        broker.terminate()
        broker.wait(10)


def take_mqtt(browser: Browser, _folder: Path, port: int) -> None:
    """Take what Mosquitto's own subscriber prints."""
    words = ["mosquitto_sub", "-p", str(port), "-v", "-t", f"talaia/{SITE}/#"]
    process = subprocess.Popen(words, stdout=subprocess.PIPE, text=True)
    command = f"mosquitto_sub -h broker.example -v -t 'talaia/{SITE}/#'"
    take_terminal(browser, "mqtt", command, process, width=1100)


def take_sparkplug(browser: Browser, folder: Path, port: int) -> None:
    """Take what a host of Sparkplug B reads."""
    script = folder / "read_sparkplug.py"
    script.write_text(SPARKPLUG)
    process = subprocess.Popen(
        [sys.executable, str(script), str(port)], stdout=subprocess.PIPE, text=True
    )
    take_terminal(browser, "sparkplug", "python read_sparkplug.py   # by pysparkplug", process)


def take_cards(page: Page, address: str) -> None:
    """Take the cards of some protocols, opened."""
    # Of pages as people have them.
    open_protocols(page, "https://robots.example")
    page.set_viewport_size({"width": 900, "height": 900})
    page.goto(f"{address}/admin/clients")
    page.get_by_text("Foxglove").first.wait_for()
    page.wait_for_timeout(500)
    for name in CARDS:
        card = page.locator("t-client-protocol").filter(has_text=CLIENT_PROTOCOLS[name].title)
        card.screenshot(path=TARGET / f"client-card-{name}.png")


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
