import { describe, expect, it } from "vitest";
import { devicesOf, proposeSignal, signalOf, withSignal, type TopicField } from "../../../src/pages/topics/new-signal.js";

const DESCRIBED = {
  site: "kitchen",
  devices: {
    fridge: { name: "Fridge" },
    oven: {
      name: "Oven",
      signals: {
        heat: { name: "Heat", source: { topic: "/oven/bake", type: "kitchen/msg/Bake", field: "celsius" } },
      },
    },
  },
};
const FIELD: TopicField = { topic: "/oven/bake", type: "kitchen/msg/Bake", field: "shelves[1].celsius", text: false };

describe("a field that becomes a signal", () => {
  it("is proposed for the device that has the topic already", () => {
    expect(proposeSignal(DESCRIBED, FIELD).device).toBe("oven");
    expect(proposeSignal(DESCRIBED, { ...FIELD, topic: "/new" }).device).toBe("fridge");
  });

  it("is named by its path, or by its topic where its path says nothing", () => {
    expect(proposeSignal(DESCRIBED, FIELD).name).toBe("Shelves 1 celsius");
    expect(proposeSignal(DESCRIBED, { ...FIELD, topic: "/oven/fan_speed", field: "data" }).name).toBe("Fan speed");
    expect(proposeSignal(DESCRIBED, { ...FIELD, field: "pose.pose.position.x" }).name).toBe("Pose position x");
  });

  it("stands in the description with a key that no other signal of the device has", () => {
    const said = { device: "oven", name: "Heat", unit: "°C" };
    const made = withSignal(DESCRIBED, FIELD, said) as typeof DESCRIBED;
    expect(made.devices.oven.signals).toStrictEqual({
      ...DESCRIBED.devices.oven.signals,
      heat2: { name: "Heat", unit: "°C", source: { topic: "/oven/bake", type: "kitchen/msg/Bake", field: "shelves[1].celsius" } },
    });
    expect(made.devices.fridge).toBe(DESCRIBED.devices.fridge);
  });

  it("has no unit where none is said, and is a text where it holds words", () => {
    const made = withSignal(DESCRIBED, { ...FIELD, field: "recipe", text: true }, { device: "fridge", name: "Recipe", unit: "" });
    expect(made).toMatchObject({ devices: { fridge: { signals: { recipe: { name: "Recipe", type: "text" } } } } });
    expect(JSON.stringify(made)).not.toContain('"unit"');
  });

  it("is told by name when it is a signal already", () => {
    expect(signalOf(DESCRIBED, { ...FIELD, field: "celsius" })).toBe("Heat");
    expect(signalOf(DESCRIBED, FIELD)).toBe("");
  });

  it("has nowhere to go in a description without devices", () => {
    expect(devicesOf({ site: "kitchen" })).toStrictEqual([]);
    expect(proposeSignal({ site: "kitchen" }, FIELD).device).toBe("");
  });
});
