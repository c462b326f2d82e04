import { describe, expect, it } from "vitest";
import { boardDevice, findCommand, findSignal, findStreams, type BoardSubjects } from "../../src/boards/references.js";
import type { CommandShape, DeviceShape, SignalShape, SiteShape, StreamShape } from "../../src/generated/api.js";

const signal = (device: string, id: string, role = ""): SignalShape => ({ id, address: `${device}/${id}`, role, channels: [`${device}/${id}`] }) as unknown as SignalShape;
const device = (id: string, kind: string, signals: readonly SignalShape[]): DeviceShape =>
  ({
    id, kind, signals,
    streams: [{ id: "front", address: `${id}/front` } as StreamShape],
    commands: [{ id: "dock", role: "" } as unknown as CommandShape],
  }) as unknown as DeviceShape;
const one = device("rover1", "vehicle", [signal("rover1", "level", "battery.level")]);
const two = device("rover2", "vehicle", [signal("rover2", "level", "battery.level"), signal("rover2", "speed")]);
const mast = device("mast", "weather", [signal("mast", "wind", "weather.wind")]);
const detail = { site: "yard", devices: [mast, one, two] } as unknown as SiteShape;
const at = (chosen: DeviceShape | null): BoardSubjects => ({ detail, device: chosen });

describe("what a tile names", () => {
  it("is one thing for each robot of a kind", () => {
    expect(findSignal("$device/level", at(one))?.address).toBe("rover1/level");
    expect(findSignal("$device/level", at(two))?.address).toBe("rover2/level");
    expect(findSignal("$device/speed", at(one))).toBeNull();
    expect(findCommand("$device/dock", at(two))?.device.id).toBe("rover2");
  });

  it("is found by its role, of the chosen device before all others", () => {
    expect(findSignal("@battery.level", at(two))?.address).toBe("rover2/level");
    expect(findSignal("@weather.wind", at(two))?.address).toBe("mast/wind");
    expect(findSignal("@dome.shutter", at(two))).toBeNull();
  });

  it("is what was named, or all cameras where none was", () => {
    expect(findStreams([], at(one))).toHaveLength(3);
    expect(findStreams(["mast/front", "gone/front"], at(one)).map(({ address }) => address)).toEqual(["mast/front"]);
  });

  it("begins with the device that is asked for, then the board's own, then the first of its kind", () => {
    expect(boardDevice(detail, "rover2", { device: "rover1", kind: "vehicle" })?.id).toBe("rover2");
    expect(boardDevice(detail, "gone", { device: "rover2", kind: "vehicle" })?.id).toBe("rover2");
    expect(boardDevice(detail, "", { device: "", kind: "vehicle" })?.id).toBe("rover1");
    expect(boardDevice(detail, "", { device: "", kind: "dome" })).toBeNull();
  });
});
