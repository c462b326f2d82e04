import { expect, test } from "vitest";
import { witnessState } from "../../../src/pages/audit/witness-state.js";

const HOUR_US = 3_600_000_000;

test("a hub that stays silent for hours never looks well, and one that does not fit is said first", () => {
  expect(witnessState({ problem: "", heard_us: 0 }, HOUR_US).kind).toBe("unknown");
  expect(witnessState({ problem: "", heard_us: HOUR_US }, 2 * HOUR_US).kind).toBe("ok");
  expect(witnessState({ problem: "", heard_us: HOUR_US }, 5 * HOUR_US).word).toBe("silent");
  expect(witnessState({ problem: "row 9", heard_us: HOUR_US }, 9 * HOUR_US).kind).toBe("bad");
});
