/** Judged by rosbags' serializer and scipy's rotations, whose numbers are in `recorded.json`. */

import { readFileSync } from "node:fs";
import { describe, expect, it } from "vitest";
import { MessageError, MessageReader } from "../../src/scene/cdr.js";
import { readCloud } from "../../src/scene/cloud.js";
import { FrameTree } from "../../src/scene/frame-tree.js";
import { readMarkers } from "../../src/scene/markers.js";
import { readJoints, readPath, readScan, readTransforms, scanPoints } from "../../src/scene/messages.js";
import { filledCommand } from "../../src/scene/pose-command.js";
import { applied, between, composed, inverted, turned, turnOfYaw, yawOf, type Quaternion, type Vector } from "../../src/scene/transform.js";
import type { CommandShape } from "../../src/generated/api.js";

interface Turn {
  readonly a: Quaternion;
  readonly at: Vector;
  readonly b: Quaternion;
  readonly bt: Vector;
  readonly point: Vector;
  readonly applied: Vector;
  readonly share: number;
  readonly mid: Vector;
  readonly back: Vector;
  readonly yaw: number;
}

const RECORDED = JSON.parse(readFileSync(new URL("recorded.json", import.meta.url), "utf8")) as Record<string, string> & { readonly turns: readonly Turn[] };
const STAMP_US = 1_780_000_000_500_000;

function bytesOf(name: string): Uint8Array {
  return Uint8Array.from(atob(RECORDED[name] ?? ""), (letter) => letter.charCodeAt(0));
}

function reader(name: string, encoding = "cdr"): MessageReader {
  return new MessageReader(bytesOf(name), encoding);
}

function close(found: readonly number[], wanted: readonly number[]): void {
  found.forEach((value, at) => {
    expect(value).toBeCloseTo(wanted[at] ?? Number.NaN, 9);
  });
}

describe("messages", () => {
  it("are read as rosbags has written them", () => {
    const [first, second] = readTransforms(reader("tf"));
    expect(second).toEqual(first);
    expect(first).toEqual({ timeUs: STAMP_US, frame: "odom", child: "base_link", transform: { at: [1, 2, 3], turn: [0, 0, 0.6, 0.8] } });
    const points = scanPoints(readScan(reader("scan")));
    // What met nothing, or was too near, is left out.
    close([...points], [Math.cos(1), -Math.sin(1), 0, 2 * Math.cos(0.5), -2 * Math.sin(0.5), 0, 4 * Math.cos(1), 4 * Math.sin(1), 0].map(Math.fround));
    expect(readPath(reader("path")).poses).toHaveLength(3);
    const cloud = readCloud(reader("cloud"));
    expect(cloud.positions).toHaveLength(15);
    expect([...(cloud.rgb ?? [])].slice(0, 3)).toEqual([0x10, 0x20, 0x30]);
    expect([...(cloud.intensity ?? [])]).toEqual([0, 0.25, 0.5, 0.75, 1]);
    const markers = readMarkers(reader("markers"));
    expect(markers.map(({ key, kind, lifetimeMs, text }) => [key, kind, lifetimeMs, text])).toEqual([["n/7", "cube", 2500, "hi"], ["n/8", "sphere", 2500, "hi"]]);
  });

  it("of clouds are read alike, floats that lie well and any others", () => {
    // x, y and z of two points, and a third that is nowhere, as float32 and as float64.
    const numbers = [1, 2, 3, 4, 5, 6, Number.NaN, 0, 0];
    for (const [datatype, size] of [[7, 4], [8, 8]] as const) {
      const read = readCloud(new MessageReader(cloudBytes(numbers, datatype, size), "cdr"));
      expect([...read.positions]).toEqual([1, 2, 3, 4, 5, 6]);
      expect(read.intensity).toBeNull();
    }
  });

  it("of ROS 1 are packed without gaps, and names begin with no slash", () => {
    expect(readJoints(reader("joints_ros1", "ros1"))).toEqual({ timeUs: STAMP_US, frame: "base", names: ["a", "bc"], positions: [0.25, -1.5] });
  });

  it("that end too early, or say more than they hold, are refused", () => {
    for (const name of ["tf", "scan", "path", "cloud", "markers"]) {
      const bytes = bytesOf(name);
      for (const length of [0, 3, 5, 20, bytes.length >> 1]) {
        const read = { tf: readTransforms, scan: readScan, path: readPath, cloud: readCloud, markers: readMarkers }[name];
        expect(() => read?.(new MessageReader(bytes.subarray(0, length), "cdr"))).toThrow(MessageError);
      }
    }
  });
});

describe("turns", () => {
  it.each(RECORDED.turns.map((turn, at) => [at, turn] as const))("are scipy's (%i)", (_, { a, at, b, bt, point, applied: wanted, share, mid, back, yaw }) => {
    const [first, second] = [{ at, turn: a }, { at: bt, turn: b }];
    close(applied(composed(first, second), point), wanted);
    close(applied(inverted(first), point), back);
    close(turned(between(first, second, share).turn, point), mid);
    expect(yawOf(a)).toBeCloseTo(yaw, 9);
  });
});

describe("the tree of frames", () => {
  const add = (tree: FrameTree, parent: string, child: string, timeUs: number, x: number, more: object = {}): void => {
    tree.add({ parent, child, timeUs, transform: { at: [x, 0, 0], turn: turnOfYaw(0) }, source: "tf", fixed: false, ...more }, timeUs / 1000);
  };

  it("knows where a frame was between two moments, and holds the ends", () => {
    const tree = new FrameTree();
    add(tree, "odom", "base", 1e6, 1);
    add(tree, "odom", "base", 2e6, 3);
    add(tree, "base", "laser", 0, 0.5, { fixed: true });
    expect([0, 1.25e6, 9e6].map((timeUs) => tree.find("odom", "laser", timeUs)?.at[0])).toEqual([1.5, 2, 3.5]);
    close(tree.find("laser", "odom", 2e6)?.at ?? [], [-3.5, 0, 0]);
    expect(tree.find("map", "base", 0)).toBeNull();
    expect(tree.rows(3000).map(({ name, age, depth }) => [name, age, depth])).toEqual([["odom", null, 0], ["base", 1, 1], ["laser", 3, 2]]);
  });

  it("believes transforms before odometry, whatever comes later, and makes no circle", () => {
    const tree = new FrameTree();
    add(tree, "odom", "base", 1e6, 1);
    add(tree, "odom", "base", 2e6, 9, { source: "odometry" });
    add(tree, "base", "odom", 2e6, 9);
    expect(tree.find("odom", "base", 5e6)?.at[0]).toBe(1);
    add(tree, "odom", "base", 3e6, Number.NaN);
    expect(tree.find("odom", "base", 5e6)?.at[0]).toBe(1);
  });

  it("begins anew when the robot's clock is set back", () => {
    const tree = new FrameTree();
    add(tree, "odom", "base", 100e6, 1);
    add(tree, "odom", "base", 5e6, 2);
    expect(tree.find("odom", "base", Infinity)?.at[0]).toBe(2);
  });
});

it("a place fills a command's arguments in its own units", () => {
  const argument = (id: string, unit = ""): object => ({ id, unit, name: "", type: "number", minimum: null, maximum: null, max_length: 0, default: null });
  const command = { arguments: [argument("x"), argument("yaw", "°"), argument("qz"), argument("speed"), argument("frame")] } as unknown as CommandShape;
  const filled = filledCommand(command, { frame: "map", x: 1.23456, y: 0, yaw: Math.PI / 2 });
  expect(filled.arguments.map(({ default: value }) => value)).toEqual([1.235, 90, 0.707, null, "map"]);
});

/** A cloud of one row without a frame, as CDR. */
function cloudBytes(numbers: readonly number[], datatype: number, size: number): Uint8Array {
  const bytes: number[] = [];
  const number32 = (value: number): void => {
    while (bytes.length % 4 !== 0) bytes.push(0);
    bytes.push(...new Uint8Array(new Uint32Array([value]).buffer));
  };
  [0, 0, 1].forEach(number32);
  bytes.push(0);
  [1, numbers.length / 3, 3].forEach(number32);
  ["x", "y", "z"].forEach((name, at) => {
    number32(2);
    bytes.push(name.charCodeAt(0), 0);
    number32(at * size);
    bytes.push(datatype);
    number32(1);
  });
  bytes.push(0);
  [3 * size, numbers.length * size, numbers.length * size].forEach(number32);
  const data = size === 4 ? new Float32Array(numbers) : new Float64Array(numbers);
  return new Uint8Array([0, 1, 0, 0, ...bytes, ...new Uint8Array(data.buffer), 1]);
}
