import { expect, test } from "vitest";
import type { ArgumentShape, CommandRole, CommandShape, SignalRole, SignalShape } from "../../../src/generated/api.js";
import {
  angleText, cameraCommands, domeCommands, domeSignals, meaningOf, outletsOf, showsExposures, shutterOf, slewOf, telescopeCommands, telescopeSignals,
} from "../../../src/tiles/observatory/roles.js";
import { argument, command, device, signal, state } from "./described.js";

const has = (id: string, role: SignalRole, more: Partial<SignalShape> = {}): SignalShape => signal(id, { role, ...more });
const does = (id: string, role: CommandRole, args: readonly ArgumentShape[] = []): CommandShape => command(id, args, { role });
const active = [argument("active", { type: "boolean" })];

const catalanDome = device(
  "dome",
  [
    state("comporta", ["tancada", "oberta", "obrint-se", "tancant-se", "aturada", "avaria"], {
      role: "dome.shutter", meanings: ["closed", "open", "opening", "closing", "partial", "error"],
    }),
    has("obertura", "dome.opening", { unit: "%" }), has("gir", "dome.azimuth", { unit: "°" }),
    has("girant", "dome.turning", { type: "state" }), has("lloc", "dome.local", { type: "state" }), has("azimuth", "none", { unit: "°" }),
  ],
  [
    does("obre", "dome.open"), does("tanca", "dome.close"), does("atura", "dome.stop"), does("aparca", "dome.park"),
    does("gira", "dome.goto", [argument("graus", { unit: "°" })]), does("open", "none"),
  ],
);

test("a dome is read by its roles, whatever language it is described in", () => {
  const found = domeSignals(catalanDome);
  expect([found.shutter?.id, found.opening?.id, found.azimuth?.id, found.turning?.id, found.local?.id, found.parked]).toEqual([
    "comporta", "obertura", "gir", "girant", "lloc", undefined,
  ]);
});

test("a dome's buttons are those of its commands' roles, in the order that a hand expects", () => {
  const { buttons, forms } = domeCommands(catalanDome);
  expect(buttons.map(({ command: { id }, kind }) => [id, kind])).toEqual([
    ["obre", "plain"], ["tanca", "primary"], ["aparca", "plain"], ["atura", "danger"],
  ]);
  expect(forms.map(({ id }) => id)).toEqual(["gira"]);
});

test("a shutter is drawn by what its state means, and what none knows is unknown", () => {
  const { shutter } = domeSignals(catalanDome);
  expect([0, 1, 2, 3, 4, 5, 6, Number.NaN].map((value) => shutterOf(shutter, value))).toEqual([
    "closed", "open", "opening", "closing", "partial", "error", "unknown", "unknown",
  ]);
  expect(shutterOf(state("it", ["open"], { role: "dome.shutter" }), 0)).toBe("unknown");
  expect(shutterOf(state("it", ["x"], { meanings: ["exposing"] }), 0)).toBe("unknown");
});

test("a camera exposes when its state means so", () => {
  const camera = state("it", ["espera", "exposant"], { role: "camera.state", meanings: ["idle", "exposing"] });
  expect([0, 1, 2].map((value) => meaningOf(camera, value))).toEqual(["idle", "exposing", "unknown"]);
});

test("an English name without a role is no telescope's", () => {
  const angles = [signal("altitude", { unit: "°" }), has("alçada", "telescope.altitude", { unit: "°" })];
  expect(telescopeSignals(device("telescope", angles)).alt?.id).toBe("alçada");
});

test("the hub says which command points a telescope, by which arguments", () => {
  const slews = command("hin", [argument("a", { unit: "h" }), argument("d", { unit: "°" })]);
  const slew = { command: "hin", ra: "a", dec: "d", alt: "", az: "" };
  expect(slewOf(device("telescope", [], [slews], { slew }))).toMatchObject({ ra: "a", dec: "d", command: { id: "hin" } });
  expect(slewOf(device("telescope", [], [slews]))).toBeUndefined();
  expect(slewOf(device("telescope", [], [], { slew }))).toBeUndefined();
});

test("tracking is two buttons, of one switch or of two commands", () => {
  const one = device("telescope", [], [does("segueix", "telescope.track", active)]);
  const two = device("telescope", [], [does("segueix", "telescope.track"), does("deixa", "telescope.untrack")]);
  expect(telescopeCommands(one).map(({ args }) => args)).toEqual([{ active: true }, { active: false }]);
  expect(telescopeCommands(two).map(({ command: { id } }) => id)).toEqual(["segueix", "deixa"]);
});

test("a camera may have several ways to expose, and a cooler of one switch or of two commands", () => {
  const seconds = [argument("segons", { unit: "s" })];
  const camera = device("camera", [], [does("foto", "camera.expose", seconds), does("fosca", "camera.expose", seconds), does("fred", "camera.cooler", active)]);
  expect(cameraCommands(camera).expose.map(({ id }) => id)).toEqual(["foto", "fosca"]);
  // What it streams are its exposures; a camera that only films streams a film.
  expect([showsExposures(camera), showsExposures(device("camera", [], []))]).toEqual([true, false]);
  expect(cameraCommands(camera).cooler.map(({ args }) => args)).toEqual([{ active: true }, { active: false }]);
  const two = device("camera", [], [does("a", "camera.cooler_on"), does("b", "camera.cooler_off")]);
  expect(cameraCommands(two).cooler.map(({ command: { id } }) => id)).toEqual(["a", "b"]);
});

test("an outlet has the switch of its own id, or two commands with its id and an ending", () => {
  const pdu = device(
    "power",
    [has("lamp", "power.outlet"), has("fan", "power.outlet"), state("mode", ["eco", "full", "boost"])],
    [does("lamp", "power.switch", active), does("fan_on", "power.on"), does("fan_off", "power.off")],
  );
  const [lamp, fan, ...rest] = outletsOf(pdu);
  expect(rest).toEqual([]);
  expect([lamp?.on?.args, lamp?.off?.args]).toEqual([{ active: true }, { active: false }]);
  expect([fan?.on?.command.id, fan?.off?.command.id]).toEqual(["fan_on", "fan_off"]);
});

test("right ascension and declination are read in hours and degrees, by role and unit alone", () => {
  const ra = has("a", "telescope.ra", { unit: "h" });
  expect(angleText(ra, 5.5)).toBe(angleText({ ...ra, unit: "°" }, 82.5));
  expect(angleText(ra, 5.5)).toContain("30");
  expect(angleText(has("d", "telescope.dec", { unit: "°" }), -5.5)).toMatch(/^−0?5/);
  expect(angleText(signal("ra", { unit: "h" }), 5.5)).toBe("");
  expect(angleText(ra, Number.NaN)).toBe("");
});
