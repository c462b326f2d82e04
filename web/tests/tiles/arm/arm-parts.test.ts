import { describe, expect, test } from "vitest";
import type { ArgumentShape, CommandShape, DeviceShape, SignalShape } from "../../../src/generated/api.js";
import { armParts, isNearEnd, jogButtons, jointShare } from "../../../src/tiles/arm/arm-parts.js";
import { NO_DEVICE } from "../../../src/tiles/observatory/device-part.js";

function joint(id: string, more: Partial<SignalShape> = {}): SignalShape {
  return {
    id, address: `arm/${id}`, name: id, type: "number", role: "none", unit: "rad", decimals: 2, minimum: -3.1, maximum: 3.1, states: [], meanings: [],
    frame: "", max_age: 1, primary: true, public: false, ros: "", channels: [`arm/${id}`], shown: null, ...more,
  };
}
function axis(id: string, most: number, more: Partial<ArgumentShape> = {}): ArgumentShape {
  return { id, name: id, type: "number", unit: "m/s", minimum: -most, maximum: most, max_length: 0, default: 0, ...more };
}
function command(id: string, args: readonly ArgumentShape[] = [], more: Partial<CommandShape> = {}): CommandShape {
  return { id, name: id, role: "none", description: "", confirm: true, timeout: 5, cancellable: true, arguments: args, needs: null, ros: "", ...more };
}
const JOG = command("jog", [axis("linear_x", 0.05), axis("linear_z", 0.04), axis("angular_z", 0.2)]);
const ARM: DeviceShape = {
  ...NO_DEVICE,
  id: "arm",
  signals: [joint("shoulder"), joint("elbow"), joint("slide", { unit: "m", minimum: 0, maximum: 0.4 }), joint("load", { unit: "%" }), joint("wheel", { minimum: null, maximum: null })],
  commands: [JOG, command("to_arm_home"), command("to_arm_ready"), command("speed", [axis("value", 1)]), command("configure", [], { ros: "lifecycle" })],
};

describe("an arm is known by what it has", () => {
  test("joints with both ends, a jog, and commands without arguments", () => {
    const parts = armParts(ARM);
    expect(parts?.joints.map(({ id }) => id)).toEqual(["shoulder", "elbow", "slide"]);
    expect(parts?.jog?.id).toBe("jog");
    expect(parts?.poses.map(({ id }) => id)).toEqual(["to_arm_home", "to_arm_ready"]);
  });

  test("wheels that steer have both ends, and are no arm", () => {
    expect(armParts({ ...ARM, signals: [joint("steering_left_position"), joint("steering_right_position"), joint("caster")] })).toBeNull();
  });

  test("sensors of distance have both ends, and are no arm, unless a jog moves what they tell", () => {
    const sensors = ["left", "front", "right"].map((id) => joint(id, { unit: "m", minimum: 0, maximum: 4 }));
    expect(armParts({ ...ARM, signals: sensors, commands: [] })).toBeNull();
    expect(armParts({ ...ARM, signals: sensors })?.joints).toHaveLength(3);
  });

  test("one joint makes no arm, and what drives or is an instrument is none", () => {
    expect(armParts({ ...ARM, signals: [joint("valve")] })).toBeNull();
    expect(armParts({ ...ARM, kind: "telescope" })).toBeNull();
    const drive = { max_sideways: 0, max_steering: 0, joints: [], ptz: false, max_speed: 1, max_reverse: 1, max_turn: 1, rate: 20, ttl: 0.25, lease: 3, picture: "", position: "", stop: true, shown_speed: null, shown_turn: null };
    expect(armParts({ ...ARM, drive })).toBeNull();
    const elbow = { id: "elbow", name: "Elbow", max_speed: 0.2, minimum: null, maximum: null, position: "", slides: false };
    expect(armParts({ ...ARM, drive: { ...drive, max_speed: 0, joints: [elbow] } })?.device.id).toBe(ARM.id);
  });

  test("a jog goes both ways on each axis and rests where nothing is said", () => {
    for (const bad of [axis("linear_x", 1, { default: 0.1 }), axis("linear_x", 1, { minimum: 0 }), axis("speed", 1), axis("linear_x", 1, { type: "text" })]) {
      expect(armParts({ ...ARM, commands: [command("jog", [bad])] })?.jog).toBeNull();
    }
  });
});

test("a step moves one axis by a share of what is allowed, and holds the others still", () => {
  const buttons = jogButtons(JOG, 0.1);
  expect(buttons.map(({ label }) => label)).toEqual(["Move +x", "Move −x", "Move +z", "Move −z", "Turn +z", "Turn −z"]);
  expect(buttons[1]?.args["linear_x"]).toBeCloseTo(-0.005);
  for (const { args } of buttons) expect(Object.values(args).filter((value) => value !== 0)).toHaveLength(1);
});

test("a joint stands between its ends, and an end that is near is told", () => {
  const ends = { minimum: -1, maximum: 3 };
  expect([-1, 1, 3, 9].map((value) => jointShare(ends, value))).toEqual([0, 0.5, 1, 1]);
  expect(jointShare(ends, Number.NaN)).toBeNaN();
  expect([0.02, 0.5, 0.97, Number.NaN].map(isNearEnd)).toEqual([true, false, true, false]);
});
