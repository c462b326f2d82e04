import { describe, expect, it } from "vitest";
import type { JsonObject } from "../../../src/pages/description/json-schema.js";
import { newSensorOf, newSensorPath, readNewSensor, withSensor } from "../../../src/pages/description/new-sensor.js";

const ROW = { kind: "new_sensor", device: "base", message: "/metric: wheel & 2 is not in the description" };
const WHEEL = { name: "Wheel", source: { topic: "/metric", type: "std_msgs/msg/String", name: "wheel1" } };
const SITE: JsonObject = { name: "S", devices: { base: { name: "Base", signals: { wheel1: WHEEL } }, arm: { name: "Arm" } } };
const SENSOR = { site: "agv", device: "base", topic: "/metric", name: "wheel & 2" };

describe("A sensor that no signal is of", () => {
  it("is found in its line of the logbook, and comes through an address", () => {
    expect(newSensorOf("agv", ROW)).toEqual(SENSOR);
    expect(newSensorOf("agv", { ...ROW, kind: "unreadable" })).toBeNull();
    expect(newSensorOf("agv", { ...ROW, message: "wheel2 is not in the description" })).toBeNull();
    const path = newSensorPath(SENSOR);
    expect(readNewSensor(path.slice(path.indexOf("?")))).toEqual(SENSOR);
    expect(readNewSensor("?site=agv&device=base")).toBeNull();
    expect(readNewSensor("")).toBeNull();
  });

  it("becomes a signal beside those of its topic, with their type", () => {
    const made = withSensor(SITE, SENSOR);
    expect(made).toEqual({
      ...SITE,
      devices: {
        arm: { name: "Arm" },
        base: { name: "Base", signals: { wheel1: WHEEL, wheel_2: { name: "Wheel & 2", source: { ...WHEEL.source, name: "wheel & 2" } } } },
      },
    });
    expect(withSensor(made, SENSOR)).toBe(made);
  });

  it("changes nothing where there is no place for it", () => {
    expect(withSensor(SITE, { ...SENSOR, device: "arm" })).toBe(SITE);
    expect(withSensor(SITE, { ...SENSOR, device: "constructor" })).toBe(SITE);
    expect(withSensor(SITE, { ...SENSOR, topic: "/other" })).toBe(SITE);
  });
});
