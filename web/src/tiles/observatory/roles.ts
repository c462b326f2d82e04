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
      return cameraSignals(device).state !== undefined || cameraSignals(device).remaining !== undefined || cameraCommands(device).expose.length > 0
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

function hasWord(item: { readonly id: string; readonly name: string }, ...some: readonly string[]): boolean {
  const words = wordsOf(item);
  return some.some((word) => words.has(word));
}

/** The first whose id is this very word, or else whose words have it. */
function signalNamed(signals: Signals, ...some: readonly string[]): SignalInfo | undefined {
  return signals.find(({ id }) => some.includes(id)) ?? signals.find((signal) => hasWord(signal, ...some));
}

const numbersWithUnit = (device: DeviceInfo, ...units: readonly string[]): Signals =>
  device.signals.filter(({ type, unit }) => type === "number" && units.includes(unit));
const stateSignals = (device: DeviceInfo): Signals => device.signals.filter(({ type }) => type === "state");
const hasState = (signal: SignalInfo, shape: RegExp): boolean => signal.states.some((word) => shape.test(word));

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
  const all = stateSignals(device);
  const shutters = all.filter((signal) => hasState(signal, /^clos(ed|e)?$/i) && hasState(signal, /^open(ed)?$/i));
  return {
    shutter: signalNamed(shutters, "shutter", "roof", "enclosure", "state") ?? shutters[0],
    opening: signalNamed(numbersWithUnit(device, "%"), "position", "opening", "shutter", "roof", "open"),
    azimuth: signalNamed(numbersWithUnit(device, "°"), "azimuth", "az", "heading", "rotation"),
    turning: signalNamed(all, "turning", "rotating", "moving"),
    parked: all.find((signal) => !shutters.includes(signal) && hasState(signal, /^parked$/i)) ?? signalNamed(all, "parked"),
    local: all.find((signal) => hasState(signal, /^local$/i) && hasState(signal, /^remote$/i)),
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
export interface CommandButton {
  readonly command: CommandInfo;
  readonly args: Readonly<Record<string, ArgumentValue>>;
  /** The button's words. */
  readonly label: string;
  readonly kind: "plain" | "primary" | "danger";
}

function commandButton(command: CommandInfo | undefined, kind: CommandButton["kind"] = "plain", label?: string): readonly CommandButton[] {
  return command === undefined ? [] : [{ command, args: {}, label: label ?? command.name, kind }];
}

/** A command without arguments whose id, or else name, has one of these words. */
function plainCommand(device: DeviceInfo, ...some: readonly string[]): CommandInfo | undefined {
  const simple = device.commands.filter((command) => command.arguments.length === 0);
  return simple.find(({ id }) => some.includes(id)) ?? simple.find((command) => hasWord(command, ...some) && !hasWord(command, "flap", "cover"));
}

/** A command with one boolean. */
function switchCommand(device: DeviceInfo, ...some: readonly string[]): CommandInfo | undefined {
  const simple = device.commands.filter((command) => command.arguments.length === 1 && command.arguments[0]?.type === "boolean");
  return simple.find(({ id }) => some.includes(id)) ?? simple.find((command) => hasWord(command, ...some));
}

export function switchArguments(command: CommandInfo, on: boolean): Readonly<Record<string, boolean>> {
  return Object.fromEntries(command.arguments.map(({ id }) => [id, on]));
}

const STOPS = ["stop", "abort", "halt"] as const;

export interface DomeCommands {
  readonly buttons: readonly CommandButton[];
  /** Commands with a value, as forms: turn to an azimuth, open so far. */
  readonly forms: readonly CommandInfo[];
}

export function domeCommands(device: DeviceInfo): DomeCommands {
  const open = plainCommand(device, "open");
  const close = plainCommand(device, "close", "shut");
  const stop = plainCommand(device, ...STOPS);
  const park = plainCommand(device, "park", "home");
  const unpark = plainCommand(device, "unpark");
  const turn = device.commands.find((command) => command.arguments.length === 1 && command.arguments[0]?.unit === "°");
  return {
    buttons: [...commandButton(open), ...commandButton(close, "primary"), ...commandButton(park), ...commandButton(unpark), ...commandButton(stop, "danger")],
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
  const angles = numbersWithUnit(device, "°").filter((signal) => !hasWord(signal, "sun", "moon"));
  const all = stateSignals(device);
  const state = all.find((signal) => hasState(signal, /^(slewing|tracking)$/i));
  return {
    state,
    parked: all.find((signal) => signal !== state && hasState(signal, /^parked$/i)),
    tracking: signalNamed(all.filter((signal) => signal !== state), "tracking", "track"),
    ra: signalNamed(numbersWithUnit(device, "h"), "ra", "right") ?? signalNamed(angles, "ra", "right"),
    dec: signalNamed(angles, "dec", "declination"),
    alt: signalNamed(angles, "altitude", "alt", "elevation"),
    az: signalNamed(angles, "azimuth", "az"),
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
  for (const slew of device.pointing?.commands ?? []) {
    const command = device.commands.find(({ id }) => id === slew.command);
    if (command !== undefined && slew.ra !== "" && slew.dec !== "") return { command, ra: slew.ra, dec: slew.dec };
  }
  for (const command of device.commands) {
    const ra = command.arguments.find((argument) => hasWord(argument, "ra", "right"));
    const dec = command.arguments.find((argument) => hasWord(argument, "dec", "declination"));
    if (ra !== undefined && dec !== undefined && !hasWord(command, "sync")) return { command, ra: ra.id, dec: dec.id };
  }
  return undefined;
}

export function telescopeCommands(device: DeviceInfo): readonly CommandButton[] {
  const track = switchCommand(device, "track", "tracking");
  const both: readonly CommandButton[] =
    track === undefined
      ? [...commandButton(plainCommand(device, "track")), ...commandButton(plainCommand(device, "untrack"))]
      : [
          { command: track, args: switchArguments(track, true), label: "Track", kind: "plain" },
          { command: track, args: switchArguments(track, false), label: "Stop tracking", kind: "plain" },
        ];
  return [...commandButton(plainCommand(device, "unpark")), ...both, ...commandButton(plainCommand(device, "park")), ...commandButton(plainCommand(device, ...STOPS), "danger")];
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
  const all = stateSignals(device);
  return {
    state: all.find((signal) => hasState(signal, /^expos(ing|ure)$/i)),
    remaining: signalNamed(numbersWithUnit(device, "s"), "remaining", "exposure", "left"),
    temperature: signalNamed(numbersWithUnit(device, "°C"), "temperature", "chip", "sensor", "ccd"),
    cooler: signalNamed(all, "cooler", "cooling"),
    power: signalNamed(numbersWithUnit(device, "%"), "cooler", "cooler_power", "power"),
    filter: device.signals.find((signal) => hasWord(signal, "filter")),
  };
}

export interface CameraCommands {
  /** Commands that ask for an exposure time. */
  readonly expose: readonly CommandInfo[];
  readonly abort: readonly CommandButton[];
  /** A set point as a form, and the cooler's switch. */
  readonly cool: readonly CommandInfo[];
  readonly cooler: readonly CommandButton[];
}

export function cameraCommands(device: DeviceInfo): CameraCommands {
  const exposes = device.commands.filter((command) => command.arguments.some(({ unit, type }) => unit === "s" && type !== "text"));
  const point = device.commands.filter((command) => command.arguments.length === 1 && command.arguments[0]?.unit === "°C");
  const cooler = switchCommand(device, "cooler", "cooling");
  const [on, off] = [plainCommand(device, "cooler_on"), plainCommand(device, "cooler_off")];
  return {
    expose: exposes,
    abort: commandButton(plainCommand(device, "abort", "stop"), "danger"),
    cool: point,
    cooler:
      cooler === undefined
        ? [...commandButton(on), ...commandButton(off)]
        : [
            { command: cooler, args: switchArguments(cooler, true), label: "Cooler on", kind: "plain" },
            { command: cooler, args: switchArguments(cooler, false), label: "Cooler off", kind: "plain" },
          ],
  };
}

// ── power ──

export interface Outlet {
  readonly signal: SignalInfo;
  readonly on: CommandButton | undefined;
  readonly off: CommandButton | undefined;
}

const TWO = [/^(off|no|false|0|open)$/i, /^(on|yes|true|1|closed)$/i] as const;

/** Whether a state is a switch: off and on, in this order. */
export function isSwitch({ type, states: [off = "", on = "", ...rest] }: SignalInfo): boolean {
  return type === "state" && rest.length === 0 && TWO[0].test(off) && TWO[1].test(on);
}

/** Each on/off state, with the commands that switch it where there are any. */
export function outletsOf(device: DeviceInfo): readonly Outlet[] {
  return device.signals.filter(isSwitch).map((signal) => {
    const candidate = device.commands.find(
      ({ id, arguments: args }) => id === signal.id && args.length === 1 && args[0]?.type === "boolean",
    );
    const findCommand = (suffix: string): CommandInfo | undefined =>
      device.commands.find(({ id, arguments: args }) => id === `${signal.id}_${suffix}` && args.length === 0);
    const makeButton = (on: boolean): CommandButton | undefined => {
      const command = candidate ?? findCommand(on ? "on" : "off");
      const args = candidate === undefined ? {} : switchArguments(candidate, on);
      const label = `${signal.name}: ${on ? "on" : "off"}`;
      return command === undefined ? undefined : { command, args, label, kind: "plain" };
    };
    return { signal, on: makeButton(true), off: makeButton(false) };
  });
}

/** The commands that a drawn part shows itself; the rest stands below as forms. */
export function commandsShownBy(device: DeviceInfo): ReadonlySet<string> {
  const commandIds = (deeds: readonly CommandButton[]): readonly string[] => deeds.map(({ command }) => command.id);
  switch (partOf(device)) {
    case "dome": {
      const { buttons, forms } = domeCommands(device);
      return new Set([...commandIds(buttons), ...forms.map(({ id }) => id)]);
    }
    case "telescope": {
      const slew = slewOf(device);
      return new Set([...commandIds(telescopeCommands(device)), ...(slew === undefined ? [] : [slew.command.id])]);
    }
    case "camera": {
      const { expose, abort, cool, cooler } = cameraCommands(device);
      return new Set([...commandIds(abort), ...commandIds(cooler), ...[...expose, ...cool].map(({ id }) => id)]);
    }
    case "power":
      return new Set(commandIds(outletsOf(device).flatMap(({ on, off }) => [on, off].filter((button) => button !== undefined))));
    case "weather":
    case "pictures":
    case "none":
      return new Set();
  }
}

/** The signals that tell most of a device at a glance, the first one first. */
export function summarySignals(device: DeviceInfo): readonly SignalInfo[] {
  const onlyPresent = (...some: readonly (SignalInfo | undefined)[]): readonly SignalInfo[] => some.filter((signal) => signal !== undefined);
  switch (device.kind) {
    case "dome": {
      const { shutter, azimuth, local } = domeSignals(device);
      return onlyPresent(shutter, azimuth, local).slice(0, 3);
    }
    case "telescope": {
      const { state, parked, tracking, ra, dec } = telescopeSignals(device);
      return [...onlyPresent(state ?? parked, state === undefined ? tracking : undefined), ...onlyPresent(ra, dec)].slice(0, 4);
    }
    case "camera": {
      const { state, remaining, temperature, filter } = cameraSignals(device);
      return onlyPresent(state ?? remaining, temperature, filter).slice(0, 3);
    }
    case "weather": {
      const safety = stateSignals(device).find((signal) => hasState(signal, /^(un)?safe$/i));
      const wet = stateSignals(device).find((signal) => hasWord(signal, "rain", "raining"));
      const wind = signalNamed(numbersWithUnit(device, "km/h", "m/s"), "wind");
      return onlyPresent(safety, wet, wind, signalNamed(numbersWithUnit(device, "%"), "humidity"), signalNamed(numbersWithUnit(device, "°C"), "temperature")).slice(0, 4);
    }
    case "power":
      return onlyPresent(numbersWithUnit(device, "W")[0], numbersWithUnit(device, "V")[0], numbersWithUnit(device, "A")[0], numbersWithUnit(device, "%")[0]).slice(0, 3);
    case "vehicle":
    case "other":
      return device.signals.filter(({ primary, type }) => primary && type !== "position").slice(0, 3);
  }
}
