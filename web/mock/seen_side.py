"""What the made-up camera sees: a person who walks by and a dog, their boxes, and sightings."""

import io
import math
import time

from fastapi import APIRouter, Request, Response
from fastapi.responses import JSONResponse
from PIL import Image, ImageDraw

from talaia.wire.frames import DetectedObject

CAMERA = "sensors/front"
CLASSES = ["person", "bicycle", "car", "cat", "dog"]
STEP_US = 311_000_000
_SEEN = (("person", 2, 0.91), ("dog", 1, 0.74), ("person", 1, 0.66), ("bicycle", 1, 0.58))


def things(now: float) -> list[DetectedObject]:
    """Say where they are on the picture of a moment."""
    walk = 0.5 + 0.4 * math.sin(now / 3)
    trot = (now / 5) % 1.4 - 0.2
    found = [_thing("person", 0.93, walk - 0.07, 0.28, walk + 0.07, 0.92)]
    if -0.1 < trot < 1.0:
        found.append(_thing("dog", 0.71, trot, 0.7, trot + 0.16, 0.93))
    return [*found, _thing("chair", 0.42, 0.82, 0.6, 0.97, 0.9)]


def _thing(label: str, score: float, *sides: float) -> DetectedObject:
    left, top, right, bottom = (min(1.0, max(0.0, side)) for side in sides)
    return DetectedObject(label=label, score=score, left=left, top=top, right=right, bottom=bottom)


_COLOURS = {"person": (40, 70, 130), "dog": (120, 80, 40), "chair": (90, 110, 90)}


def paint(draw: ImageDraw.ImageDraw, now: float, width: int, height: int) -> None:
    """Paint them where their boxes will be."""
    for one in things(now):
        sides = (one.left * width, one.top * height, one.right * width, one.bottom * height)
        draw.rectangle(sides, _COLOURS[one.label])


def sighting(number: int) -> dict[str, object]:
    """Make up one: each `STEP_US` something comes into sight, the newest is there still."""
    label, many, confidence = _SEEN[number % len(_SEEN)]
    began = number * STEP_US
    ended = began + 20_000_000 + number % 7 * 31_000_000
    return {
        "id": str(number),
        "camera": CAMERA,
        "label": label,
        "many": many,
        "confidence": confidence,
        "began_us": began,
        "ended_us": ended if ended < time.time() * 1e6 else None,
        "picture": number % 5 != 0,
    }


def router() -> APIRouter:
    """Give the routes of sightings."""
    routes = APIRouter()

    @routes.get("/api/sites/{name}/sightings")
    async def find(
        request: Request,
        from_us: int = 0,
        to_us: int = 2**53,
        camera: str = "",
        label: str = "",
        before: int | None = None,
        limit: int = 100,
    ) -> Response:
        if request.state.who.startswith("guest"):
            said = {"code": "forbidden", "message": "You need the right to view this site."}
            return JSONResponse(said, 403)
        newest = int(time.time() * 1e6) // STEP_US
        first = min(newest, before - 1 if before is not None else newest)
        rows = [sighting(number) for number in range(first, newest - 200, -1)]
        found = [
            row
            for row in rows
            if (not label or row["label"] == label)
            and (not camera or row["camera"] == camera)
            and int(str(row["began_us"])) <= to_us
            and (row["ended_us"] is None or int(str(row["ended_us"])) >= from_us)
            and ("open" not in request.query_params or row["ended_us"] is None)
        ]
        return JSONResponse({"sightings": found[:limit], "more": len(found) > limit})

    @routes.get("/api/sites/{name}/sightings/labels")
    async def labels() -> dict[str, object]:
        known = dict.fromkeys(label for label, _, _ in _SEEN)
        return {"labels": [{"camera": CAMERA, "label": label} for label in known]}

    @routes.get("/api/sites/{name}/sightings/{number}/picture")
    async def picture(number: int) -> Response:
        image = Image.new("RGB", (320, 240), (196, 205, 208))
        paint(ImageDraw.Draw(image), number * 7.0, 320, 240)
        out = io.BytesIO()
        image.save(out, "JPEG", quality=70)
        return Response(out.getvalue(), media_type="image/jpeg")

    return routes
