"""What is to be seen on a camera's pictures. Values only: `talaia.objects` sees.

Long, because one kind of source has all that a signal may tell of a camera, and its words stand
beside it.
"""

from __future__ import annotations

from enum import StrEnum

from talaia.model.base import Shape, SourceShape

__all__ = [
    "CLOUDS",
    "LANE",
    "LANE_HEADING",
    "LANE_OFFSET",
    "LANE_WIDTH",
    "Blur",
    "Clip",
    "DepthScale",
    "Detect",
    "DetectAt",
    "DetectionSource",
    "FloorPoints",
    "LaneView",
    "Measured",
    "ModelKind",
    "ObjectModel",
    "PictureLine",
    "PictureZone",
    "SkyLens",
]

PicturePoint = tuple[float, float]

# What a signal ``sees`` on a camera that looks at all of the sky: how much is covered (%).
CLOUDS = "clouds"
# And on one that looks at the lane before the vehicle: how far left of its middle the vehicle is
# (m), how it is turned against it, counter-clockwise (rad), and how wide it is (m).
LANE_OFFSET, LANE_HEADING, LANE_WIDTH = "lane_offset", "lane_heading", "lane_width"
LANE = {LANE_OFFSET: "m", LANE_HEADING: "rad", LANE_WIDTH: "m"}


class DetectAt(StrEnum):
    """Which machine looks at the pictures."""

    GATEWAY = "gateway"
    # For a robot whose computer is too weak; interlocks cannot rely on what is seen there.
    HUB = "hub"


class ModelKind(StrEnum):
    """What a model's file tells of a picture, and how.

    The first two tell boxes, see `talaia.objects.detector.OutputFormat`; of each of the others
    there is a module in `talaia.objects.kinds`.
    """

    NANODET = "nanodet"
    YOLO = "yolo"
    SEGMENTATION = "segmentation"
    CLASSIFICATION = "classification"
    KEYPOINTS = "keypoints"
    DEPTH = "depth"

    @property
    def tells_boxes(self) -> bool:
        """Whether it is a detector: `Detect` and `Blur` take it."""
        return self in (ModelKind.NANODET, ModelKind.YOLO)


class DepthScale(StrEnum):
    """What the numbers of a depth model are."""

    # Larger is nearer, in no unit, as of MiDaS and Depth Anything.
    NEARNESS = "nearness"
    METRES = "metres"


class Measured(StrEnum):
    """What a signal tells of the things of a class on a camera, or of what a model says of it."""

    # How many are there.
    COUNT = "count"
    # For how long the one who is longest in the zone has been there (s); 0 while it is empty.
    DWELL = "dwell"
    # How many crossed a line to the left, or to the right, of the way from its first point to its
    # last.
    LEFT = "left"
    RIGHT = "right"
    # Of the fastest (m/s), on a camera that knows its floor.
    SPEED = "speed"
    # Of a segmentation (all in %). How much of the area a class covers; how far up from the area's
    # lower edge it reaches without a break; where it begins and ends, of the picture's width.
    SHARE = "share"
    AHEAD = "ahead"
    LEFT_EDGE = "left_edge"
    RIGHT_EDGE = "right_edge"
    # Of a classification: how likely a class is (%), and which is the likeliest.
    PROBABILITY = "probability"
    SUREST = "surest"
    # Of depth: how near the nearest in the area is, in metres or in % of the picture's own range.
    NEAREST = "nearest"


class PictureZone(Shape, frozen=True, kw_only=True):
    """A part of a camera's picture.

    Attributes:
        points: its corners in order, each by its parts of the picture's width and height from the
            upper left, 0 to 1.

    """

    name: str
    points: tuple[PicturePoint, ...]


class PictureLine(Shape, frozen=True, kw_only=True):
    """A line on a camera's picture, at which is counted who crosses it.

    Attributes:
        points: two or more, each by its parts of the picture's width and height from the upper
            left, 0 to 1. Left and right are as seen along the way from the first to the last.

    """

    name: str
    points: tuple[PicturePoint, ...]


class FloorPoints(Shape, frozen=True, kw_only=True):
    """Four points of the floor that a camera sees, by which places on its picture become metres.

    Attributes:
        picture: where they are on the picture, by parts of its width and height from the upper
            left.
        metres: where they are on the floor, in the same order: x and y (m) from anywhere.

    """

    picture: tuple[PicturePoint, PicturePoint, PicturePoint, PicturePoint]
    metres: tuple[PicturePoint, PicturePoint, PicturePoint, PicturePoint]


class Clip(Shape, frozen=True, kw_only=True):
    """A film of a few seconds around the moment at which something came into sight.

    It goes the way of all films: see `Recording`, which the site needs for it.

    Attributes:
        before: so much of before is in it (s); the camera is encoded all the time for that.
        after: it ends so long after the last one came into sight (s).

    """

    before: float = 5.0
    after: float = 10.0


class Detect(Shape, frozen=True, kw_only=True):
    """Object detection on one camera.

    Attributes:
        classes: what is counted, kept as sightings and may raise alarms, by the names that the
            detector's list of classes has. Pages may show boxes of others, too.
        confidence: what is less sure than this does not count, 0 to 1.
        max_rate: pictures a second that are looked at, at the most (Hz); fewer where the
            machine is too busy.
        hold: for interlocks: a count falls only after it has been lower for so long (s), for a
            detector misses now and then what is there. Charts show each picture's own count.
        at: which machine looks.
        model: a name of `Site.object_models`; without it NanoDet with COCO's 80 classes.
        zones: parts of the picture in which signals count, by the names that their sources use.
        lines: lines at which signals count who crosses them, in the same way.
        floor: four points by which speed is known in metres a second.
        clip: films what comes into sight.

    """

    classes: tuple[str, ...] = ("person", "bicycle", "car", "cat", "dog")
    confidence: float = 0.5
    max_rate: float = 10.0
    hold: float = 2.0
    at: DetectAt = DetectAt.GATEWAY
    model: str = ""
    zones: dict[str, PictureZone] = {}
    lines: dict[str, PictureLine] = {}
    floor: FloorPoints | None = None
    clip: Clip | None = None


class Blur(Shape, frozen=True, kw_only=True):
    """What of a camera's pictures nobody recognizes who has no right to: ``unblurred``.

    Live pictures, films and pictures of sightings leave the gateway blurred. A picture that
    could not be looked at does not leave it.

    Attributes:
        faces: people's faces, found by CenterFace.
        plates: number plates, or whatever else: a name of `Site.object_models`; all that this
            detector finds is blurred. Without it none is.
        confidence: what is less sure than this is left as it is, 0 to 1. Lower blurs more that
            is no face, higher leaves more faces.
        looks: pictures a second that are looked at, at the most (Hz); on those between, what was
            found last is blurred with more around it. 0 looks at each picture that leaves: what
            comes into view is then never seen, and there are as many pictures as the machine
            manages.
        hold: where something was found is blurred for so long after it is not found (s), for a
            detector misses now and then what is there.
        side: the picture's longer side as it is shown to the detector of faces (px). Half of it
            takes a quarter of the time, and finds faces that are twice as large.

    """

    faces: bool = True
    plates: str = ""
    confidence: float = 0.2
    looks: float = 0.0
    hold: float = 0.5
    side: int = 480


class ObjectModel(Shape, frozen=True, kw_only=True):
    """A model of one's own that looks at pictures, as an ONNX file.

    Attributes:
        file: where it is, absolute or beside the description, on the machine that looks.
        kind: what it tells of a picture, and how.
        classes: their names, in the order in which the file numbers them; ``depth`` has none, and
            ``keypoints`` the one whose points it tells.
        points: of ``keypoints``: their names, in the file's order; without them COCO's 17 of a
            person.
        bones: of ``keypoints``: which points are drawn joined, two names each; without ``points``
            COCO's.
        scale: of ``depth``: what its numbers are.
        side: of the square that it is shown (px).
        mean: taken from each colour, 0 to 255, in the order in which they are given.
        spread: each colour is divided by it then.
        blue_first: it wants blue, green, red instead of red, green, blue.

    """

    file: str
    kind: ModelKind
    classes: tuple[str, ...] = ()
    points: tuple[str, ...] = ()
    bones: tuple[tuple[str, str], ...] = ()
    scale: DepthScale = DepthScale.NEARNESS
    side: int = 640
    mean: tuple[float, float, float] = (0.0, 0.0, 0.0)
    spread: tuple[float, float, float] = (255.0, 255.0, 255.0)
    blue_first: bool = False


class SkyLens(Shape, frozen=True, kw_only=True):
    """Where the sky is on the pictures of a camera that looks at all of it, to the zenith.

    A fisheye of the usual kind: the distance from the zenith on the picture is as the angle.

    Attributes:
        x: column of the zenith (pixels from the left, as the picture comes).
        y: row of the zenith (pixels from the top).
        radius: from the zenith to the horizon (pixels).
        turned: azimuth that is up on the picture (°).
        mirrored: east is at the right when north is up.
        lowest: what stands lower is not looked at (°).
        faintest: stars to this magnitude are looked for.
        every: it is looked so often (s).

    """

    x: float
    y: float
    radius: float
    turned: float = 0.0
    mirrored: bool = False
    lowest: float = 25.0
    faintest: float = 4.5
    every: float = 30.0


class LaneView(Shape, frozen=True, kw_only=True):
    """A camera that sees the lane before the vehicle: two markings on the floor, or of a road.

    Attributes:
        floor: four points of the floor. Their metres are those of the vehicle: x ahead of it, y to
            its left (REP-103).
        ahead: from where to where is looked, before the vehicle (m).
        narrowest: the narrowest lane that is one, from marking to marking (m).
        widest: the widest.
        marking: how wide a marking is (m).
        light: markings are lighter than the floor; no: darker.
        every: it is looked so often (s).

    """

    floor: FloorPoints
    ahead: tuple[float, float] = (0.5, 2.5)
    narrowest: float = 0.6
    widest: float = 1.6
    marking: float = 0.05
    light: bool = True
    every: float = 0.2


class DetectionSource(SourceShape, frozen=True, kw_only=True, tag="detection"):
    """Where a signal comes from that counts what a camera sees, whatever the connection.

    Attributes:
        stream: a camera of the same device, by its name.
        sees: how many of this class are on its newest picture; goes with ``stream``. ``clouds`` of
            a camera that looks at all of the sky (`SkyLens`): how much of it is covered (%).
            ``lane_offset`` (m to the left of its middle), ``lane_heading`` (rad, counter-clockwise)
            and ``lane_width`` (m) of one that looks at the lane before the vehicle (`LaneView`).
        model: this one of the camera's `Stream.models` tells it; ``sees`` is one of its classes or
            points then, and empty for ``surest`` and ``nearest``.
        within: only those whose feet (the middle of the box's lower edge) are in this part of the
            picture: left, top, right, bottom, each 0 to 1; the drive path, say.
        zone: only those whose feet are in this one of the camera's `Detect.zones`, or of the zones
            that ``model`` has there.
        line: this one of the camera's `Detect.lines`; goes with ``measure: left`` or ``right``.
        measure: what is told of them.
        over: of crossings, those of the last so many seconds; 0 counts on from when the camera was
            looked at first.

    """

    stream: str = ""
    sees: str = ""
    model: str = ""
    within: tuple[float, float, float, float] | None = None
    zone: str = ""
    line: str = ""
    measure: Measured = Measured.COUNT
    over: float = 0.0

    @property
    def counts_all(self) -> bool:
        """Whether it counts all of its class on the whole picture."""
        anywhere = self.within is None and not self.zone and not self.line
        return anywhere and not self.model and self.measure is Measured.COUNT
