"""What the messages' fields mean, where a field of one name means the same everywhere."""

from __future__ import annotations

import msgspec
from msgspec import inspect

__all__ = ["CHANNELS", "CLOSE_CODES", "GLOSSARY", "limits", "meaning"]

GLOSSARY = {
    "block_s": "block time that it is charged, so far (s)",
    "cause": "of a suspension",
    "files": "names of its FITS files since the last update",
    "frames_done": "frames that were read out and kept",
    "frames": "frames of the request in all",
    "groups": "request groups with a request that is pending",
    "instrument": "how long the telescope takes for what stands between exposures",
    "number": "rises by one with each update, over restarts of the gateway",
    "piece": "which piece of the set this is, from 0",
    "pieces": "so many pieces make the set",
    "plan": "the plan that the executor goes by",
    "proposals": "proposals that pay for the groups",
    "request": "the id of the request; empty: none",
    "revision": "rises with each change of what is asked",
    "since": "since when (s since the epoch, UTC)",
    "state": "where the observation stands now",
    "step": "the step of the block, in words",
    "site_time": "what time it is at a simulated site that lives faster (s, UTC); 0: as here",
    "speed": "so many times as fast it lives while its night is armed; 0: as everybody",
    "time": "of the change (s since the epoch, UTC)",
    "until": "it disarms itself then (s since the epoch, UTC); 0: until somebody disarms it",
    "why_not": "why the requests that are not in the plan are not observed now",
    "armed_by": "who let the night run by itself; empty: nobody",
    "armed_until": "it disarms itself then (s since the epoch, UTC); 0: never, or not armed",
    "answer_to": "the id of the request to arm or disarm that this answers",
    "accepts": "changes that the gateway takes from the hub: `no`, `readings` or `all`",
    "base": "SHA-256 of the text that it was made from, in hex",
    "boxes": "cameras (`device/stream`) whose boxes are wanted, too",
    "bottom": "lower edge, as a part of the picture's height from above (0 to 1)",
    "camera": "the camera, as `device/stream`",
    "confidence": "of the surest one so far (0 to 1)",
    "ended_us": "when it was seen last (µs since the epoch, UTC); 0: it is in sight",
    "began_us": "when it was seen first (µs since the epoch, UTC)",
    "label": "what it is, as the detector names it",
    "left": "left edge, as a part of the picture's width (0 to 1)",
    "many": "how many at once, at the most so far",
    "right": "right edge, as a part of the picture's width (0 to 1)",
    "score": "how sure the detector is (0 to 1)",
    "takes": "messages that this hub takes, and older ones do not: `seen`",
    "things": "what is seen on it, the surest first",
    "thumbnail": "JPEG of a moment of it; empty where there is none",
    "top": "upper edge, as a part of the picture's height from above (0 to 1)",
    "description": "the site description (YAML), the gateway's own copy",
    "problem": "what does not fit",
    "problems": "what does not fit in the description",
    "remedy": "what to do about it; empty where nobody knows",
    "renamed": "former address of a channel to its new one",
    "seal": "HMAC-SHA256 of the change under the SHA-256 of the gateway's key, in hex",
    "source": "the description's text as a person wrote it, deflated (zlib)",
    "where": "the path of the part (`$.devices.base.name`), or a line",
    "acked_by": "who acknowledged it; empty while nobody has",
    "acked_us": "when (µs since the epoch, UTC); 0: not yet",
    "advice": "what to do",
    "alarm": "the alarm's short name",
    "again": "what came did not follow on; send from `below` on",
    "digest": "SHA-256 of the whole, in hex",
    "done": "the whole is there and kept",
    "file": "the gateway's own name for it, never used twice (32 hex digits)",
    "size": "of the whole (bytes)",
    "accepted": "driving frames taken since the lease began",
    "about": "the tag of the message this answers",
    "acked": "one past the last sequence number of this run that is stored",
    "addresses": "the channel list of this batch; empty means the hello's",
    "age_ms": "age of each sample by the hub's clock (ms)",
    "angular": "turning, counter-clockwise (rad/s)",
    "args": "argument name to value; types and limits are those of the description",
    "assigned": "who sees to it; empty: nobody",
    "asked": "the session that this answers; empty when it answers nobody",
    "at_ms": "the page's own clock (ms), handed back as it is",
    "base_us": "what the offsets count from (µs since the epoch, UTC)",
    "below": "one past the last sequence number meant",
    "at": "where in the file the bytes begin",
    "begin_us": "time of the first message (µs since the epoch, UTC)",
    "boot": "names the run of the gateway",
    "cap": "part of the greatest speed that is allowed now (0 to 1)",
    "catalogue": "names the channel list",
    "channel": "per sample: index into the channel list (u16, little-endian)",
    "channels": "addresses, as `device/signal` or `device/signal/part`",
    "check": "CRC-32 of `data`",
    "cleared_us": "when it was over (µs since the epoch, UTC); 0: it is not",
    "code": "what kind of problem, for programs",
    "command": "the command's short name",
    "confirmed": "the robot itself stands still",
    "data": "the encoded picture",
    "device": "the device's short name; empty where none is meant",
    "end_us": "time of the last message (µs since the epoch, UTC)",
    "epoch": "the lease's number, which rises with every grant; 0 is none",
    "every_ms": "at most every so many ms; 0 as they come",
    "first": "sequence number of the first sample meant",
    "format": "how the picture is encoded",
    "form": "size and encoding: `h264`, `h264_small`, `jpeg`, `jpeg_small`, `still`",
    "codec": "of H.264: profile and level as WebCodecs names them; with a key picture only",
    "key": "needs no picture before it",
    "small": "smaller than the camera's own, since the connection is slow",
    "still": "a picture a second will do",
    "from_us": "earliest time (µs since the epoch, UTC)",
    "enclosure": "the enclosure's short name",
    "interlock": "the interlock's short name",
    "overridden_by": "who overrides it; empty while nobody does",
    "reached": "the gateway hears it and can tell it something",
    "rival_who": "that person's name",
    "undelivered": "why a message of it did not reach somebody; empty where none failed",
    "unknown_why": "why it cannot be judged; empty where it can",
    "units": "argument name to the unit it was shown with; empty where none was",
    "over": "the id of somebody else's command that is under way and that it may interrupt",
    "blocked_by": "refused because of this command (its id) of somebody else; see `over`",
    "seconds": "for how long (s); 0 ends it",
    "gone": "there is no such alarm any more",
    "good": "false where somebody should look",
    "height": "rows of the picture",
    "held_ms": "how long ago the page saw that tick, by its own clock (ms)",
    "holder": "who holds the lease; empty while nobody does",
    "hub_us": "the hub's monotonic clock (µs)",
    "id": "the asker's own name for this, never used twice",
    "known": "whether it can be judged now",
    "kind": "what happened",
    "made": "made in the page, not described",
    "last": "sequence number of the last sample meant",
    "latched": "STOP is on",
    "linear": "forward speed (m/s)",
    "live": "false for samples that come late",
    "loop_ms": "there and back, by the last beat (ms)",
    "message": "a sentence for people",
    "messages": "how many messages it holds",
    "mono_us": "the sender's monotonic clock (µs); only the sender can compare it",
    "note": "what is missing in it; empty where nothing is",
    "n": "a number that rises; the answer echoes it",
    "offset": "per sample: time after `base_us` (µs, i32, little-endian)",
    "on": "whether it is recording, or is to",
    "online": "whether its gateway is linked",
    "op": "what is asked",
    "peer_us": "the answerer's monotonic clock (µs)",
    "phase": "where it stands",
    "can_film": "whether cameras can be filmed there",
    "films": "cameras that are being filmed, as `device/stream`",
    "pictures": "how many pictures it has",
    "picture_ms": "age of the picture the driver looks at (ms); -1 for none",
    "progress": "how much is done (0 to 1)",
    "protocol": "version of this page's messages; one more or less is understood",
    "raised_us": "when it was raised last (µs since the epoch, UTC)",
    "reason": "a sentence for people",
    "refused": "why not; empty when it was granted",
    "remains_ms": "for how long the lease still holds (ms)",
    "role": "the person's role",
    "seq": "a number that rises with each of these",
    "severity": "how bad it is: `info`, `warning` or `critical`",
    "shelved_by": "who put it aside",
    "shelved_until_us": "put aside until (µs since the epoch, UTC); 0: it is not",
    "shelved_why": "why it was put aside",
    "signals": "channels that it looks at, by address",
    "session": "the socket of the page that asks, as the hub names it",
    "since_us": "since when (µs since the epoch, UTC)",
    "site": "the site's short name",
    "skew_ms": "how far the gateway's wall clock is ahead of the hub's (ms)",
    "stream": "the camera, as `device/stream`",
    "streams": "cameras, as `device/stream`",
    "sub": "the asker's number for the subscription",
    "texts": "position in the batch to text; the value there is NaN",
    "tick": "the gateway's own time mark",
    "time_us": "wall time (µs since the epoch, UTC); 0 where it is not told",
    "topics": "ROS topics by their absolute names",
    "to_us": "latest time (µs since the epoch, UTC)",
    "token": "the key to the second step; empty in the first",
    "ttl_ms": "refuse it when it is older (ms); 0 takes the description's",
    "value": "per sample: the reading (f64, little-endian)",
    "version": "the program's version, for people",
    "who": "the person, by name",
    "why": "a sentence for people; empty where all is well",
    "width": "columns of the picture",
    "yours": "whether it is you",
}
# Fields that mean something else in one message than everywhere else.
ELSEWHERE = {
    ("DescriptionUpdate", "addresses"): "of the channels that the catalogue names, in order",
    ("DescriptionUpdate", "description"): "the site description (YAML), deflated (zlib)",
    ("ChangeRequest", "source"): "the description's text, deflated (zlib)",
    ("AlarmUpdate", "kind"): "what it watches for",
    ("AlarmUpdate", "name"): "what people call it",
    ("AlarmUpdate", "phase"): "`normal`, `active`, `acknowledged` or `cleared`",
    ("RecordingRequest", "alarm"): "an alarm begins it, not a person",
    ("RecordingRequest", "stream"): "only the film of this camera is meant; empty: the recording",
    ("FilmOffer", "begin_us"): "time of the first picture (µs since the epoch, UTC)",
    ("FilmOffer", "end_us"): "time of the last picture (µs since the epoch, UTC)",
    ("ArchiveOffer", "kind"): "what it is, and so where it goes",
    ("BoxesRequest", "on"): "whether they are wanted from here on",
    ("SightingUpdate", "id"): "the hub's number for it",
    ("FilePiece", "data"): "the file's bytes",
    ("FileProgress", "refused"): "why the hub does not take it; empty when it does",
    ("DriveState", "sent"): "characters since the last `s`, to a robot that is driven by them",
    ("DriveUpdate", "sent"): "characters since the last `s`, to a robot that is driven by them",
    ("DriveState", "refused"): "driving frames refused since the lease began",
    ("DriveUpdate", "refused"): "driving frames refused since the lease began",
    ("NightState", "refused"): "why it was not done; empty: it was",
    ("NightState", "frames_done"): "of the request that is observed",
    ("ObservationUpdate", "frames_done"): "of each configuration, read out and kept, in all tries",
    ("ObservationAck", "number"): "all updates up to this one are in the hub's database",
    ("Subscribed", "refused"): "addresses that are not there or not for you",
    ("SiteUpdate", "catalogue"): "names the channel list; another one means: ask for it anew",
}
CLOSE_CODES = [
    (1000, "both", "the end of a link on purpose"),
    (1002, "both", "a frame that is not in the protocol"),
    (1009, "both", "a frame, or a batch in it, over its limit"),
    (1011, "hub", "the hub failed; see its log"),
    (1013, "hub", "the hub cannot store anything now; try again later"),
    (4400, "hub", "a hello that is refused: wrong site, description with a mistake, protocol"),
    (4401, "hub", "the session is over (pages)"),
    (4409, "hub", "another gateway with this key is linked, or the key was revoked"),
]
# Path, what it is for, who sends what: (title, union's name, module).
CHANNELS = [
    ("/gateway/link", "Gateway to hub", "frames", "FromGateway"),
    ("/gateway/link", "Hub to gateway", "frames", "FromHub"),
    ("/gateway/media", "Gateway to hub", "frames", "MediaFromGateway"),
    ("/gateway/media", "Hub to gateway", "frames", "MediaFromHub"),
    ("/gateway/files", "Gateway to hub", "frames", "FilesFromGateway"),
    ("/gateway/files", "Hub to gateway", "frames", "FilesFromHub"),
    ("/ws", "Browser to hub", "browser", "FromBrowser"),
    ("/ws", "Hub to browser", "browser", "ToBrowser"),
    ("/ws/media", "Hub to browser", "browser", "MediaToBrowser"),
    ("/ws/media", "Browser to hub", "browser", "MediaFromBrowser"),
    ("/ws/topic", "Hub to browser", "browser", "TopicToBrowser"),
    ("/ws/topic", "Browser to hub", "browser", "TopicFromBrowser"),
]


def meaning(shape: type[msgspec.Struct], field: str, notes: dict[str, str]) -> str:
    """Say what a field means: by the message's own words, or by the glossary.

    Raises:
        SystemExit: nobody says it.

    """
    said = notes.get(field) or ELSEWHERE.get((shape.__name__, field)) or GLOSSARY.get(field)
    if not said:
        raise SystemExit(f"{shape.__name__}.{field}: say what it means (tools/wire_words.py)")
    return said


def limits(kind: inspect.Type) -> str:
    """Say a type's limits in words; empty where it has none."""
    match kind:
        case inspect.StrType() | inspect.BytesType() | inspect.ListType() | inspect.DictType():
            unit = {
                inspect.StrType: "characters", inspect.BytesType: "bytes",
            }.get(type(kind), "entries")  # fmt: skip
            low, high = kind.min_length or 0, kind.max_length
            if high is None:
                return ""
            return f"{f'{low} to ' if low else 'at most '}{high:,} {unit}"
        case inspect.IntType():
            low, high = kind.ge, kind.le
            if low is None or high is None:
                return ""
            power = high.bit_length() - 1
            most = f"2^{power}" if high >= 2**31 and high == 2**power else f"{high:,}"
            least = f"-{most}" if low == -high else f"{low:,}"
            return f"{least} to {most}"
        case inspect.UnionType():
            return "; ".join(filter(None, (limits(each) for each in kind.types)))
        case _:
            return ""
