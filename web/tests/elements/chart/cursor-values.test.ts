import { describe, expect, it } from "vitest";
import type { ChartSeries } from "../../../src/elements/chart/chart-model.js";
import { momentText, cursorValue } from "../../../src/elements/chart/cursor-values.js";
import { Trace } from "../../../src/series/trace.js";

function series(samples: readonly (readonly [number, number])[], states: readonly string[] = []): ChartSeries {
  const trace = new Trace(1e12, 5e6);
  for (const [time, value] of samples) trace.addSample(time, value);
  return { address: "a", name: "A", unit: "m", decimals: 1, colour: 0, samples: trace, states, gaps: [], stale: false };
}

describe("the value at the cursor", () => {
  it("is the nearest one, and none when none is near", () => {
    const line = series([[1e6, 1], [2e6, 2], [9e6, 9]]);
    expect(cursorValue(line, 1.4e6, 1000, 1e6)).toMatchObject({ timeUs: 1e6, text: "1.0\u202fm" });
    expect(cursorValue(line, 1.6e6, 1000, 1e6)).toMatchObject({ timeUs: 2e6, text: "2.0\u202fm" });
    expect(cursorValue(line, 5e6, 1000, 1e6)).toMatchObject({ timeUs: NaN, text: "–" });
    expect(cursorValue(series([]), 5e6, 1000, 1e6).text).toBe("–");
  });

  it("says from where to where, when one pixel holds many", () => {
    expect(cursorValue(series([[1e6, 1], [1.1e6, 3], [1.2e6, 8]]), 1e6, 1e6, 1e6).text).toBe("4.0\u202fm (1.0 … 8.0)");
  });

  it("is the state that held then, for no longer than it is known to hold", () => {
    const door = series([[1e6, 0], [2e6, 1]], ["open", "closed"]);
    expect([1e6, 1.9e6, 2e6, 6.9e6, 7.1e6, 0.5e6].map((us) => cursorValue(door, us, 1, 1).text)).toEqual([
      "open", "open", "closed", "closed", "–", "–",
    ]);
  });

  it("has its moment as finely as the window shows it", () => {
    const at = Date.parse("2026-11-21T10:05:09.250Z") * 1000;
    expect(momentText(at, "Europe/Madrid", 30e6)).toBe("11:05:09.250");
    expect(momentText(at, "Europe/Madrid", 3600e6)).toBe("11:05:09");
    expect(momentText(at, "Europe/Madrid", 2 * 86_400e6)).toBe("21 Nov 2026, 11:05:09");
  });
});
