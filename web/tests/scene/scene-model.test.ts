/** What a scene shows, from the bytes that rosbags wrote (`recorded.json`). */

import { readFileSync } from "node:fs";
import { describe, expect, it } from "vitest";
import type { TopicBytes } from "../../src/generated/wire.js";
import { readCloud } from "../../src/scene/cloud.js";
import { MessageError, MessageReader } from "../../src/scene/cdr.js";
import { cloudColours, ramp } from "../../src/scene/colours.js";
import { changesByItself, placedPoints, SceneModel } from "../../src/scene/scene-model.js";
import { chooseFixedFrame, chooseRobotFrame, isShownAtFirst, isSwitched, sceneKind, type SceneKind } from "../../src/scene/scene-topics.js";

const RECORDED = JSON.parse(readFileSync(new URL("recorded.json", import.meta.url), "utf8")) as Record<string, string>;
const TYPES: Readonly<Record<string, string>> = {
  tf: "tf2_msgs/msg/TFMessage",
  scan: "sensor_msgs/msg/LaserScan",
  path: "nav_msgs/msg/Path",
  cloud: "sensor_msgs/msg/PointCloud2",
  camera_info: "sensor_msgs/msg/CameraInfo",
  markers: "visualization_msgs/msg/MarkerArray",
  joints_ros1: "sensor_msgs/msg/JointState",
};

function recorded(name: string): TopicBytes {
  const data = Uint8Array.from(atob(RECORDED[name] ?? ""), (letter) => letter.charCodeAt(0));
  return { t: "topic_bytes", number: 1, seq: 1, time_us: 0, publish_us: 0, age_ms: 0, encoding: name.endsWith("_ros1") ? "ros1" : "cdr", every: 1, data };
}

function kindOf(topic: string, type: string): SceneKind {
  const kind = sceneKind(topic, type);
  if (kind === null) throw new Error(`a scene shows no ${type}`);
  return kind;
}

function apply(model: SceneModel, name: string, topic = `/${name}`, nowMs = 1000): void {
  model.applyMessage(topic, kindOf(topic, TYPES[name] ?? ""), recorded(name), nowMs);
}

describe("a scene's model", () => {
  it("keeps the newest of each topic, in its frame", () => {
    const model = new SceneModel();
    for (const name of ["scan", "path", "cloud"]) apply(model, name);
    expect([...model.layers.values()].map(({ topic, frame, content, number }) => [topic, frame, content.shape, number])).toEqual([
      ["/scan", "l", "scan", 1], ["/path", "map", "line", 2], ["/cloud", "cam", "cloud", 3],
    ]);
    apply(model, "scan", "/scan", 2000);
    expect(model.layers.get("/scan")).toMatchObject({ number: 4, heardMs: 2000 });
    model.forget("/scan");
    expect(model.layers.has("/scan")).toBe(false);
  });

  it("places a layer by the transforms that were heard, and says where none join it", () => {
    const model = new SceneModel();
    apply(model, "tf");
    const header = { timeUs: 0, frame: "base_link" };
    expect(model.placeOf(header, "odom")?.at).toEqual([1, 2, 3]);
    expect(model.placeOf({ ...header, frame: "moon" }, "odom")).toBeNull();
    expect(model.placeOf({ ...header, frame: "" }, "odom")?.at).toEqual([0, 0, 0]);
    const moved = placedPoints(Float32Array.of(1, 0, 0, 0, 0, 1), { at: [1, 2, 3], turn: [0, 0, Math.SQRT1_2, Math.SQRT1_2] });
    [1, 3, 3, 1, 2, 4].forEach((wanted, at) => {
      expect(moved[at]).toBeCloseTo(wanted, 6);
    });
  });

  it("lets a marker live as long as its sender said, from when it was heard", () => {
    const model = new SceneModel();
    apply(model, "markers");
    apply(model, "markers", "/markers", 9000);
    const content = model.layers.get("/markers")?.content;
    expect(content?.shape === "markers" && content.markers.map(({ marker, endsMs }) => [marker.key, endsMs])).toEqual([["n/7", 11_500], ["n/8", 11_500]]);
  });

  it("is drawn anew as time passes only where something ends by itself", () => {
    const model = new SceneModel();
    for (const name of ["scan", "path", "tf"]) apply(model, name);
    expect(changesByItself(model)).toBe(false);
    apply(model, "markers");
    expect(changesByItself(model)).toBe(true);
    model.forget("/markers");
    expect(changesByItself(model)).toBe(false);
  });

  it("shows a camera's picture from where it was taken, and gives back one that is not shown any more", () => {
    const model = new SceneModel();
    const closed: number[] = [];
    const image = (number: number): ImageBitmap => ({ width: 1, height: 1, close: () => closed.push(number) });
    model.setPicture("/camera_info", { image: image(1), timeUs: 5, heardMs: 900, rectified: true });
    // Without a calibration nobody knows where it belongs.
    expect(model.layers.has("/camera_info")).toBe(false);
    apply(model, "camera_info");
    expect(model.layers.get("/camera_info")).toMatchObject({ frame: "camera_optical_frame", timeUs: 5, heardMs: 900, content: { info: { d: [], k: [480, 0, 320, 0, 490, 240, 0, 0, 1] } } });
    model.setPicture("/camera_info", { image: image(2), timeUs: 6, heardMs: 950, rectified: false });
    expect(model.layers.get("/camera_info")).toMatchObject({ timeUs: 6, content: { info: { distortion: "plumb_bob", k: [500, 0, 319.5, 0, 510, 239.5, 0, 0, 1] } } });
    expect([closed, changesByItself(model)]).toEqual([[1], true]);
    model.setPicture("/camera_info", null);
    expect(model.layers.get("/camera_info")).toMatchObject({ content: { picture: null } });
    expect([closed, changesByItself(model)]).toEqual([[1, 2], false]);
    model.reset();
    expect(model.layers.size).toBe(0);
  });

  it("keeps a robot's joints as ROS 1 wrote them, and refuses what is no such message", () => {
    const model = new SceneModel();
    apply(model, "joints_ros1");
    expect(model.joints).toMatchObject({ names: ["a", "bc"], positions: [0.25, -1.5] });
    expect(() => {
      model.applyMessage("/map", kindOf("/map", "nav_msgs/msg/OccupancyGrid"), recorded("scan"), 0);
    }).toThrow(MessageError);
    expect(model.layers.size).toBe(0);
  });
});

describe("the topics of a scene", () => {
  it("are those whose type is drawn; of texts only the robot's form", () => {
    expect(sceneKind("/scan", "sensor_msgs/msg/Image")).toBeNull();
    expect(sceneKind("/chatter", "std_msgs/msg/String")).toBeNull();
    expect(sceneKind("/robot_description", "std_msgs/msg/String")?.kind).toBe("robot");
  });

  it("are switched by a person, but for what says where things are", () => {
    const transforms = kindOf("/tf", "tf2_msgs/msg/TFMessage");
    const map = kindOf("/map", "nav_msgs/msg/OccupancyGrid");
    expect([isSwitched(transforms), isSwitched(map)]).toEqual([false, true]);
    expect([isShownAtFirst("/map", map), isShownAtFirst("/local_costmap/costmap", map)]).toEqual([true, false]);
    expect(isShownAtFirst("/points", kindOf("/points", "sensor_msgs/msg/PointCloud2"))).toBe(false);
  });

  it("stand in the frames of REP-105 where there are such", () => {
    const among = (...names: string[]) => (name: string) => names.includes(name);
    expect(chooseFixedFrame(among("odom", "map"), [])).toBe("map");
    expect(chooseFixedFrame(among(), ["mine"])).toBe("mine");
    expect(chooseFixedFrame(among(), [])).toBe("");
    expect(chooseRobotFrame(among("base_link"), "chassis")).toBe("base_link");
    expect(chooseRobotFrame(among(), "chassis")).toBe("chassis");
  });
});

describe("the colours of points", () => {
  it("go from dark to bright, and stay red at night", () => {
    const brightness = (share: number, night: boolean): number => ramp(share, night).reduce((sum, part) => sum + part, 0);
    expect(brightness(0, false)).toBeLessThan(brightness(1, false));
    expect(ramp(-3, false)).toEqual(ramp(0, false));
    expect(ramp(7, true)).toEqual(ramp(1, true));
    for (const share of [0, 0.5, 1]) expect(ramp(share, true)[2]).toBeLessThan(0.1);
  });

  it("are the points' own where they have some, by height where they have none", () => {
    const { data, encoding } = recorded("cloud");
    const cloud = readCloud(new MessageReader(data, encoding));
    const own = cloudColours(cloud, "rgb", false);
    expect([...own.subarray(0, 4)]).toEqual([0x10, 0x20, 0x30, 255]);
    const bare = { ...cloud, rgb: null, intensity: null };
    expect(cloudColours(bare, "rgb", false)).toEqual(cloudColours(bare, "height", false));
    // The lowest is as dark as the ramp begins, the highest as bright as it ends.
    const heights = { ...bare, positions: new Float32Array([9, 9, -1, 9, 9, 3]) };
    const ends = [0, 1].flatMap((share) => [...ramp(share, false).map((part) => Math.round(255 * part)), 255]);
    expect([...cloudColours(heights, "height", false)]).toEqual(ends);
    // Nobody's own colours where eyes are used to the dark.
    expect(cloudColours(cloud, "rgb", true)).toEqual(cloudColours(cloud, "height", true));
  });
});
