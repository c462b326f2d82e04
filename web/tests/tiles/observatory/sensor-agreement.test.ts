import { describe, expect, it } from "vitest";
import { sensorsDisagree, type RoofSensor } from "../../../src/tiles/observatory/sensor-agreement.js";

const says = (...closed: (boolean | null)[]): RoofSensor[] => closed.map((closed) => ({ name: "sensor", word: String(closed), closed: closed }));

describe("sensorsDisagree", () => {
  it("hears a shell whose end switch and encoder contradict each other", () => {
    expect(sensorsDisagree(says(false), [says(true, false), says(true, true)])).toBe(true);
  });

  it("hears a roof that says closed above a shell that says open", () => {
    expect(sensorsDisagree(says(true), [says(false), says(true)])).toBe(true);
  });

  it("takes one open shell below a roof that says open for agreement", () => {
    expect(sensorsDisagree(says(false), [says(false), says(true)])).toBe(false);
  });

  it("takes silence for no contradiction", () => {
    expect(sensorsDisagree(says(true, null), [says(null), says(true)])).toBe(false);
    expect(sensorsDisagree(says(true), [])).toBe(false);
  });

  it("lets a flap be open by itself, and hears when its own sensors contradict each other", () => {
    expect(sensorsDisagree(says(true), [], [says(false)])).toBe(false);
    expect(sensorsDisagree(says(true), [], [says(false, true)])).toBe(true);
  });
});
