/** Where a camera's pixels look: its lens is put back by the formulas of its models, which are written here the other way round. */

import { readFileSync } from "node:fs";
import { describe, expect, it } from "vitest";
import { isCalibrated, picturePlane, pixelRay, planeKey, readCameraInfo, rectifiedInfo, type CameraInfo } from "../../src/scene/camera-model.js";
import { MessageReader } from "../../src/scene/cdr.js";

const RECORDED = JSON.parse(readFileSync(new URL("recorded.json", import.meta.url), "utf8")) as Record<string, string>;
const K = [500, 0, 319.5, 0, 510, 239.5, 0, 0, 1];

function cameraOf(more: Partial<CameraInfo>): CameraInfo {
  return { timeUs: 0, frame: "camera", width: 640, height: 480, distortion: "plumb_bob", d: [], k: K, p: [], region: { x: 0, y: 0, width: 0, height: 0 }, ...more };
}

function pixelOf(x: number, y: number): readonly [number, number] {
  return [500 * x + 319.5, 510 * y + 239.5];
}

describe("a calibration", () => {
  it("is read as rosbags has written it", () => {
    const info = readCameraInfo(new MessageReader(Uint8Array.from(atob(RECORDED["camera_info"] ?? ""), (letter) => letter.charCodeAt(0)), "cdr"));
    expect(info).toMatchObject({ frame: "camera_optical_frame", width: 640, height: 480, distortion: "plumb_bob", d: [-0.3, 0.12, 0.001, -0.002, -0.03], k: K });
    expect(info.region).toEqual({ x: 20, y: 10, width: 600, height: 460 });
    expect(rectifiedInfo(info)).toMatchObject({ d: [], k: [480, 0, 320, 0, 490, 240, 0, 0, 1] });
  });

  it("of zeros places no picture", () => {
    expect(isCalibrated(cameraOf({}))).toBe(true);
    expect(isCalibrated(cameraOf({ k: [0, 0, 0, 0, 0, 0, 0, 0, 0] }))).toBe(false);
    expect(isCalibrated(cameraOf({ width: 0 }))).toBe(false);
  });
});

describe("a pixel", () => {
  it("looks where a pinhole lets it: x right, y down", () => {
    expect(pixelRay(cameraOf({}), 319.5, 239.5)).toEqual([0, 0]);
    expect(pixelRay(cameraOf({}), 819.5, 749.5)).toEqual([1, 1]);
  });

  it("looks past a lens with radial and tangential parts", () => {
    const d = [-0.3, 0.12, 0.001, -0.002, -0.03];
    const [x, y] = [0.42, -0.31];
    const r2 = x * x + y * y;
    const radial = 1 - 0.3 * r2 + 0.12 * r2 ** 2 - 0.03 * r2 ** 3;
    const [u, v] = pixelOf(x * radial + 2 * 0.001 * x * y - 0.002 * (r2 + 2 * x * x), y * radial + 0.001 * (r2 + 2 * y * y) + 2 * -0.002 * x * y);
    const found = pixelRay(cameraOf({ d }), u, v);
    expect(found[0]).toBeCloseTo(x, 6);
    expect(found[1]).toBeCloseTo(y, 6);
  });

  it("looks past a lens that sees half of all there is", () => {
    const d = [-0.02, 0.004, -0.001, 0];
    const [x, y] = [1.5, 0.8];
    const angle = Math.atan(Math.hypot(x, y));
    const t2 = angle * angle;
    const scale = (angle * (1 - 0.02 * t2 + 0.004 * t2 ** 2 - 0.001 * t2 ** 3)) / Math.hypot(x, y);
    const found = pixelRay(cameraOf({ d, distortion: "equidistant" }), ...pixelOf(x * scale, y * scale));
    expect(found[0]).toBeCloseTo(x, 6);
    expect(found[1]).toBeCloseTo(y, 6);
  });

  it("of numbers that no lens has stays finite", () => {
    for (const d of [[50, -900, 3, 3, 9000], [-40, 0, 0, 0]]) {
      for (const distortion of ["plumb_bob", "equidistant"]) expect(pixelRay(cameraOf({ d, distortion }), 5000, -7000).every(Number.isFinite)).toBe(true);
    }
  });
});

describe("the plane of a picture", () => {
  it("has the picture's upper left where the camera sees it: left and up, ahead along z", () => {
    const { corners, triangles, parts } = picturePlane(cameraOf({}), 2);
    expect(corners[0][0]).toBeCloseTo((-320 / 500) * 2, 5);
    expect(corners[0][1]).toBeCloseTo((-240 / 510) * 2, 5);
    expect(corners[2][0]).toBeCloseTo((320 / 500) * 2, 5);
    expect(corners.map(([, , z]) => z)).toEqual([2, 2, 2, 2]);
    expect(triangles).toHaveLength(6);
    expect([...parts]).toEqual([0, 0, 1, 0, 0, 1, 1, 1]);
  });

  it("shows what is sent of a picture where that looks", () => {
    const { corners } = picturePlane(cameraOf({ region: { x: 320, y: 240, width: 320, height: 240 } }), 1);
    expect(corners[0][0]).toBeCloseTo(0, 6);
    expect(corners[0][1]).toBeCloseTo(0, 6);
    expect(corners[2][0]).toBeCloseTo(320 / 500, 5);
  });

  it("is bent where the lens is", () => {
    const { positions, triangles } = picturePlane(cameraOf({ d: [-0.3, 0.1, 0, 0, 0] }), 1);
    expect(positions).toHaveLength(3 * 13 * 13);
    expect(Math.max(...triangles)).toBe(13 * 13 - 1);
    // A barrel's corners look farther out than a pinhole's.
    expect(positions[0]).toBeLessThan(-320 / 500);
  });

  it("is the same for messages that agree in all that makes it", () => {
    expect(planeKey(cameraOf({ timeUs: 1 }))).toBe(planeKey(cameraOf({ timeUs: 2 })));
    expect(planeKey(cameraOf({ d: [0.1] }))).not.toBe(planeKey(cameraOf({})));
  });
});
