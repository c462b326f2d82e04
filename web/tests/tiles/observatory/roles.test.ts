import { expect, test } from "vitest";
import {
  cameraCommands, domeCommands, domeSignals, outletsOf, partOf, commandsShownBy, shutterOf, slewOf, telescopeCommands, telescopeSignals, summarySignals,
} from "../../../src/tiles/observatory/roles.js";
import { argument, command, device, signal, state } from "./described.js";

const rosDome = device(
  "dome",
  [
    state("shutter", ["closed", "opened", "opening", "closing", "stopped", "error"]),
    state("closed", ["no", "yes"]),
    signal("position", { unit: "%" }),
    signal("azimuth", { unit: "°" }),
    state("turning", ["no", "yes"]),
    state("local", ["remote", "local"]),
  ],
  [
    command("open"), command("close"), command("stop"), command("park"),
    command("goto", [argument("azimuth", { unit: "°" })]), command("polish"),
  ],
);
const indiDome = device(
  "dome",
  [
    state("flap", ["closed", "opening", "open", "closing", "error", "unknown"]),
    state("shutter", ["closed", "opening", "open", "closing", "error", "unknown"]),
    state("parked", ["parked", "parking", "unparked", "unparking", "error", "unknown"]),
    signal("azimuth", { unit: "°" }),
  ],
  [command("open_flap"), command("close_flap"), command("open"), command("close"), command("park"), command("unpark"), command("stop")],
);

test("a dome behind ROS and one behind INDI are read alike", () => {
  const ros = domeSignals(rosDome);
  expect([ros.shutter?.id, ros.opening?.id, ros.azimuth?.id, ros.turning?.id, ros.local?.id]).toEqual([
    "shutter", "position", "azimuth", "turning", "local",
  ]);
  const indi = domeSignals(indiDome);
  expect([indi.shutter?.id, indi.parked?.id, indi.azimuth?.id, indi.opening?.id]).toEqual(["shutter", "parked", "azimuth", undefined]);
});

test("a dome's buttons open and close the shutter, never the flap", () => {
  expect(domeCommands(indiDome).buttons.map(({ command: { id } }) => id)).toEqual(["open", "close", "park", "unpark", "stop"]);
  expect(domeCommands(rosDome).forms.map(({ id }) => id)).toEqual(["goto"]);
});

test("a roof that slides away needs no azimuth", () => {
  const roof = device("dome", [state("roof", ["closed", "open"])]);
  expect(partOf(roof)).toBe("dome");
  expect(domeSignals(roof).azimuth).toBeUndefined();
});

test("a page's part goes by what a device is, never by what it is called", () => {
  expect(partOf({ ...rosDome, id: "telescope", name: "Telescope" })).toBe("dome");
  expect(partOf(device("other", rosDome.signals))).toBe("none");
});

test("every word of a shutter means something, and what none knows is unknown", () => {
  expect(["opened", "open", "closed", "opening", "closing", "stopped", "error", "unknown", "humming"].map(shutterOf)).toEqual([
    "open", "open", "closed", "opening", "closing", "partial", "error", "unknown", "unknown",
  ]);
});

const angles = [
  signal("sun_altitude", { unit: "°", name: "Altitude of the Sun" }),
  signal("ra", { unit: "h" }), signal("dec", { unit: "°" }), signal("altitude", { unit: "°" }), signal("azimuth", { unit: "°" }),
];

test("the Sun's altitude is not the telescope's", () => {
  expect(telescopeSignals(device("telescope", angles)).alt?.id).toBe("altitude");
});

test("the description says which command points a telescope, by whatever name", () => {
  const slews = command("hin", [argument("a", { unit: "h" }), argument("d", { unit: "°" })]);
  const pointing = { commands: [{ command: "hin", ra: "a", dec: "d", alt: "", az: "" }], horizon: 15, sun: 30 };
  expect(slewOf(device("telescope", [], [slews], { pointing }))).toMatchObject({ ra: "a", dec: "d", command: { id: "hin" } });
});

test("without that, a command with right ascension and declination points it, and a sync never does", () => {
  const args = [argument("ra", { unit: "h" }), argument("dec", { unit: "°" })];
  expect(slewOf(device("telescope", [], [command("sync", args), command("goto", args)]))?.command.id).toBe("goto");
  expect(slewOf(device("telescope", [], [command("sync", args)]))).toBeUndefined();
});

test("tracking is two buttons, of one switch or of two commands", () => {
  const other = device("telescope", [], [command("track", [argument("active", { type: "boolean" })])]);
  const two = device("telescope", [], [command("track"), command("untrack")]);
  expect(telescopeCommands(other).map(({ args }) => args)).toEqual([{ active: true }, { active: false }]);
  expect(telescopeCommands(two).map(({ command: { id } }) => id)).toEqual(["track", "untrack"]);
});

test("a camera that takes exposures has another page than one that only watches", () => {
  const takes = device("camera", [], [command("expose", [argument("seconds", { unit: "s" })])]);
  expect(partOf(takes)).toBe("camera");
  expect(cameraCommands(takes).expose).toHaveLength(1);
  expect(partOf(device("camera", []))).toBe("pictures");
});

test("an outlet is a state of off and on with the switch of its own id", () => {
  const pdu = device(
    "power",
    [state("lamp", ["off", "on"]), state("fan", ["off", "on"]), state("mode", ["eco", "full", "boost"]), signal("total", { unit: "W" })],
    [command("lamp", [argument("active", { type: "boolean" })]), command("fan_on"), command("fan_off")],
  );
  const [lamp, fan, ...rest] = outletsOf(pdu);
  expect(rest).toEqual([]);
  expect([lamp?.on?.args, lamp?.off?.args]).toEqual([{ active: true }, { active: false }]);
  expect([fan?.on?.command.id, fan?.off?.command.id]).toEqual(["fan_on", "fan_off"]);
  expect(summarySignals(pdu).map(({ id }) => id)).toEqual(["total"]);
});

test("what a drawn part does not show stands below: no command is lost", () => {
  const shown = commandsShownBy(rosDome);
  expect(rosDome.commands.filter(({ id }) => !shown.has(id)).map(({ id }) => id)).toEqual(["polish"]);
  expect(indiDome.commands.filter(({ id }) => !commandsShownBy(indiDome).has(id)).map(({ id }) => id)).toEqual(["open_flap", "close_flap"]);
});
