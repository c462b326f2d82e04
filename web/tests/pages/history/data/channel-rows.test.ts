import { describe, expect, it } from "vitest";
import { firstChoice, channelRows, groupChannels } from "../../../../src/pages/history/data/channel-rows.js";
import type { SignalShape, SiteShape, StoredShape } from "../../../../src/generated/api.js";

function signal(id: string, change: Partial<SignalShape> = {}): SignalShape {
  return {
    id, address: `base/${id}`, name: id, type: "number", role: "none", unit: "m", decimals: -1, minimum: null, maximum: null, shown: null,
    states: [], meanings: [], frame: "local", max_age: 5, primary: true, public: false, ros: "", channels: [`base/${id}`], ...change,
  };
}
const DETAIL: SiteShape = {
  site: "agv", name: "A", zone: "UTC", online: true, catalogue: "1", since_us: 0, place: null, rules: [], enclosures: [], shown_units: {}, map: null, last_seen_us: 0,
  devices: [
    {
      id: "base", name: "Base", kind: "vehicle", streams: [], commands: [], drive: null, public: false, link_loss: "", pointing: null, slew: null, unguarded: false, rights: [],
      signals: [
        signal("left"),
        signal("volt", { unit: "V", primary: false }),
        signal("right"),
        signal("mode", { type: "state", unit: "", states: ["off", "on"] }),
        signal("pose", { type: "position", unit: "", channels: ["base/pose.x", "base/pose.yaw"], primary: false }),
        signal("count", { unit: "" }),
      ],
    },
  ],
};
describe("rows of the history page", () => {
  it("share a chart when they share a unit, and states and unitless numbers stand alone", () => {
    const groups = groupChannels(channelRows(DETAIL)).map(({ title, rows }) => [title, rows.map(({ address }) => address)]);
    expect(groups).toEqual([
      ["m", ["base/left", "base/right", "base/pose.x"]],
      ["V", ["base/volt"]],
      ["mode", ["base/mode"]],
      ["rad", ["base/pose.yaw"]],
      ["", ["base/count"]],
    ]);
  });

  it("share a chart with other units when asked to, at most so many units in one", () => {
    const groups = (axes: number): [string, readonly string[]][] =>
      groupChannels(channelRows(DETAIL), axes).map(({ title, rows }) => [title, rows.map(({ address }) => address)]);
    expect(groups(4)).toEqual([
      ["m, V, rad, no unit", ["base/left", "base/right", "base/pose.x", "base/volt", "base/pose.yaw", "base/count"]],
      ["mode", ["base/mode"]],
    ]);
    expect(groups(2).map(([title]) => title)).toEqual(["m, V", "rad, no unit", "mode"]);
  });

  it("show last what is no longer described, as what it was, and nothing twice", () => {
    const was = { described: false, samples: 3, first_us: 1, last_us: 3, decimals: -1 };
    const former: StoredShape[] = [
      { ...was, address: "base/left", name: "left", type: "number", unit: "m", states: [] },
      { ...was, address: "base/gear", name: "Gear", type: "state", unit: "", states: ["low", "high"] },
      { ...was, address: "arm/place.yaw", name: "Place", type: "position", unit: "", states: [] },
      { ...was, address: "arm/old", name: "", type: "", unit: "", states: [] },
    ];
    const rows = channelRows(DETAIL, former);
    expect(rows.filter((row) => row.former).map(({ address, name, type, unit, device }) => [address, name, type, unit, device.name])).toEqual([
      ["base/gear", "Gear", "state", "", "Base"],
      ["arm/place.yaw", "Place, yaw", "number", "rad", "arm"],
      ["arm/old", "arm/old", "number", "", "arm"],
    ]);
    expect(rows.filter(({ address }) => address === "base/left")).toHaveLength(1);
    expect(firstChoice(rows)).toEqual(["base/left", "base/right"]);
  });

  it("begin with the first main numbers", () => {
    expect(firstChoice(channelRows(DETAIL))).toEqual(["base/left", "base/right"]);
    expect(firstChoice([])).toEqual([]);
  });
});
