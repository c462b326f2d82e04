import { expect, test } from "vitest";
import type { InterlockUpdate } from "../../../src/generated/wire.js";
import { limitLines, rulesAbout, verdictOf, type KnownValue, type WeatherVerdict } from "../../../src/tiles/observatory/weather-verdict.js";
import type { LimitShape, RuleShape } from "../../../src/generated/api.js";
import { signal, state } from "./described.js";

const limit = (more: Partial<LimitShape>): LimitShape => ({
  signal: "it/wind", minus: "", humidity: "", above: null, until_below: null, below: null, until_above: null, states: [], safe_states: [], ...more,
});
const rule = (limits: readonly LimitShape[], lasting = 0): RuleShape => ({
  id: "weather", name: "Weather", conditions: [{ limits, lasting, link_lost: null, sun: "" }], hidden: 0, targets: [], dwell: 60,
});
const WIND = rule([limit({ above: 45, until_below: 35 })], 2);
const SIGNALS = [signal("wind", { unit: "km/h" }), state("rain", ["dry", "wet"])];
const said = (more: Partial<InterlockUpdate> = {}): InterlockUpdate => ({
  t: "interlock_news", site: "s", interlock: "weather", name: "Weather", locked: false, unsafe: false, why: "", since_us: 0,
  clears_ms: 0, refuses: [], targets: [], slows: [], slowed: [], overridable: false, overridden_by: "", reason: "", override_ms: 0, longest_s: 0,
  condition: "", no_override: "", unknown: [], ...more,
});
const wind = (value: number, fresh = true): ((of: { id: string }) => KnownValue) => ({ id }) =>
  id === "wind" ? { fresh, value, word: "" } : { fresh, value: 0, word: "dry" };

function judged(value: number, news: InterlockUpdate | undefined, fresh = true, online = true): WeatherVerdict {
  return verdictOf(online, [WIND], () => news, limitLines([WIND], "it", SIGNALS, wind(value, fresh)));
}

test("weather within its limits is safe, and says how near it is", () => {
  expect(judged(12, said())).toMatchObject({
    word: "safe",
    why: "Every value is within its limits. Nearest to its limit: wind, 12.0\u202fkm/h (unsafe above 45\u202fkm/h until below 35\u202fkm/h for 2 s).",
  });
});

test("it is unsafe by the gateway's word, with its reason, its rule and since when", () => {
  const news = said({ locked: true, unsafe: true, why: "wind is above 45 km/h", since_us: 7 });
  expect(judged(50, news)).toEqual({ word: "unsafe", why: "wind is above 45 km/h. Now 50.0\u202fkm/h.", since_us: 7, rule: "Weather" });
});

test("whoever is not told the reason sees the numbers", () => {
  expect(judged(50, said({ locked: true, unsafe: true })).why).toContain("wind: 50.0\u202fkm/h (closes above 45");
});

test.each([
  ["a value that is old", 12, said(), false, true],
  ["a gateway that has not spoken", 12, undefined, true, true],
  ["a site that is away", 12, said(), true, false],
])("%s is unknown, never safe", (_what, value, news, fresh, online) => {
  expect(judged(value, news, fresh, online).word).toBe("unknown");
});

test("unsafe because nobody knows is unknown, and says why", () => {
  const news = said({ locked: true, unsafe: true, why: "Wind is unknown" });
  expect(judged(12, news, false)).toMatchObject({ word: "unknown", why: "Wind is unknown." });
});

test("a fresh value that the gateway does not believe is unknown, and only that one", () => {
  const why = "Wind: exactly 12 km/h for 61 s, so it is frozen";
  const news = said({ locked: true, unsafe: true, why, unknown: ["it/wind"] });
  const both = rule([limit({ signal: "it/rain", states: ["wet"] })]);
  const rules = [{ ...WIND, conditions: [...WIND.conditions, ...both.conditions] }];
  const lines = limitLines(rules, "it", SIGNALS, wind(12), () => news);
  expect(lines.map(({ name, stands }) => [name, stands])).toEqual([["wind", "unknown"], ["rain", "fine"]]);
  expect(verdictOf(true, rules, () => news, lines)).toMatchObject({ word: "unknown", why: `${why}.` });
});

test("a difference is unknown where the gateway does not believe one of its two values", () => {
  const air = [signal("temperature", { unit: "°C" }), signal("dew_point", { unit: "°C" })];
  const dew = rule([limit({ signal: "it/temperature", minus: "it/dew_point", below: 2 })]);
  const news = said({ locked: true, unsafe: true, unknown: ["it/temperature+it/dew_point"] });
  const values = ({ id }: { id: string }): KnownValue => ({ fresh: true, value: id === "temperature" ? 15 : 5, word: "" });
  expect(limitLines([dew], "it", air, values, () => news)[0]).toMatchObject({ stands: "unknown" });
  expect(limitLines([dew], "it", air, values, () => said())[0]).toMatchObject({ stands: "fine" });
});

test("safe but not for long enough waits", () => {
  expect(judged(12, said({ locked: true })).word).toBe("wait");
});

test("a value beyond its limit that has not lasted yet is a warning", () => {
  expect(judged(50, said())).toMatchObject({ word: "warn", rule: "Weather" });
});

test("an override is never called safe", () => {
  expect(judged(12, said({ overridden_by: "ada" }))).toMatchObject({ word: "overridden", why: "ada has overridden Weather." });
});

test("without a rule there is no verdict", () => {
  expect(verdictOf(true, rulesAbout([WIND], "other"), () => undefined, []).word).toBe("none");
});

test("the limit that is broken stands first, and between the two limits it is near", () => {
  const both = rule([limit({ signal: "it/rain", states: ["wet"] }), limit({ above: 45, until_below: 35 })]);
  const lines = limitLines([both], "it", SIGNALS, ({ id }) =>
    id === "wind" ? { fresh: true, value: 40, word: "" } : { fresh: true, value: 1, word: "wet" },
  );
  expect(lines.map(({ name, stands, limit: said_ }) => [name, stands, said_.split(" until")[0]])).toEqual([
    ["rain", "beyond", "when wet"],
    ["wind", "returning", "above 45\u202fkm/h"],
  ]);
});

test("a state that is none of the safe ones is beyond", () => {
  const safety = rule([limit({ signal: "it/rain", safe_states: ["dry"] })]);
  const lines = limitLines([safety], "it", SIGNALS, () => ({ fresh: true, value: 1, word: "wet" }));
  expect(lines[0]).toMatchObject({ stands: "beyond", limit: "unless dry" });
});

test("a temperature is judged by how far it is from the dew point, given or computed", () => {
  const air = [signal("temperature", { unit: "°C" }), signal("dew_point", { unit: "°C" }), signal("humidity", { unit: "%" })];
  const values: Readonly<Record<string, number>> = { temperature: 15, dew_point: 13, humidity: 85 };
  const known = (silent: string) => ({ id }: { id: string }): KnownValue => ({ fresh: id !== silent, value: values[id] ?? 0, word: "" });
  for (const other of [{ minus: "it/dew_point" }, { humidity: "it/humidity" }]) {
    const single = rule([limit({ signal: "it/temperature", below: 3, until_above: 4, ...other })]);
    expect(limitLines([single], "it", air, known(""))[0]).toMatchObject({ stands: "beyond" });
    const silent = Object.values(other)[0]?.slice(3) ?? "";
    expect(limitLines([single], "it", air, known(silent))[0]).toMatchObject({ stands: "unknown", now: "unknown" });
  }
});
