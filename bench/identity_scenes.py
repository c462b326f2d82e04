"""People who walk past a camera, cross and are covered: pictures, and the truth of who is where.

Drawn by the simulator's parts (its room surfaces, its person) in MuJoCo. Ten scenes from seeds; the
same seed gives the same scene.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, NamedTuple

import mujoco
import numpy as np

from talaia.sim.vehicle import furniture, occupants
from talaia.sim.vehicle.scene import LOOK_GROUP, Finish, SceneBuilder
from talaia.sim.vehicle.textures import draw_parquet

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

RATE, SECONDS = 10.0, 24.0
WIDTH, HEIGHT = 640, 480
FIELD = 56.0
CAMERA_AT, TILT = (0.0, 0.0, 2.2), math.radians(10)
# Of a person so much must be visible to be there (of the pixels without any cover).
VISIBLE = 0.25
# The line on the floor that is counted at: from near to far, clear of what covers.
LINE = ((3.0, 1.7), (9.5, 1.7))


Model = Shape = Any
"""MuJoCo ships no types."""


class Person(NamedTuple):
    """Where a person goes: points (x, y, seconds to stand there), and how fast (m/s)."""

    points: tuple[tuple[float, float, float], ...]
    pace: float
    begins_s: float
    shirt: tuple[float, float, float]
    jeans: tuple[float, float, float]


class Moment(NamedTuple):
    """One picture's truth.

    Attributes:
        boxes: by person: left, top, right, bottom of what is visible, parts of the picture.
        feet: by person: where they stand on the picture, seen or not.
        floor: by person: where they stand (m).

    """

    time_us: int
    picture: NDArray[np.uint8]
    boxes: dict[int, tuple[float, float, float, float]]
    feet: dict[int, tuple[float, float]]
    floor: dict[int, tuple[float, float]]


class _Stage(SceneBuilder):
    """Puts what is looked at into one body after the other."""

    body: Any = None

    def add_visual(self, finish: str, **geom: Shape) -> None:
        body = self.spec.worldbody if self.body is None else self.body
        body.add_geom(
            material=self.find_material(finish),
            group=LOOK_GROUP,
            contype=0,
            conaffinity=0,
            **geom,
        )


def project(x: float, y: float, z: float = 0.0) -> tuple[float, float]:
    """Say where a point of the room is on the picture (parts of it)."""
    ahead, left, up = x - CAMERA_AT[0], y - CAMERA_AT[1], z - CAMERA_AT[2]
    depth = math.cos(TILT) * ahead - math.sin(TILT) * up
    high = math.sin(TILT) * ahead + math.cos(TILT) * up
    focal = 0.5 / math.tan(math.radians(FIELD / 2))
    return 0.5 - left / depth * focal * HEIGHT / WIDTH, 0.5 - high / depth * focal


def people_of(seed: int) -> list[Person]:
    """Choose who walks, of ten kinds of scenes by turns."""
    rng = np.random.default_rng(seed)
    kind = seed % 5
    alike = seed % 10 in {3, 7, 8}

    def clothes() -> tuple[tuple[float, float, float], tuple[float, float, float]]:
        if alike:
            return (0.2, 0.25, 0.3), (0.15, 0.15, 0.2)
        return tuple(rng.uniform(0.05, 0.95, 3)), tuple(rng.uniform(0.05, 0.6, 3))  # type: ignore[return-value]

    def across(depth: float, side: int, stop: float, begins: float, pace: float) -> Person:
        far = 0.95 * depth + 0.6
        end = depth + rng.uniform(-0.8, 0.8)
        # Behind the shelf, which covers from about -0.9 to 1.0 there.
        middle = (depth + end) / 2
        return Person(
            ((depth, side * far, 0.0), (middle, rng.uniform(-0.2, 0.2), stop),
             (end, -side * far, 0.0)),
            pace, begins, *clothes(),
        )  # fmt: skip

    def pace() -> float:
        return float(rng.uniform(0.8, 1.4))

    if kind == 0:  # Two cross, one nearer than the other, before the cover and behind it.
        return [across(3.0, 1, 0.0, 0.5, pace()), across(6.0, -1, rng.uniform(0, 2), 0.0, pace()),
                across(7.5, 1, 0.0, 5.0, pace())]  # fmt: skip
    if kind == 1:  # One hides for seconds and comes out.
        return [across(6.0, 1, rng.uniform(2, 4), 0.0, pace()),
                across(5.0, -1, 0.0, 10.0, pace())]  # fmt: skip
    if kind == 2:  # One behind the other, a step apart.
        speed, depth = pace(), float(rng.uniform(5, 7))
        return [across(depth, -1, 0.0, 0.0, speed),
                across(depth, -1, 0.0, rng.uniform(0.8, 1.1) / speed, speed)]  # fmt: skip
    if kind == 3:  # Towards the camera, one behind the other, beside the cover.
        y, speed = float(rng.uniform(2.0, 2.6)), pace()
        return [
            Person(((9.0, 6.5, 0), (8.0, y, 0.5), (4.2, y - 3.4, 0.0), (3.0, -4.0, 0)), speed,
                   begins, *clothes())
            for begins in (0.0, 1.2 / speed)
        ]  # fmt: skip
    # Four at once, each their own way.
    return [across(float(rng.uniform(4.8, 8)), side, float(rng.choice([0.0, 1.5])),
                   float(rng.uniform(0, 5)), pace())
            for side in (1, -1, 1, -1)]  # fmt: skip


def place_of(person: Person, at_s: float) -> tuple[float, float, float] | None:
    """Say where a person is, and where they look to; none before and after."""
    left = at_s - person.begins_s
    if left < 0:
        return None
    for (x, y, stands), (to_x, to_y, _) in zip(person.points, person.points[1:], strict=False):
        yaw = math.atan2(to_y - y, to_x - x)
        if left <= stands:
            return x, y, yaw
        left -= stands
        takes = math.hypot(to_x - x, to_y - y) / person.pace
        if left <= takes:
            part = left / takes
            return x + part * (to_x - x), y + part * (to_y - y), yaw
        left -= takes
    return None


def _model_of(people: list[Person], seed: int) -> Model:
    spec = mujoco.MjSpec()
    spec.visual.global_.offwidth, spec.visual.global_.offheight = WIDTH, HEIGHT
    spec.visual.headlight.ambient = (0.45, 0.45, 0.45)
    spec.visual.headlight.diffuse = (0.45, 0.45, 0.45)
    rng = np.random.default_rng([seed, 1])
    stage = _Stage(spec, rng, furniture.FINISHES | occupants.FINISHES, looks=True)
    stage.add_finish(
        "floor", Finish(lambda r: draw_parquet(r, (0.62, 0.48, 0.33), (12, 14), 100), repeat=0.0)
    )
    stage.add_finish("wall", Finish(colour=(0.88, 0.86, 0.80)))
    stage.add_finish("shelf", Finish(colour=(0.45, 0.30, 0.18)))
    room = stage.pose_at(0, 0)
    room.add_box("floor", (-1, -9, -0.05), (11, 9, 0.0))
    room.add_box("wall", (10.5, -9, 0.0), (10.6, 9, 3.5))
    room.add_box("shelf", (3.6, -0.55, 0.0), (4.0, 0.55, 2.0))
    spec.worldbody.add_light(pos=(4, 2, 5), dir=(0, 0, -1), diffuse=(0.4, 0.4, 0.4))
    for at, person in enumerate(people):
        stage.body = spec.worldbody.add_body(name=f"person{at}", mocap=True)
        for part in ("shirt", "jeans"):
            stage.add_finish(f"{part}{at}", Finish(colour=getattr(person, part)))
        names = {"shirt": f"shirt{at}", "jeans": f"jeans{at}"}
        plain = stage.find_material
        stage.find_material = lambda name, n=names, p=plain: p(n.get(name, name))  # type: ignore[method-assign]
        occupants.add_person(stage.pose_at(0, 0))
        stage.find_material = plain  # type: ignore[method-assign]
    spec.worldbody.add_camera(
        name="hall", pos=CAMERA_AT, fovy=FIELD,
        xyaxes=(0, -1, 0, math.sin(TILT), 0, math.cos(TILT)),
    )  # fmt: skip
    return spec.compile()


def play(seed: int, seconds: float = SECONDS) -> Iterator[Moment]:
    """Give one picture after the other."""
    people = people_of(seed)
    model = _model_of(people, seed)
    data = mujoco.MjData(model)
    option = mujoco.MjvOption()
    option.geomgroup[:] = 0
    option.geomgroup[LOOK_GROUP] = 1
    bodies = [model.body(f"person{at}").id for at in range(len(people))]
    rendered = mujoco.Renderer(model, HEIGHT, WIDTH)
    masks = mujoco.Renderer(model, HEIGHT // 2, WIDTH // 2)
    masks.enable_segmentation_rendering()
    for renderer in (rendered, masks):
        for flag in (mujoco.mjtRndFlag.mjRND_SHADOW, mujoco.mjtRndFlag.mjRND_REFLECTION):
            renderer.scene.flags[flag] = False

    def bodies_seen() -> NDArray[np.int64]:
        mujoco.mj_forward(model, data)
        masks.update_scene(data, "hall", option)
        shown = masks.render()
        geoms = np.where(shown[..., 1] == mujoco.mjtObj.mjOBJ_GEOM.value, shown[..., 0], -1)
        return np.where(geoms >= 0, model.geom_bodyid[geoms], -1)

    away = (0.0, 0.0, -90.0)
    for step in range(int(seconds * RATE)):
        places = {at: place_of(person, step / RATE) for at, person in enumerate(people)}
        here = {at: place for at, place in places.items() if place is not None}

        def put(only: int | None, here: dict[int, tuple[float, float, float]] = here) -> None:
            for at, body in enumerate(bodies):
                mocap = model.body_mocapid[body]
                shown = at in here and only in (None, at)
                data.mocap_pos[mocap] = (*here[at][:2], 0.0) if shown else away
                yaw = here[at][2] if at in here else 0.0
                data.mocap_quat[mocap] = (math.cos(yaw / 2), 0, 0, math.sin(yaw / 2))

        put(None)
        seen = bodies_seen()
        rendered.update_scene(data, "hall", option)
        picture = rendered.render()
        boxes = {}
        for at, place in here.items():
            rows, columns = np.nonzero(seen == bodies[at])
            # The nearest scene has them stand 2.5 m away: their pixels without cover go by depth.
            whole = _whole_pixels(place)
            if len(rows) >= max(40, VISIBLE * whole):
                boxes[at] = (
                    columns.min() / (WIDTH // 2), rows.min() / (HEIGHT // 2),
                    (columns.max() + 1) / (WIDTH // 2), (rows.max() + 1) / (HEIGHT // 2),
                )  # fmt: skip
        feet = {at: project(place[0], place[1]) for at, place in here.items()}
        floor = {at: place[:2] for at, place in here.items()}
        yield Moment(round(step / RATE * 1e6), picture, boxes, feet, floor)
    rendered.close()
    masks.close()


def _whole_pixels(place: tuple[float, float, float]) -> float:
    """Estimate the pixels of a whole person in the masks: 0.5 m² of silhouette."""
    focal = 0.5 * (HEIGHT // 2) / math.tan(math.radians(FIELD / 2))
    return 0.5 * (focal / math.hypot(*place[:2])) ** 2


def true_crossings(seed: int, line_from: float = LINE[0][0]) -> list[tuple[int, int]]:
    """Give who crossed `LINE`, and to which side (+1: to greater y), by where they stand.

    Args:
        seed: of the scene.
        line_from: where the line begins (m).

    """
    found = []
    for at, person in enumerate(people_of(seed)):
        last = 0.0
        for step in range(int(SECONDS * RATE)):
            place = place_of(person, step / RATE)
            if place is None:
                continue
            side = math.copysign(1, place[1] - LINE[0][1])
            if last and side != last and line_from <= place[0] <= LINE[1][0]:
                found.append((at, int(side)))
            last = side
    return found
