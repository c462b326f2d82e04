"""A camera made from ONVIF's specifications (Core 5, Media and PTZ services), for what it may do.

It turns in time as a camera does, answers SOAP over HTTP, and what a test tells it to do wrong it
does: silence, faults, lies, another clock, answers of strangers. `python onvif_camera.py PORT`
serves it by hand, for a client library of others.
"""

from __future__ import annotations

import hashlib
import http.server
import re
import secrets
import threading
import time
from base64 import b64decode
from collections import Counter
from contextlib import contextmanager
from datetime import UTC, datetime
from typing import TYPE_CHECKING
from xml.etree import ElementTree as ET
from xml.sax.saxutils import escape

if TYPE_CHECKING:
    from collections.abc import Iterator

SOAP = "http://www.w3.org/2003/05/soap-envelope"
TDS = "http://www.onvif.org/ver10/device/wsdl"
TRT = "http://www.onvif.org/ver10/media/wsdl"
TPTZ = "http://www.onvif.org/ver20/ptz/wsdl"
TT = "http://www.onvif.org/ver10/schema"
AXES = ("pan", "tilt", "zoom")
# Of the fastest it goes through so much of its way (from -1 to 1) in a second.
FASTEST = 0.5
# Signatures that are dated further away are refused, as most cameras do (s).
SKEW_S = 5.0


class OnvifCamera:
    """What it is, what it was asked, and what it does wrong.

    Attributes:
        asked: how often each action was asked for.
        moves: each velocity that it was told, with its time (monotonic).
        stops: when it was told to stop.
        user: who may ask, ``name:password``; empty for everybody.
        signs: by ``wsse`` or ``digest`` (HTTP).
        clock_off: how far its clock is before ours (s).
        silent: actions that never answer while the test lasts.
        faults: by action: the subcode and words of the fault it answers with.
        answers: by action: what it answers instead, as it stands.
        obeys_stop: or moves on.
        ends_moves: whether a move ends after its own time.
        tells_moving: whether its status says that it moves.
        tells_place: whether its status says where it looks.
        address: what it says of its services; empty for where it was asked.
        goes_wrong: presets lead elsewhere.

    """

    def __init__(self) -> None:  # noqa: D107
        self.asked: Counter[str] = Counter()
        self.moves: list[tuple[float, tuple[float, float, float]]] = []
        self.stops: list[float] = []
        self.user, self.signs = "", "wsse"
        self.clock_off = 0.0
        self.silent: set[str] = set()
        self.faults: dict[str, tuple[str, str]] = {}
        self.answers: dict[str, bytes] = {}
        self.obeys_stop = self.ends_moves = self.tells_moving = self.tells_place = True
        self.address = self.stream = ""
        self.goes_wrong = False
        self.fixed = False  # Nothing of it moves.
        self.presets: dict[str, tuple[str, dict[str, float]]] = {}
        self.home: dict[str, float] | None = None
        self.released = threading.Event()
        self.log: list[str] = []
        self._place = dict.fromkeys(AXES, 0.0)
        self._speed = dict.fromkeys(AXES, 0.0)
        self._goal: dict[str, float] | None = None
        self._ends, self._at = 0.0, time.monotonic()
        self._lock = threading.RLock()
        self.nonce = secrets.token_hex(8)

    # ── how it turns ──

    def place(self) -> dict[str, float]:
        with self._lock:
            self._turn()
            return dict(self._place)

    def is_moving(self) -> bool:
        with self._lock:
            self._turn()
            return self._goal is not None or any(self._speed.values())

    def _turn(self) -> None:
        now, before = time.monotonic(), self._at
        self._at = now
        if self._goal is not None:
            step = FASTEST * (now - before)
            for axis, goal in self._goal.items():
                away = goal - self._place[axis]
                self._place[axis] += max(-step, min(step, away))
            if self._place == {**self._place, **self._goal}:
                self._goal = None
            return
        until = min(now, self._ends) if self.ends_moves else now
        for axis in AXES:
            there = self._place[axis] + self._speed[axis] * FASTEST * max(0.0, until - before)
            self._place[axis] = max(0.0 if axis == "zoom" else -1.0, min(1.0, there))
        if self.ends_moves and now >= self._ends:
            self._speed = dict.fromkeys(AXES, 0.0)

    def move(self, velocity: tuple[float, float, float], seconds: float) -> None:
        with self._lock:
            self._turn()
            self.moves.append((time.monotonic(), velocity))
            self._goal = None
            self._speed = dict(zip(AXES, velocity, strict=True))
            self._ends = time.monotonic() + seconds

    def stop(self) -> None:
        with self._lock:
            self._turn()
            self.stops.append(time.monotonic())
            if self.obeys_stop:
                self._goal, self._speed = None, dict.fromkeys(AXES, 0.0)

    def goto(self, goal: dict[str, float]) -> None:
        with self._lock:
            self._turn()
            self._speed = dict.fromkeys(AXES, 0.0)
            self._goal = {axis: -value for axis, value in goal.items()} if self.goes_wrong else goal

    # ── what it answers ──

    def answer(self, body: ET.Element, where: str) -> str:
        action = body.tag.partition("}")[2]
        own = self.address or where
        if action in self.faults:
            raise Fault(*self.faults[action])
        match action:
            case "GetSystemDateAndTime":
                now = datetime.fromtimestamp(time.time() + self.clock_off, UTC)
                return (
                    "<tds:SystemDateAndTime><tt:DateTimeType>NTP</tt:DateTimeType>"
                    "<tt:DaylightSavings>false</tt:DaylightSavings><tt:UTCDateTime>"
                    f"<tt:Time><tt:Hour>{now.hour}</tt:Hour><tt:Minute>{now.minute}</tt:Minute>"
                    f"<tt:Second>{now.second}</tt:Second></tt:Time>"
                    f"<tt:Date><tt:Year>{now.year}</tt:Year><tt:Month>{now.month}</tt:Month>"
                    f"<tt:Day>{now.day}</tt:Day></tt:Date></tt:UTCDateTime></tds:SystemDateAndTime>"
                )
            case "GetDeviceInformation":
                return (
                    "<tds:Manufacturer>Nobody</tds:Manufacturer><tds:Model>Dome 1</tds:Model>"
                    "<tds:FirmwareVersion>1</tds:FirmwareVersion>"
                    "<tds:SerialNumber>7</tds:SerialNumber><tds:HardwareId>1</tds:HardwareId>"
                )
            case "GetServices":
                services = ((TDS, "device_service"), (TRT, "media"), (TPTZ, "ptz"))
                return "".join(
                    f"<tds:Service><tds:Namespace>{space}</tds:Namespace>"
                    f"<tds:XAddr>{own}/onvif/{path}</tds:XAddr>"
                    "<tds:Version><tt:Major>2</tt:Major><tt:Minor>60</tt:Minor></tds:Version>"
                    "</tds:Service>"
                    for space, path in services
                )
            case "GetCapabilities":
                return (
                    "<tds:Capabilities>"
                    f"<tt:Device><tt:XAddr>{own}/onvif/device_service</tt:XAddr></tt:Device>"
                    f"<tt:Media><tt:XAddr>{own}/onvif/media</tt:XAddr><tt:StreamingCapabilities/>"
                    f"</tt:Media><tt:PTZ><tt:XAddr>{own}/onvif/ptz</tt:XAddr></tt:PTZ>"
                    "</tds:Capabilities>"
                )
            case "GetProfiles":
                return self._profiles()
            case "GetStreamUri" | "GetSnapshotUri":
                stream = self.stream or f"rtsp://{own.partition('//')[2].partition(':')[0]}/main"
                uri = stream if action == "GetStreamUri" else f"{own}/snapshot.jpg"
                return (
                    f"<trt:MediaUri><tt:Uri>{escape(uri)}</tt:Uri>"
                    "<tt:InvalidAfterConnect>false</tt:InvalidAfterConnect>"
                    "<tt:InvalidAfterReboot>false</tt:InvalidAfterReboot>"
                    "<tt:Timeout>PT60S</tt:Timeout></trt:MediaUri>"
                )
            case _:
                return self._answer_ptz(action, body)

    def _profiles(self) -> str:
        ptz = (
            '<tt:PTZConfiguration token="ptz"><tt:Name>PTZ</tt:Name><tt:UseCount>1</tt:UseCount>'
            "<tt:NodeToken>node</tt:NodeToken></tt:PTZConfiguration>"
        )
        return "".join(
            f'<trt:Profiles token="{token}" fixed="true"><tt:Name>{token}</tt:Name>'
            f'<tt:VideoEncoderConfiguration token="{token}"><tt:Name>{token}</tt:Name>'
            "<tt:UseCount>1</tt:UseCount><tt:Encoding>H264</tt:Encoding><tt:Resolution>"
            f"<tt:Width>{width}</tt:Width><tt:Height>{width * 3 // 4}</tt:Height></tt:Resolution>"
            "<tt:Quality>5</tt:Quality><tt:Multicast><tt:Address><tt:Type>IPv4</tt:Type>"
            "</tt:Address><tt:Port>0</tt:Port><tt:TTL>1</tt:TTL><tt:AutoStart>false</tt:AutoStart>"
            "</tt:Multicast><tt:SessionTimeout>PT60S</tt:SessionTimeout>"
            f"</tt:VideoEncoderConfiguration>{'' if self.fixed else ptz}</trt:Profiles>"
            for token, width in (("main", 640), ("sub", 320))
        )

    def _answer_ptz(self, action: str, body: ET.Element) -> str:
        token = body.findtext(f"{{{TPTZ}}}PresetToken", "")
        match action:
            case "GetNodes":
                return _NODES
            case "ContinuousMove":
                velocity = body.find(f"{{{TPTZ}}}Velocity")
                turned = velocity.find(f"{{{TT}}}PanTilt") if velocity is not None else None
                zoomed = velocity.find(f"{{{TT}}}Zoom") if velocity is not None else None
                pan, tilt = ("0", "0") if turned is None else (turned.get("x"), turned.get("y"))
                zoom = "0" if zoomed is None else zoomed.get("x")
                seconds = re.fullmatch(r"PT([\d.]+)S", body.findtext(f"{{{TPTZ}}}Timeout", "PT5S"))
                assert seconds is not None
                self.move((float(pan or 0), float(tilt or 0), float(zoom or 0)), float(seconds[1]))
            case "Stop":
                self.stop()
            case "GetStatus":
                return self._status()
            case "GetPresets":
                return "".join(
                    f'<tptz:Preset token="{escape(key)}"><tt:Name>{escape(name)}</tt:Name>'
                    f"<tt:PTZPosition>{_position(place)}</tt:PTZPosition></tptz:Preset>"
                    for key, (name, place) in self.presets.items()
                )
            case "SetPreset":
                key = token or f"p{len(self.presets) + 1}"
                name = body.findtext(f"{{{TPTZ}}}PresetName", key)
                self.presets[key] = (name, self.place())
                return f"<tptz:PresetToken>{escape(key)}</tptz:PresetToken>"
            case "GotoPreset" | "RemovePreset":
                if token not in self.presets:
                    raise Fault("NoToken", "The requested preset token does not exist.")
                if action == "GotoPreset":
                    self.goto(self.presets[token][1])
                else:
                    del self.presets[token]
            case "SetHomePosition":
                self.home = self.place()
            case "GotoHomePosition":
                if self.home is None:
                    raise Fault("NoHomePosition", "No home position has been defined.")
                self.goto(self.home)
            case _:
                raise Fault("ActionNotSupported", "Optional Action Not Implemented")
        return ""

    def _status(self) -> str:
        place = f"<tt:Position>{_position(self.place())}</tt:Position>" if self.tells_place else ""
        word = "MOVING" if self.is_moving() else "IDLE"
        moves = (
            f"<tt:MoveStatus><tt:PanTilt>{word}</tt:PanTilt><tt:Zoom>{word}</tt:Zoom>"
            "</tt:MoveStatus>"
        )
        now = datetime.now(UTC).strftime("%Y-%m-%dT%H:%M:%SZ")
        said = moves if self.tells_moving else ""
        return f"<tptz:PTZStatus>{place}{said}<tt:UtcTime>{now}</tt:UtcTime></tptz:PTZStatus>"

    # ── who asks ──

    def lets_in(self, envelope: ET.Element, authorization: str, path: str) -> bool:
        if not self.user:
            return True
        name, password = self.user.split(":")
        if self.signs == "digest":
            return self._knows_digest(authorization, name, password, path)
        found = {element.tag.rpartition("}")[2]: element.text or "" for element in envelope.iter()}
        created = found.get("Created", "1970-01-01T00:00:00Z")
        at = datetime.fromisoformat(created.replace("Z", "+00:00")).timestamp()
        nonce = b64decode(found.get("Nonce", ""))
        wanted = hashlib.sha1(
            nonce + created.encode() + password.encode(), usedforsecurity=False
        ).digest()
        fresh = abs(at - time.time() - self.clock_off) <= SKEW_S
        return (
            fresh
            and found.get("Username") == name
            and b64decode(found.get("Password", "")) == wanted
        )

    def _knows_digest(self, said: str, name: str, password: str, path: str) -> bool:
        words = dict(re.findall(r'(\w+)="?([^",]*)"?', said.removeprefix("Digest ")))
        if words.get("nonce") != self.nonce or words.get("uri") != path:
            return False

        def hashed(text: str) -> str:
            return hashlib.md5(text.encode(), usedforsecurity=False).hexdigest()

        who, what = hashed(f"{name}:camera:{password}"), hashed(f"POST:{path}")
        middle = f"{self.nonce}:{words['nc']}:{words['cnonce']}:auth"
        return words["response"] == hashed(f"{who}:{middle}:{what}")


class Fault(Exception):
    """What it answers instead."""

    def __init__(self, code: str, words: str) -> None:  # noqa: D107
        super().__init__(words)
        self.code = code


def _position(place: dict[str, float]) -> str:
    return (
        f'<tt:PanTilt x="{place["pan"]:.4f}" y="{place["tilt"]:.4f}" '
        'space="http://www.onvif.org/ver10/tptz/PanTiltSpaces/PositionGenericSpace"/>'
        f'<tt:Zoom x="{place["zoom"]:.4f}" '
        'space="http://www.onvif.org/ver10/tptz/ZoomSpaces/PositionGenericSpace"/>'
    )


def _range(name: str, axes: tuple[str, ...], space: str) -> str:
    ranges = "".join(
        f"<tt:{axis}><tt:Min>-1</tt:Min><tt:Max>1</tt:Max></tt:{axis}>" for axis in axes
    )
    uri = f"http://www.onvif.org/ver10/tptz/{space}"
    return f"<tt:{name}><tt:URI>{uri}</tt:URI>{ranges}</tt:{name}>"


_NODES = (
    '<tptz:PTZNode token="node" FixedHomePosition="false"><tt:Name>Node</tt:Name>'
    "<tt:SupportedPTZSpaces>"
    + _range(
        "ContinuousPanTiltVelocitySpace",
        ("XRange", "YRange"),
        "PanTiltSpaces/VelocityGenericSpace",
    )
    + _range("ContinuousZoomVelocitySpace", ("XRange",), "ZoomSpaces/VelocityGenericSpace")
    + "</tt:SupportedPTZSpaces><tt:MaximumNumberOfPresets>16</tt:MaximumNumberOfPresets>"
    "<tt:HomeSupported>true</tt:HomeSupported></tptz:PTZNode>"
)


def envelope(inside: str) -> bytes:
    return (
        f'<?xml version="1.0" encoding="utf-8"?><env:Envelope xmlns:env="{SOAP}" '
        f'xmlns:tds="{TDS}" xmlns:trt="{TRT}" xmlns:tptz="{TPTZ}" xmlns:tt="{TT}" '
        f'xmlns:ter="http://www.onvif.org/ver10/error"><env:Body>{inside}</env:Body></env:Envelope>'
    ).encode()


def fault(code: str, words: str) -> bytes:
    return envelope(
        "<env:Fault><env:Code><env:Value>env:Sender</env:Value><env:Subcode>"
        f"<env:Value>ter:InvalidArgVal</env:Value><env:Subcode><env:Value>ter:{code}</env:Value>"
        "</env:Subcode></env:Subcode></env:Code><env:Reason>"
        f'<env:Text xml:lang="en">{escape(words)}</env:Text></env:Reason></env:Fault>'
    )


def _handler(camera: OnvifCamera) -> type[http.server.BaseHTTPRequestHandler]:
    class Handler(http.server.BaseHTTPRequestHandler):
        protocol_version = "HTTP/1.1"

        def do_POST(self) -> None:
            sent = self.rfile.read(int(self.headers["Content-Length"]))
            read = ET.fromstring(sent)  # noqa: S314 - it is the gateway's own
            body = read.find(f"{{{SOAP}}}Body")
            assert body is not None
            action = body[0].tag.rpartition("}")[2]
            camera.asked[action] += 1
            if action in camera.silent:
                camera.released.wait()
                return
            if action in camera.answers:
                self.send(200, camera.answers[action])
                return
            public = action == "GetSystemDateAndTime"
            said = self.headers.get("Authorization", "")
            camera.log.append(f"{action} {said or ET.tostring(read).decode()}")
            if not public and not camera.lets_in(read, said, self.path):
                self.refuse_stranger()
                return
            where = f"http://{self.headers['Host']}"
            prefix = {TDS: "tds", TRT: "trt", TPTZ: "tptz"}[body[0].tag[1:].partition("}")[0]]
            try:
                inside = camera.answer(body[0], where)
            except Fault as error:
                self.send(400, fault(error.code, str(error)))
                return
            name = f"{prefix}:{action}Response"
            self.send(200, envelope(f"<{name}>{inside}</{name}>"))

        def refuse_stranger(self) -> None:
            if camera.signs == "digest":
                self.send(401, b"", f'Digest realm="camera", qop="auth", nonce="{camera.nonce}"')
            elif camera.signs == "basic":
                self.send(401, b"", 'Basic realm="camera"')
            else:
                self.send(400, fault("NotAuthorized", "Sender not Authorized"))

        def send(self, status: int, data: bytes, challenge: str = "") -> None:
            self.send_response(status)
            if challenge:
                self.send_header("WWW-Authenticate", challenge)
            self.send_header("Content-Type", "application/soap+xml; charset=utf-8")
            self.send_header("Content-Length", str(len(data)))
            self.end_headers()
            self.wfile.write(data)

        def log_message(self, *_: object) -> None:
            pass

    return Handler


@contextmanager
def serving_camera(
    camera: OnvifCamera | None = None, port: int = 0
) -> Iterator[tuple[int, OnvifCamera]]:
    """Serve; give the port and what is served."""
    camera = camera or OnvifCamera()
    with http.server.ThreadingHTTPServer(("127.0.0.1", port), _handler(camera)) as server:
        server.daemon_threads = True
        thread = threading.Thread(target=server.serve_forever, kwargs={"poll_interval": 0.01})
        thread.start()
        try:
            yield server.server_address[1], camera
        finally:
            camera.released.set()
            server.shutdown()
            thread.join()


if __name__ == "__main__":
    import sys

    with serving_camera(port=int(sys.argv[1])) as (_, served):
        served.presets = {"1": ("Gate", {"pan": 0.5, "tilt": 0.1, "zoom": 0.0})}
        threading.Event().wait()
