import { expect, test } from "vitest";
import { CATALOG, commandsShownBy, deviceTile, firstPageOf, firstPageSignals, signalsFor, summarySignals } from "../../src/tiles/catalog.js";
import type { ArgumentShape, CommandRole, CommandShape, DeviceShape, SignalRole, SignalShape } from "../../src/generated/api.js";
import { argument, command, device, signal, state } from "./observatory/described.js";

const has = (id: string, role: SignalRole, more: Partial<SignalShape> = {}): SignalShape => signal(id, { role, ...more });
const does = (id: string, role: CommandRole, args: readonly ArgumentShape[] = []): CommandShape => command(id, args, { role });
const ids = (found: readonly { readonly id: string }[]): readonly string[] => found.map(({ id }) => id);
const shownBy = (found: DeviceShape): readonly string[] => [...commandsShownBy(found)];

test("each row that draws makes its own element known", async () => {
  for (const [kind, { load }] of Object.entries(CATALOG)) {
    await load?.();
    expect(customElements.get(`t-part-${kind}`) !== undefined, kind).toBe(load !== null);
  }
});

test("a tile goes by the kind and the roles of a device, never by what it is called", () => {
  const roof = [has("roof", "dome.shutter")];
  expect(deviceTile(device("dome", roof, [], { id: "telescope", name: "Telescope" }))).toBe(CATALOG.dome);
  expect(deviceTile(device("other", roof))).toBeNull();
  expect(deviceTile(device("dome", [state("shutter", ["closed", "open"])]))).toBeNull();
  expect(deviceTile(device("weather", []))).toBe(CATALOG.weather);
});

test("a roof that slides away needs no azimuth", () => {
  expect(deviceTile(device("dome", [has("roof", "dome.shutter")]))).toBe(CATALOG.dome);
});

test("a camera that takes exposures has another page than one that only watches", () => {
  const takes = device("camera", [], [does("expose", "camera.expose", [argument("seconds", { unit: "s" })])]);
  expect(deviceTile(takes)?.showsStreams).toBe(true);
  expect(deviceTile(device("camera", []))).toBeNull();
});

test("what a tile does not show stands below: no command is lost", () => {
  const dome = device("dome", [has("roof", "dome.shutter")], [does("obre", "dome.open"), does("poleix", "none"), does("mou", "telescope.park")]);
  expect(shownBy(dome)).toEqual(["obre"]);
  expect(shownBy({ ...dome, kind: "other" })).toEqual([]);
  const power = device("power", [has("a", "power.outlet")], [does("a", "power.switch"), does("hidden", "power.switch"), does("b_on", "power.on")]);
  expect(shownBy(power)).toEqual(["a"]);
});

test("a device is summed up by its roles, the first that is there at each place", () => {
  const whole = [has("s", "telescope.state"), has("p", "telescope.parked"), has("t", "telescope.tracking"), has("r", "telescope.ra"), has("d", "telescope.dec")];
  expect(ids(summarySignals(device("telescope", whole)))).toEqual(["s", "r", "d"]);
  expect(ids(summarySignals(device("telescope", whole.slice(1))))).toEqual(["p", "t", "r", "d"]);
  const power = [has("v", "battery.voltage"), has("l", "battery.level"), has("w", "power.total"), has("o", "power.outlet")];
  expect(ids(summarySignals(device("power", power)))).toEqual(["w", "v", "l"]);
  const weather = [has("t", "weather.temperature"), has("g", "weather.gust"), has("w", "weather.wind"), has("r", "weather.raining")];
  expect(ids(summarySignals(device("weather", weather)))).toEqual(["r", "w", "t"]);
});

test("a device of no drawn kind is summed up by its primary signals", () => {
  const found = [signal("a"), signal("b", { primary: false }), signal("c", { type: "position" }), signal("d"), signal("e"), signal("f")];
  expect(ids(summarySignals(device("vehicle", found)))).toEqual(["a", "d", "e"]);
});

test("the first page begins with what tells most of a device, and shows nothing that is not primary", () => {
  const dome = device("dome", [signal("battery"), signal("said", { type: "text" }), has("roof", "dome.shutter"), has("turn", "dome.azimuth", { primary: false })]);
  expect(ids(firstPageSignals(dome, 6))).toEqual(["roof", "battery"]);
  expect(ids(firstPageSignals(dome, 1))).toEqual(["roof"]);
  const vehicle = device("vehicle", ["a", "b", "c", "d"].map((id) => signal(id)));
  expect(ids(firstPageSignals(vehicle, 6))).toEqual(["a", "b", "c", "d"]);
});

test("several devices take turns on the first page, without positions and minor ones", () => {
  const first = device("other", [signal("a1"), signal("a2", { primary: false }), signal("a3"), signal("a4")]);
  const second = device("other", [signal("b1", { type: "position" }), signal("b2")]);
  expect(ids(firstPageOf([first, second], 3))).toEqual(["a1", "b2", "a3"]);
  expect(firstPageOf([], 4)).toEqual([]);
});

test("an administrator's tile asks for a role, a unit, a type or an id", () => {
  const tile = (wanted: object): Parameters<typeof signalsFor>[0] => ({
    name: "gauge", title: "Gauge", module: "m", device: "weather", signals: [{ name: "own", type: "", unit: "", id: "", role: "", ...wanted }],
  });
  const station = device("weather", [has("ratxa", "weather.gust", { unit: "km/h" }), has("vent", "weather.wind", { unit: "km/h" })]);
  expect(signalsFor(tile({ role: "weather.wind" }), station)?.get("own")?.id).toBe("vent");
  expect(signalsFor(tile({ unit: "km/h" }), station)?.get("own")?.id).toBe("ratxa");
  expect(signalsFor(tile({ role: "weather.wind", unit: "m/s" }), station)).toBeNull();
  expect(signalsFor(tile({ role: "weather.wind" }), { ...station, kind: "dome" })).toBeNull();
});
