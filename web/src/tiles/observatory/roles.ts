/**
 * What a device's signals and commands are for: which is the azimuth, which opens the shutter.
 *
 * Read from the kind of the device and from what the description says of each (type, unit, states,
 * arguments, and the words of its id and name), so that the same page serves a dome behind ROS and
 * one behind INDI, whatever they are called. Pure.
 */

import type { ArgumentValue } from "../../elements/command/argument-check.js";
import type { CommandInfo, DeviceInfo, SignalInfo } from "../../wire/api-types.js";

/** Which drawn part a device's page has; `pictures` for a camera that only watches. */
export type PartName = "dome" | "telescope" | "weather" | "camera" | "power" | "pictures" | "none";

export function partOf(device: DeviceInfo): PartName {
  switch (device.kind) {
    case "dome":
      return domeSignals(device).shutter !== undefined || domeSignals(device).azimuth !== undefined ? "dome" : "none";
    case "telescope":
      return "telescope";
    case "weather":
      return "weather";
    case "camera":
      return cameraSignals(device).state !== undefined || cameraSignals(device).remaining !== undefined || cameraDeeds(device).expose.length > 0
        ? "camera"
        : "pictures";
    case "power":
      return outletsOf(device).length > 0 ? "power" : "none";
    case "vehicle":
    case "other":
      return "none";
  }
}

type Signals = readonly SignalInfo[];

/** The words of an id and a name, in lower case. */
function wordsOf({ id, name }: { readonly id: string; readonly name: string }): ReadonlySet<string> {
  return new Set(`${id} ${name}`.toLowerCase().split(/[^\p{L}\p{N}]+/u));
}

function has(one: { readonly id: string; readonly name: string }, ...some: readonly string[]): boolean {
  const words = wordsOf(one);
  return some.some((word) => words.has(word));
}

/** The first whose id is this very word, or else whose words have it. */
function named(signals: Signals, ...some: readonly string[]): SignalInfo | undefined {
  return signals.find(({ id }) => some.includes(id)) ?? signals.find((signal) => has(signal, ...some));
}

const numbers = (device: DeviceInfo, ...units: readonly string[]): Signals =>
  device.signals.filter(({ type, unit }) => type === "number" && units.includes(unit));
const states = (device: DeviceInfo): Signals => device.signals.filter(({ type }) => type === "state");
const says = (signal: SignalInfo, shape: RegExp): boolean => signal.states.some((word) => shape.test(word));

// ── dome ──

export interface DomeSignals {
  readonly shutter: SignalInfo | undefined;
  readonly opening: SignalInfo | undefined;
  readonly azimuth: SignalInfo | undefined;
  readonly turning: SignalInfo | undefined;
  readonly parked: SignalInfo | undefined;
  readonly local: SignalInfo | undefined;
}

export function domeSignals(device: DeviceInfo): DomeSignals {
  const all = states(device);
  const shutters = all.filter((one) => says(one, /^clos(ed|e)?$/i) && says(one, /^open(ed)?$/i));
  return {
    shutter: named(shutters, "shutter", "roof", "enclosure", "state") ?? shutters[0],
    opening: named(numbers(device, "%"), "position", "opening", "shutter", "roof", "open"),
    azimuth: named(numbers(device, "°"), "azimuth", "az", "heading", "rotation"),
    turning: named(all, "turning", "rotating", "moving"),
    parked: all.find((one) => !shutters.includes(one) && says(one, /^parked$/i)) ?? named(all, "parked"),
    local: all.find((one) => says(one, /^local$/i) && says(one, /^remote$/i)),
  };
}

export type ShutterState = "open" | "closed" | "opening" | "closing" | "partial" | "error" | "unknown";

/** What a shutter's word means for the drawing. */
export function shutterOf(word: string): ShutterState {
  const plain = word.toLowerCase();
  if (/^open(ed)?$/.test(plain)) return "open";
  if (/^close(d)?$/.test(plain)) return "closed";
  if (plain === "opening" || plain === "closing") return plain;
  if (/^(stopped|partial|partly.*|half.*|ajar)$/.test(plain)) return "partial";
  return /^(error|alert|fault|failed|stuck)$/.test(plain) ? "error" : "unknown";
}

/** Commands by what they do; each stands here once. */
export interface Deed {
  readonly command: CommandInfo;
  readonly args: Readonly<Record<string, ArgumentValue>>;
  /** The button's words. */
  readonly label: string;
  readonly kind: "plain" | "primary" | "danger";
}

function deed(command: CommandInfo | undefined, kind: Deed["kind"] = "plain", label?: string): readonly Deed[] {
  return command === undefined ? [] : [{ command, args: {}, label: label ?? command.name, kind }];
}

/** A command without arguments whose id, or else name, has one of these words. */
function bare(device: DeviceInfo, ...some: readonly string[]): CommandInfo | undefined {
  const simple = device.commands.filter((one) => one.arguments.length === 0);
  return simple.find(({ id }) => some.includes(id)) ?? simple.find((one) => has(one, ...some) && !has(one, "flap", "cover"));
}

/** A command with one boolean. */
function switched(device: DeviceInfo, ...some: readonly string[]): CommandInfo | undefined {
  const simple = device.commands.filter((one) => one.arguments.length === 1 && one.arguments[0]?.type === "boolean");
  return simple.find(({ id }) => some.includes(id)) ?? simple.find((one) => has(one, ...some));
}

export function switchedTo(command: CommandInfo, on: boolean): Readonly<Record<string, boolean>> {
  return Object.fromEntries(command.arguments.map(({ id }) => [id, on]));
}

const STOPS = ["stop", "abort", "halt"] as const;

export interface DomeDeeds {
  readonly buttons: readonly Deed[];
  /** Commands with a value, as forms: turn to an azimuth, open so far. */
  readonly forms: readonly CommandInfo[];
}

export function domeDeeds(device: DeviceInfo): DomeDeeds {
  const open = bare(device, "open");
  const close = bare(device, "close", "shut");
  const stop = bare(device, ...STOPS);
  const park = bare(device, "park", "home");
  const unpark = bare(device, "unpark");
  const turn = device.commands.find((one) => one.arguments.length === 1 && one.arguments[0]?.unit === "°");
  return {
    buttons: [...deed(open), ...deed(close, "primary"), ...deed(park), ...deed(unpark), ...deed(stop, "danger")],
    forms: turn === undefined ? [] : [turn],
  };
}

// ── telescope ──

export interface TelescopeSignals {
  readonly state: SignalInfo | undefined;
  readonly parked: SignalInfo | undefined;
  readonly tracking: SignalInfo | undefined;
  readonly ra: SignalInfo | undefined;
  readonly dec: SignalInfo | undefined;
  readonly alt: SignalInfo | undefined;
  readonly az: SignalInfo | undefined;
}

export function telescopeSignals(device: DeviceInfo): TelescopeSignals {
  const angles = numbers(device, "°").filter((one) => !has(one, "sun", "moon"));
  const all = states(device);
  const state = all.find((one) => says(one, /^(slewing|tracking)$/i));
  return {
    state,
    parked: all.find((one) => one !== state && says(one, /^parked$/i)),
    tracking: named(all.filter((one) => one !== state), "tracking", "track"),
    ra: named(numbers(device, "h"), "ra", "right") ?? named(angles, "ra", "right"),
    dec: named(angles, "dec", "declination"),
    alt: named(angles, "altitude", "alt", "elevation"),
    az: named(angles, "azimuth", "az"),
  };
}

/** A command that points the telescope, with the names of its two arguments. */
export interface Slew {
  readonly command: CommandInfo;
  readonly ra: string;
  readonly dec: string;
}

/** The description's own word, or else a command that asks for right ascension and declination. */
export function slewOf(device: DeviceInfo): Slew | undefined {
  for (const each of device.pointing?.commands ?? []) {
    const command = device.commands.find(({ id }) => id === each.command);
    if (command !== undefined && each.ra !== "" && each.dec !== "") return { command, ra: each.ra, dec: each.dec };
  }
  for (const command of device.commands) {
    const ra = command.arguments.find((one) => has(one, "ra", "right"));
    const dec = command.arguments.find((one) => has(one, "dec", "declination"));
    if (ra !== undefined && dec !== undefined && !has(command, "sync")) return { command, ra: ra.id, dec: dec.id };
  }
  return undefined;
}

export function telescopeDeeds(device: DeviceInfo): readonly Deed[] {
  const track = switched(device, "track", "tracking");
  const both: readonly Deed[] =
    track === undefined
      ? [...deed(bare(device, "track")), ...deed(bare(device, "untrack"))]
      : [
          { command: track, args: switchedTo(track, true), label: "Track", kind: "plain" },
          { command: track, args: switchedTo(track, false), label: "Stop tracking", kind: "plain" },
        ];
  return [...deed(bare(device, "unpark")), ...both, ...deed(bare(device, "park")), ...deed(bare(device, ...STOPS), "danger")];
}

// ── camera ──

export interface CameraSignals {
  readonly state: SignalInfo | undefined;
  readonly remaining: SignalInfo | undefined;
  readonly temperature: SignalInfo | undefined;
  readonly cooler: SignalInfo | undefined;
  readonly power: SignalInfo | undefined;
  readonly filter: SignalInfo | undefined;
}

export function cameraSignals(device: DeviceInfo): CameraSignals {
  const all = states(device);
  return {
    state: all.find((one) => says(one, /^expos(ing|ure)$/i)),
    remaining: named(numbers(device, "s"), "remaining", "exposure", "left"),
    temperature: named(numbers(device, "°C"), "temperature", "chip", "sensor", "ccd"),
    cooler: named(all, "cooler", "cooling"),
    power: named(numbers(device, "%"), "cooler", "cooler_power", "power"),
    filter: device.signals.find((one) => has(one, "filter")),
  };
}

export interface CameraDeeds {
  /** Commands that ask for an exposure time. */
  readonly expose: readonly CommandInfo[];
  readonly abort: readonly Deed[];
  /** A set point as a form, and the cooler's switch. */
  readonly cool: readonly CommandInfo[];
  readonly cooler: readonly Deed[];
}

export function cameraDeeds(device: DeviceInfo): CameraDeeds {
  const exposes = device.commands.filter((one) => one.arguments.some(({ unit, type }) => unit === "s" && type !== "text"));
  const point = device.commands.filter((one) => one.arguments.length === 1 && one.arguments[0]?.unit === "°C");
  const cooler = switched(device, "cooler", "cooling");
  const [on, off] = [bare(device, "cooler_on"), bare(device, "cooler_off")];
  return {
    expose: exposes,
    abort: deed(bare(device, "abort", "stop"), "danger"),
    cool: point,
    cooler:
      cooler === undefined
        ? [...deed(on), ...deed(off)]
        : [
            { command: cooler, args: switchedTo(cooler, true), label: "Cooler on", kind: "plain" },
            { command: cooler, args: switchedTo(cooler, false), label: "Cooler off", kind: "plain" },
          ],
  };
}

// ── power ──

export interface Outlet {
  readonly signal: SignalInfo;
  readonly on: Deed | undefined;
  readonly off: Deed | undefined;
}

const TWO = [/^(off|no|false|0|open)$/i, /^(on|yes|true|1|closed)$/i] as const;

/** Whether a state is a switch: off and on, in this order. */
export function isSwitch({ type, states: [off = "", on = "", ...rest] }: SignalInfo): boolean {
  return type === "state" && rest.length === 0 && TWO[0].test(off) && TWO[1].test(on);
}

/** Each on/off state, with the commands that switch it where there are any. */
export function outletsOf(device: DeviceInfo): readonly Outlet[] {
  return device.signals.filter(isSwitch).map((signal) => {
    const one = device.commands.find(
      ({ id, arguments: args }) => id === signal.id && args.length === 1 && args[0]?.type === "boolean",
    );
    const find = (suffix: string): CommandInfo | undefined =>
      device.commands.find(({ id, arguments: args }) => id === `${signal.id}_${suffix}` && args.length === 0);
    const make = (on: boolean): Deed | undefined => {
      const command = one ?? find(on ? "on" : "off");
      const args = one === undefined ? {} : switchedTo(one, on);
      const label = `${signal.name}: ${on ? "on" : "off"}`;
      return command === undefined ? undefined : { command, args, label, kind: "plain" };
    };
    return { signal, on: make(true), off: make(false) };
  });
}

/** The commands that a drawn part shows itself; the rest stands below as forms. */
export function shownBy(device: DeviceInfo): ReadonlySet<string> {
  const ids = (deeds: readonly Deed[]): readonly string[] => deeds.map(({ command }) => command.id);
  switch (partOf(device)) {
    case "dome": {
      const { buttons, forms } = domeDeeds(device);
      return new Set([...ids(buttons), ...forms.map(({ id }) => id)]);
    }
    case "telescope": {
      const slew = slewOf(device);
      return new Set([...ids(telescopeDeeds(device)), ...(slew === undefined ? [] : [slew.command.id])]);
    }
    case "camera": {
      const { expose, abort, cool, cooler } = cameraDeeds(device);
      return new Set([...ids(abort), ...ids(cooler), ...[...expose, ...cool].map(({ id }) => id)]);
    }
    case "power":
      return new Set(ids(outletsOf(device).flatMap(({ on, off }) => [on, off].filter((one) => one !== undefined))));
    case "weather":
    case "pictures":
    case "none":
      return new Set();
  }
}

/** The signals that tell most of a device at a glance, the first one first. */
export function tellingSignals(device: DeviceInfo): readonly SignalInfo[] {
  const there = (...some: readonly (SignalInfo | undefined)[]): readonly SignalInfo[] => some.filter((one) => one !== undefined);
  switch (device.kind) {
    case "dome": {
      const { shutter, azimuth, local } = domeSignals(device);
      return there(shutter, azimuth, local).slice(0, 3);
    }
    case "telescope": {
      const { state, parked, tracking, ra, dec } = telescopeSignals(device);
      return [...there(state ?? parked, state === undefined ? tracking : undefined), ...there(ra, dec)].slice(0, 4);
    }
    case "camera": {
      const { state, remaining, temperature, filter } = cameraSignals(device);
      return there(state ?? remaining, temperature, filter).slice(0, 3);
    }
    case "weather": {
      const safety = states(device).find((one) => says(one, /^(un)?safe$/i));
      const wet = states(device).find((one) => has(one, "rain", "raining"));
      const wind = named(numbers(device, "km/h", "m/s"), "wind");
      return there(safety, wet, wind, named(numbers(device, "%"), "humidity"), named(numbers(device, "°C"), "temperature")).slice(0, 4);
    }
    case "power":
      return there(numbers(device, "W")[0], numbers(device, "V")[0], numbers(device, "A")[0], numbers(device, "%")[0]).slice(0, 3);
    case "vehicle":
    case "other":
      return device.signals.filter(({ primary, type }) => primary && type !== "position").slice(0, 3);
  }
}
