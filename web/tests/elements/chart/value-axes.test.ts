import { describe, expect, it } from "vitest";
import { ValueAxes } from "../../../src/elements/chart/value-axes.js";
import { indentOf, type ChartSeries } from "../../../src/elements/chart/chart-model.js";
import { Trace } from "../../../src/series/trace.js";

const AXIS = { limits: { minimum: null, maximum: null }, least: 0 };
const SPAN = { fromUs: 0, toUs: 10e6 };

function series(address: string, unit: string, values: readonly number[], change: Partial<ChartSeries> = {}): ChartSeries {
  const samples = new Trace(Infinity, 5e6);
  values.forEach((value, i) => {
    samples.addSample(i * 1e6, value);
  });
  return { address, name: address, unit, decimals: -1, colour: 0, samples, states: [], gaps: [], stale: false, ...change };
}

describe("value axes", () => {
  const volts = series("v", "V", [11, 12], { colour: 2 });
  const fast = series("a", "m/s", [0, 100]);
  const slow = series("b", "m/s", [-100, 0]);

  it("are one for all numbers, unless each unit is to have its own", () => {
    const axes = new ValueAxes([volts, fast], false, AXIS);
    expect(axes.looks).toEqual([{ title: "", colour: -1 }]);
    expect(axes.axisRanges([volts, fast], SPAN, 1)).toHaveLength(1);
    const many = new ValueAxes([volts, fast, slow], true, AXIS);
    expect(many.looks).toEqual([{ title: "V", colour: 2 }, { title: "m/s", colour: -1 }]);
    const [v, speed] = many.axisRanges([volts, fast, slow], SPAN, 1);
    expect(v?.low).toBeGreaterThan(10);
    expect(v?.high).toBeLessThan(13);
    expect(speed?.low).toBeLessThanOrEqual(-100);
    expect([volts, fast, slow].map((series) => many.axisIndex(series))).toEqual([0, 1, 1]);
  });

  it("are none beside states, and cover what another day holds", () => {
    expect(new ValueAxes([series("s", "", [0, 1], { states: ["off", "on"] })], true, AXIS).looks).toEqual([]);
    const then = series("v", "V", [30, 40]);
    const both = { ...volts, ghost: { samples: then.samples, shiftUs: 0 } };
    expect(new ValueAxes([both], false, AXIS).axisRanges([both], SPAN, 1)[0]?.high).toBeGreaterThanOrEqual(40);
  });

  it("take turns left and right, and leave a little room where there is none", () => {
    expect([0, 1, 2, 4].map((axes) => indentOf(axes, 50))).toEqual([
      { left: 10, right: 10 }, { left: 50, right: 10 }, { left: 50, right: 50 }, { left: 100, right: 100 },
    ]);
  });
});
