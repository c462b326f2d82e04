"""Where the hub's messages are acted on."""

from __future__ import annotations

import asyncio
import logging
from typing import TYPE_CHECKING

from talaia.model.recording import Trigger
from talaia.wire.frames import (
    Ack,
    AssetRequest,
    ChangeRequest,
    CommandCancel,
    CommandPhase,
    CommandRequest,
    DriveFrame,
    EnclosureState,
    KeyframeRequest,
    LeaseForceRequest,
    LeaseRequest,
    NightArmRequest,
    NightDisarmRequest,
    NightPhase,
    NightState,
    ObservationAck,
    OverrideRequest,
    ReconnectRequest,
    RecordingRequest,
    ReleaseOffer,
    ReleaseState,
    RequestSync,
    ResendRequest,
    ResetRequest,
    RobotLogAck,
    RobotLogBatch,
    SightingReport,
    SignalSubscription,
    StopRequest,
    StreamSubscription,
    TapSubscription,
    TopicList,
    TwinFrame,
    TwinRequest,
)

if TYPE_CHECKING:
    from talaia.gateway.actuation import Actuation
    from talaia.gateway.adapters.connectivity import DeviceReachability
    from talaia.gateway.assets.asset_service import AssetService
    from talaia.gateway.detection.sighting_reports import DetectionReporter
    from talaia.gateway.night.night_service import NightService
    from talaia.gateway.ports import Adapter, CommandOutcome, EventSink
    from talaia.gateway.recording.recorders import TriggeredRecorder
    from talaia.gateway.reload.requests import ChangeRequests
    from talaia.gateway.robot_log.log_reporter import LogReporter
    from talaia.gateway.samples.signal_watch import SignalWatch
    from talaia.gateway.spool.spool_thread import SpoolThread
    from talaia.gateway.taps.service import TapService
    from talaia.gateway.uplink.output_router import OutputRouter
    from talaia.gateway.uplink.pictures import PictureUplink
    from talaia.gateway.uplink.releases import OfferedReleases
    from talaia.gateway.uplink.send_lanes import SendLanes
    from talaia.wire.frames import FromHub, Welcome

__all__ = ["MessageDispatcher"]

log = logging.getLogger(__name__)
# What a hub that goes by the night takes.
_NIGHT = NightState.__struct_config__.tag


class MessageDispatcher:
    """A `HubMessageHandler`: gives each message to whom it concerns."""

    def __init__(
        self,
        *,
        boot: str,
        actuation: Actuation,
        spool: SpoolThread,
        adapter: Adapter,
        output: OutputRouter,
        events: EventSink,
        lanes: SendLanes,
        reachability: DeviceReachability,
        recorders: TriggeredRecorder | None,
        change_requests: ChangeRequests,
        pictures: PictureUplink,
        taps: TapService,
        assets: AssetService,
        watch: SignalWatch,
        reporter: DetectionReporter,
        releases: OfferedReleases,
        robot_log: LogReporter,
        night: NightService | None = None,
    ) -> None:
        """Take all who act, the output that tells how it went, and the lanes to the hub."""
        self._night = night  # None where the site does not observe by itself.
        self._pictures = pictures  # The media connection: what is watched, and key pictures.
        self._taps = taps  # Raw topics, on the media connection, too.
        self._assets = assets  # Files that the robot's description names.
        self._watch = watch  # Signals that somebody looks at.
        self._reporter = reporter  # Sightings on their way to the hub.
        self._releases = releases  # Of this gateway's own software, which the hub offers.
        self._robot_log = robot_log  # So are lines of the robot's log.
        self._reachability = reachability  # Which devices can be reached.
        self._recorders = recorders  # None where the description records nothing.
        # Changes of the description that a person asked for.
        self._change_requests = change_requests
        self._output = output  # Told which messages this hub takes.
        self._events = events  # Where refusals are recorded.
        self._lanes = lanes  # Out to the hub.
        self._boot = boot  # Names this run in acknowledgements.
        self._control = actuation.driving  # Driving, leases and STOP.
        self._twins = actuation.twins  # What is driven in digital twins.
        # The timer that must be set anew after anything that may have changed what is due.
        self._pacer = actuation.timer
        self._commanding = actuation.commands  # One-shot commands.
        self._spool = spool  # Samples until the hub has them.
        self._adapter = adapter  # The robot's side.
        self._requests = actuation.requests  # Tasks of requests that wait for a disk or a robot.
        self.linked = asyncio.Event()  # Set while a link stands; files and pictures wait for it.
        self.links = 0  # Counts links, so that a task can tell whether "its" link still stands.

    def link_up(self, welcome: Welcome) -> None:
        """Trim what the hub has, and tell it how things stand."""
        self.linked.set()
        self.links += 1
        # First, for it compares with what the hub had told before.
        self._spool.rewind_acknowledged(welcome.acked)
        if self._recorders is not None:
            self._lanes.send(self._recorders.recorder_state())
        self._spool.acknowledge_samples(self._boot, welcome.acked)
        # Asked at each link: the next one may be a hub of another version.
        self._output.takes_enclosures = EnclosureState.__struct_config__.tag in welcome.takes
        # STOP and leases first, then commands and devices: a page must see a stopped robot as
        # stopped.
        self._control.link_up()
        self._twins.link_up()
        self._commanding.report_states()
        self._reachability.report_unreached()
        self._change_requests.link_up()
        self._taps.link_up(takes=TopicList.__struct_config__.tag in welcome.takes)
        self._reporter.link_up(takes=SightingReport.__struct_config__.tag in welcome.takes)
        self._releases.link_up(takes=ReleaseState.__struct_config__.tag in welcome.takes)
        self._robot_log.link_up(takes=RobotLogBatch.__struct_config__.tag in welcome.takes)
        if self._night is not None:
            self._night.link_up(takes=_NIGHT in welcome.takes)
        self._pacer.reset_timer()

    def link_lost(self) -> None:
        """End leases and holds; nobody looks at pictures any more."""
        # Only a link that stood can be lost; `link_lost` also comes after a dial in vain.
        if self.linked.is_set() and self._recorders is not None:
            self._recorders.trigger_recording(Trigger.LINK_LOST, "the link to the hub was lost")
        self.linked.clear()
        # Before anything else of this list could take time.
        self._twins.link_lost()
        self._control.link_lost()
        self._reporter.link_lost()
        self._robot_log.link_lost()
        self._pacer.reset_timer()
        self._taps.link_lost()
        self._assets.link_lost()
        self._watch.link_lost()
        self._pictures.watch((), {})
        self.update_watched_streams()

    def update_watched_streams(self) -> None:
        """Have the cameras read that somebody looks at, here or at the hub."""
        self._adapter.watch(self._pictures.watched())

    def handle(self, message: FromHub) -> None:
        """Act on one message. STOP and driving are done when this returns."""
        match message:
            # Not matched by importance: each case is one dictionary lookup, and none of them waits.
            case Ack():
                self._spool.acknowledge_samples(message.boot, message.below)
                self._lanes.acks += 1
                return
            case ResendRequest():
                self._lanes.owe(message.boot, message.first, message.below)
                return
            case DriveFrame():
                self._control.handle_frame(message)
            case TwinFrame():
                self._twins.handle_frame(message)
            case TwinRequest():
                self._twins.handle_request(message)
            case StopRequest():
                latched = self._control.stop_device(message)
                # After the robot: STOP never waits for a twin, nor goes through it.
                self._twins.stop_device(message.device)
                if latched is not None:
                    # Stopped already; only its writing to disk is a task.
                    self._requests.spawn_task(self._control.keep_stop(message.device, latched))
            case LeaseRequest() | LeaseForceRequest():
                self._control.handle_lease(message)
            case ResetRequest():
                self._requests.spawn_task(self._control.reset_stop(message))
            case CommandRequest():
                self._requests.spawn_task(self._commanding.handle_request(message))
            case ChangeRequest():
                self._requests.spawn_task(self._change_requests.handle_request(message))
            case CommandCancel():
                self._commanding.cancel_command(message)
            case OverrideRequest():
                self._control.override_interlock(message)
                # `override` judges by itself; nothing of driving changes what is due.
                return
            case StreamSubscription():
                self._pictures.watch(
                    message.streams, message.forms, message.boxes, overlays=message.overlays
                )
                self.update_watched_streams()
            case KeyframeRequest():
                self._pictures.ask_key(message.stream, message.form)
            case TapSubscription():
                self._taps.subscribe(message)
                # Nothing of driving changes by it.
                return
            case AssetRequest():
                self._assets.handle_request(message)
                return
            case SignalSubscription():
                self._watch.subscribe(message)
                return
            case RobotLogAck():
                self._robot_log.handle_ack(message)
                return
            case ReconnectRequest():
                self._reconnect(message)
            case RecordingRequest():
                self._record(message)
            case ReleaseOffer():
                self._releases.handle_offer(message)
                return
            case NightArmRequest() | NightDisarmRequest() | RequestSync() | ObservationAck():
                if self._night is not None:
                    self._night.handle_message(message)
                elif isinstance(message, NightArmRequest | NightDisarmRequest):
                    self._lanes.send(_no_night(message))
                # Nothing of driving changes by it.
                return
            case _:
                log.debug("nothing to do for %s", type(message).__name__)
        # What was done may have changed what is due next.
        self._pacer.reset_timer()

    def _reconnect(self, asked: ReconnectRequest) -> None:
        def done(outcome: CommandOutcome) -> None:
            good = outcome.phase is CommandPhase.SUCCEEDED
            kind = "device reconnected" if good else "device not reconnected"
            self._events.report_event(
                kind, outcome.message, device=asked.device, who=asked.who, good=good
            )

        self._adapter.reconnect(asked.device, done)

    def _record(self, asked: RecordingRequest) -> None:
        if self._recorders is None:
            why = "the description says nothing of recording"
            self._events.report_event("recording_refused", why, who=asked.who)
        elif asked.alarm:
            self._recorders.trigger_recording(Trigger.ALARM, asked.why, asked.who)
        elif asked.stream and self._recorders.films is None:
            why = "this gateway cannot film cameras; install talaia[camera] there"
            self._events.report_event("recording_refused", why, who=asked.who)
        elif asked.on:
            self._recorders.begin_recording(asked.who, asked.why, asked.stream)
        else:
            self._recorders.end_recording(asked.who, asked.stream)


def _no_night(asked: NightArmRequest | NightDisarmRequest) -> NightState:
    why = "the site's description says nothing of a night (night:)"
    return NightState(phase=NightPhase.DISARMED, answer_to=asked.id, refused=why)
