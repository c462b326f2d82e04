"""The vehicle as a process, seen through real ROS 2."""

from __future__ import annotations

import json
import selectors
import signal
import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pytest
from patience import PATIENCE_S
from priority import let_children_run
from tests.sim.conftest import Peer, Vehicle, missing, start_vehicle

from talaia.model.detection import DetectionSource
from talaia.model.yaml_text.load import read_site
from talaia.sim.ros_domain import reserve_domain

if TYPE_CHECKING:
    from collections.abc import Iterator

pytestmark = pytest.mark.robot

SITE = Path(__file__).parents[3] / "examples" / "agv" / "site.yaml"


@pytest.fixture(scope="module")
def vehicle(domain: int, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Vehicle]:
    running = start_vehicle(tmp_path_factory.mktemp("vehicle") / "log.jsonl", domain)
    yield running
    assert running.end() == 0


def message(kind: str) -> Any:
    package, _, name = kind.split("/")
    return getattr(__import__(f"{package}.msg", fromlist=[name]), name)


class Drive:
    """Publishes velocities at 20 Hz until told otherwise."""

    def __init__(self, peer: Peer) -> None:
        """Wait until the vehicle listens."""
        self.peer = peer
        self.kind = message("geometry_msgs/msg/Twist")
        self.publisher = peer.node.create_publisher(self.kind, "/cmd_vel", 10)
        assert peer.until(self.publisher.get_subscription_count)

    def send(self, speed: float, turn: float = 0.0) -> None:
        twist = self.kind()
        twist.linear.x, twist.angular.z = speed, turn
        self.publisher.publish(twist)

    def hold(self, speed: float, turn: float, seconds: float) -> None:
        for _ in range(round(seconds * 20)):
            self.send(speed, turn)
            self.peer.until(lambda: False, 0.05)


def test_it_is_the_process_that_was_started_and_says_where_it_is(
    vehicle: Vehicle, domain: int
) -> None:
    assert vehicle.ready["ready"] is True
    assert vehicle.ready["domain"] == domain
    assert vehicle.ready["pid"] == vehicle.process.pid


def test_a_command_moves_it_and_half_a_second_after_the_last_it_stands(
    vehicle: Vehicle, peer: Peer
) -> None:
    odometry = peer.collect(message("nav_msgs/msg/Odometry"), "/odom")
    drive = Drive(peer)
    assert peer.until(lambda: odometry)
    start = odometry[-1].pose.pose.position.x
    before = len(vehicle.actuations())
    for step in range(20):
        # Each differs a little, so that the log has the moment of the last.
        drive.send(-0.1 - 0.001 * step)
        peer.until(lambda: False, 0.05)
    assert odometry[-1].twist.twist.linear.x < -0.09
    assert peer.until(lambda: odometry[-1].twist.twist.linear.x == pytest.approx(0, abs=0.001))
    assert odometry[-1].pose.pose.position.x < start - 0.05
    entries = vehicle.actuations()[before:]
    *_, last, stopped = entries
    assert [last["source"], stopped["source"]] == ["cmd_vel", "timeout"]
    assert last["v"] == pytest.approx(-0.119)
    assert 0.40e9 < stopped["monotonic_ns"] - last["monotonic_ns"] < 0.5e9


def test_a_key_moves_it(vehicle: Vehicle, peer: Peer) -> None:
    odometry = peer.collect(message("nav_msgs/msg/Odometry"), "/odom")
    text = message("std_msgs/msg/String")
    keys = peer.node.create_publisher(text, "/control", 10)
    assert peer.until(keys.get_subscription_count)
    assert peer.until(lambda: odometry)
    keys.publish(text(data="a"))
    assert peer.until(lambda: odometry[-1].twist.twist.angular.z > 0.5)
    keys.publish(text(data="s"))
    assert peer.until(lambda: abs(odometry[-1].twist.twist.angular.z) < 0.01)


def test_stop_holds_it_until_it_is_released(vehicle: Vehicle, peer: Peer) -> None:
    odometry = peer.collect(message("nav_msgs/msg/Odometry"), "/odom")
    wandering = peer.collect(message("std_msgs/msg/Bool"), "/wandering")
    health = peer.collect(message("diagnostic_msgs/msg/DiagnosticArray"), "/diagnostics")
    bool_kind = message("std_msgs/msg/Bool")
    stop = peer.node.create_publisher(bool_kind, "/stop", 10)
    drive = Drive(peer)
    assert peer.until(stop.get_subscription_count)
    assert ask_to_wander(peer, on=True).success
    assert peer.until(lambda: wandering and wandering[-1].data)
    stop.publish(bool_kind(data=True))
    assert peer.until(lambda: not wandering[-1].data)
    assert peer.until(lambda: health and levels_in(health[-1])["base: STOP"] == b"\x01")
    assert levels_in(health[-1])["battery: cells"] == b"\x00"
    refused = ask_to_wander(peer, on=True)
    assert not refused.success
    assert "STOP" in refused.message
    count = len(odometry)
    drive.hold(0.0, 1.0, 0.5)
    assert all(abs(m.twist.twist.angular.z) < 0.02 for m in odometry[count + 10 :])
    stop.publish(bool_kind(data=False))
    drive.hold(0.0, 1.0, 0.5)
    assert peer.until(lambda: odometry[-1].twist.twist.angular.z > 0.5, 2.0)


def test_a_command_ends_wandering_and_it_says_so(vehicle: Vehicle, peer: Peer) -> None:
    wandering = peer.collect(message("std_msgs/msg/Bool"), "/wandering")
    drive = Drive(peer)
    assert ask_to_wander(peer, on=True).success
    assert peer.until(lambda: wandering and wandering[-1].data)
    drive.send(0.0)
    assert peer.until(lambda: not wandering[-1].data, 2.0)


def levels_in(health: Any) -> dict[str, bytes]:
    return {status.name: status.level for status in health.status}


def ask_to_wander(peer: Peer, *, on: bool) -> Any:
    from std_srvs.srv import SetBool

    client = peer.node.create_client(SetBool, "/wander")
    assert peer.until(client.service_is_ready)
    future = client.call_async(SetBool.Request(data=on))
    assert peer.until(future.done)
    answer = future.result()
    peer.node.destroy_client(client)
    return answer


def test_pictures_arrive_and_show_something(vehicle: Vehicle, peer: Peer) -> None:
    if not vehicle.ready["camera"]:
        missing("the vehicle has no camera here")
    pictures = peer.collect(message("sensor_msgs/msg/Image"), "/images", 1)
    lenses = peer.collect(message("sensor_msgs/msg/CameraInfo"), "/camera_info", 1)

    def came() -> bool:
        # What draws gives way to everything else on the machine.
        let_children_run(vehicle.process.pid)
        return len(pictures) >= 10 and bool(lenses)

    assert peer.until(came)
    newest = pictures[-1]
    assert (newest.width, newest.height, newest.encoding) == (640, 480, "rgb8")
    pixels = np.frombuffer(newest.data, dtype=np.uint8).reshape(480, 640, 3)
    assert pixels.std() > 20
    stamps = [m.header.stamp.sec + m.header.stamp.nanosec * 1e-9 for m in pictures]
    assert abs(time.time() - stamps[-1]) < 1.0
    assert stamps == sorted(stamps)
    assert lenses[-1].k[2] == 320.0


def field(value: Any, path: str) -> Any:
    for part in path.split(".") if path else ():
        value = getattr(value, part)
    return value


def test_everything_the_example_description_names_is_served(vehicle: Vehicle, peer: Peer) -> None:
    site = read_site(SITE)
    heard: dict[str, list[Any]] = {}
    wanted = []
    for device in site.devices.values():
        for part in (*device.signals.values(), *device.streams.values()):
            source = part.source
            if isinstance(source, DetectionSource):
                # What is counted on pictures is the gateway's to make.
                continue
            if source.topic not in heard:
                heard[source.topic] = peer.collect(message(source.type), source.topic)
            wanted.append(source)
    for source in wanted:
        messages = heard[source.topic]
        assert peer.until(lambda messages=messages: messages), source
        assert field(messages[-1], source.field) is not None
        if source.name:
            texts = [f"'name': '{source.name}'"]
            assert peer.until(lambda t=texts, m=messages: any(t[0] in one.data for one in m)), (
                source
            )
    for device in site.devices.values():
        for command in device.commands.values():
            assert peer.until(
                lambda c=command: c.target in dict(peer.node.get_service_names_and_types())
            )
        if device.drive:
            for topic in (device.drive.topic, device.drive.stop.topic):
                assert peer.until(lambda t=topic: peer.node.count_subscribers(t)), topic


def test_odometry_comes_often_and_in_time(vehicle: Vehicle, peer: Peer) -> None:
    odometry = peer.collect(message("nav_msgs/msg/Odometry"), "/odom", 50)
    assert peer.until(lambda: len(odometry) >= 100)
    stamps = [m.header.stamp.sec + m.header.stamp.nanosec * 1e-9 for m in odometry]
    rate = (len(stamps) - 1) / (stamps[-1] - stamps[0])
    assert 25 <= rate <= 55


def test_another_domain_hears_nothing(vehicle: Vehicle, peer: Peer) -> None:
    kind = message("nav_msgs/msg/Odometry")
    with reserve_domain() as elsewhere:
        stranger = Peer(elsewhere.domain)
        own = message("std_msgs/msg/Bool")
        fence = stranger.collect(own, "/fence")
        foreign = stranger.collect(kind, "/odom")
        publisher = stranger.node.create_publisher(own, "/fence", 10)
        assert stranger.until(publisher.get_subscription_count)
        here = peer.collect(kind, "/odom")
        assert peer.until(lambda: len(here) > 50)
        publisher.publish(own(data=True))
        assert stranger.until(lambda: fence)
        assert not foreign
        assert "vehicle" not in stranger.node.get_node_names()
        assert "vehicle" in peer.node.get_node_names()
        stranger.close()


def test_it_listens_on_this_machine_only(vehicle: Vehicle, domain: int) -> None:
    psutil = pytest.importorskip("psutil")
    ports = range(7400 + 250 * domain, 7400 + 250 * (domain + 1))
    sockets = psutil.Process(vehicle.process.pid).net_connections("udp")
    of_domain = [s.laddr for s in sockets if s.laddr.port in ports]
    assert of_domain
    assert {address.ip for address in of_domain} == {"127.0.0.1"}


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_it_cleanly_and_soon(ros: None, tmp_path: Path, number: int) -> None:
    with reserve_domain() as reservation:
        running = start_vehicle(tmp_path / "log.jsonl", reservation.domain, "--no-camera")
        assert running.ready["camera"] is None
        before = time.monotonic()
        assert running.end(number) == 0
        assert time.monotonic() - before < 8.0


def test_wandering_from_the_start_moves_it_and_is_written_down(ros: None, tmp_path: Path) -> None:
    with reserve_domain() as reservation:
        running = start_vehicle(
            tmp_path / "log.jsonl", reservation.domain, "--no-camera", "--wander"
        )
        try:
            assert first_line(running.log)["source"] == "wander"
        finally:
            assert running.end() == 0


def first_line(log: Path) -> Any:
    """Follow a file until its first line is complete."""
    with log.open() as lines, selectors.DefaultSelector() as pause:
        deadline = time.monotonic() + PATIENCE_S
        text = ""
        while not text.endswith("\n"):
            assert time.monotonic() < deadline, "nothing was written down"
            text += lines.readline()
            pause.select(0.02)
        return json.loads(text)
