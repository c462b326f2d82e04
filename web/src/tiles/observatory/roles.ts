/**
 * A device's signals and commands by their roles, as the hub says them: what a description names,
 * or what Python proposed. Nothing here reads an id, a name or a state's word. Pure.
 */

import { msg, str } from "@lit/localize";
import type { ArgumentValue } from "../../elements/command/argument-check.js";
import type { RoofState } from "../../elements/observatory/dome-drawing.js";
import { formatDec, formatRa } from "../../format/sexagesimal.js";
import type { CommandRole, CommandShape, DeviceShape, SignalRole, SignalShape, StateMeaning } from "../../generated/api.js";

export function signalWith(device: DeviceShape, wanted: SignalRole): SignalShape | undefined {
  return device.signals.find(({ role }) => role === wanted);
}

function commandWith(device: DeviceShape, wanted: CommandRole): CommandShape | undefined {
  return device.commands.find(({ role }) => role === wanted);
}

function commandsWith(device: DeviceShape, wanted: CommandRole): readonly CommandShape[] {
  return device.commands.filter(({ role }) => role === wanted);
}

/** What a state's number means, whatever it is called. */
export function meaningOf(signal: SignalShape | undefined, value: number): StateMeaning {
  return signal?.meanings[Math.round(value)] ?? "unknown";
}

/** Right ascension and declination as they are read; empty for every other number. */
export function angleText({ role, unit }: SignalShape, value: number): string {
  if (Number.isNaN(value)) return "";
  if (role === "telescope.ra") return formatRa(unit === "°" ? value / 15 : value);
  return role === "telescope.dec" ? formatDec(value) : "";
}

// ── dome ──

export interface DomeSignals {
  readonly shutter: SignalShape | undefined;
  readonly opening: SignalShape | undefined;
  readonly azimuth: SignalShape | undefined;
  readonly turning: SignalShape | undefined;
  readonly parked: SignalShape | undefined;
  readonly local: SignalShape | undefined;
}

export function domeSignals(device: DeviceShape): DomeSignals {
  return {
    shutter: signalWith(device, "dome.shutter"),
    opening: signalWith(device, "dome.opening"),
    azimuth: signalWith(device, "dome.azimuth"),
    turning: signalWith(device, "dome.turning"),
    parked: signalWith(device, "dome.parked"),
    local: signalWith(device, "dome.local"),
  };
}

const SHUTTER_STATES: Readonly<Partial<Record<StateMeaning, RoofState>>> = {
  open: "open", closed: "closed", opening: "opening", closing: "closing", partial: "partial", error: "error",
};

/** How a shutter is drawn at a value; what means nothing to a shutter is unknown. */
export function shutterOf(signal: SignalShape | undefined, value: number): RoofState {
  return SHUTTER_STATES[meaningOf(signal, value)] ?? "unknown";
}

/** Commands by what they do; each stands here once. */
export interface CommandButton {
  readonly command: CommandShape;
  readonly args: Readonly<Record<string, ArgumentValue>>;
  /** The button's words. */
  readonly label: string;
  readonly kind: "plain" | "primary" | "danger";
}

function commandButton(command: CommandShape | undefined, kind: CommandButton["kind"] = "plain"): readonly CommandButton[] {
  return command === undefined ? [] : [{ command, args: {}, label: command.name, kind }];
}

/** A command with one boolean as two buttons. */
function switchButtons(command: CommandShape, on: string, off: string): readonly CommandButton[] {
  return [
    { command, args: switchArguments(command, true), label: on, kind: "plain" },
    { command, args: switchArguments(command, false), label: off, kind: "plain" },
  ];
}

function switchArguments(command: CommandShape, on: boolean): Readonly<Record<string, boolean>> {
  return Object.fromEntries(command.arguments.map(({ id }) => [id, on]));
}

export interface DomeCommands {
  readonly buttons: readonly CommandButton[];
  /** Commands with a value, as forms: turn to an azimuth, open so far. */
  readonly forms: readonly CommandShape[];
}

export function domeCommands(device: DeviceShape): DomeCommands {
  return {
    buttons: [
      ...commandButton(commandWith(device, "dome.open")),
      ...commandButton(commandWith(device, "dome.close"), "primary"),
      ...commandButton(commandWith(device, "dome.park")),
      ...commandButton(commandWith(device, "dome.unpark")),
      ...commandButton(commandWith(device, "dome.stop"), "danger"),
    ],
    forms: commandsWith(device, "dome.goto"),
  };
}

// ── telescope ──

export interface TelescopeSignals {
  readonly state: SignalShape | undefined;
  readonly parked: SignalShape | undefined;
  readonly tracking: SignalShape | undefined;
  readonly ra: SignalShape | undefined;
  readonly dec: SignalShape | undefined;
  readonly alt: SignalShape | undefined;
  readonly az: SignalShape | undefined;
}

export function telescopeSignals(device: DeviceShape): TelescopeSignals {
  return {
    state: signalWith(device, "telescope.state"),
    parked: signalWith(device, "telescope.parked"),
    tracking: signalWith(device, "telescope.tracking"),
    ra: signalWith(device, "telescope.ra"),
    dec: signalWith(device, "telescope.dec"),
    alt: signalWith(device, "telescope.altitude"),
    az: signalWith(device, "telescope.azimuth"),
  };
}

/** A command that points the telescope, with the names of its two arguments. */
export interface Slew {
  readonly command: CommandShape;
  readonly ra: string;
  readonly dec: string;
}

export function slewOf({ slew, commands }: DeviceShape): Slew | undefined {
  const command = commands.find(({ id }) => id === slew?.command);
  return slew === null || command === undefined ? undefined : { command, ra: slew.ra, dec: slew.dec };
}

export function telescopeCommands(device: DeviceShape): readonly CommandButton[] {
  const track = commandWith(device, "telescope.track");
  const tracking: readonly CommandButton[] =
    track?.arguments[0]?.type === "boolean"
      ? switchButtons(track, msg("Track"), msg("Stop tracking"))
      : [...commandButton(track), ...commandButton(commandWith(device, "telescope.untrack"))];
  return [
    ...commandButton(commandWith(device, "telescope.unpark")),
    ...tracking,
    ...commandButton(commandWith(device, "telescope.park")),
    ...commandButton(commandWith(device, "telescope.stop"), "danger"),
  ];
}

// ── camera ──

export interface CameraSignals {
  readonly state: SignalShape | undefined;
  readonly remaining: SignalShape | undefined;
  readonly temperature: SignalShape | undefined;
  readonly cooler: SignalShape | undefined;
  readonly power: SignalShape | undefined;
  readonly filter: SignalShape | undefined;
  readonly binning: SignalShape | undefined;
  readonly gain: SignalShape | undefined;
}

export function cameraSignals(device: DeviceShape): CameraSignals {
  return {
    state: signalWith(device, "camera.state"),
    remaining: signalWith(device, "camera.remaining"),
    temperature: signalWith(device, "camera.temperature"),
    cooler: signalWith(device, "camera.cooler"),
    power: signalWith(device, "camera.cooler_power"),
    filter: signalWith(device, "camera.filter"),
    binning: signalWith(device, "camera.binning"),
    gain: signalWith(device, "camera.gain"),
  };
}

export interface CameraCommands {
  /** Commands that ask for an exposure time. */
  readonly expose: readonly CommandShape[];
  readonly abort: readonly CommandButton[];
  /** A set point as a form, and the cooler's switch. */
  readonly cool: readonly CommandShape[];
  readonly cooler: readonly CommandButton[];
  /** What holds from the next exposure on: filter, binning, gain. */
  readonly settings: readonly CommandShape[];
}

export function cameraCommands(device: DeviceShape): CameraCommands {
  const cooler = commandWith(device, "camera.cooler");
  return {
    expose: commandsWith(device, "camera.expose"),
    abort: commandButton(commandWith(device, "camera.abort"), "danger"),
    cool: commandsWith(device, "camera.cool"),
    cooler:
      cooler === undefined
        ? [...commandButton(commandWith(device, "camera.cooler_on")), ...commandButton(commandWith(device, "camera.cooler_off"))]
        : switchButtons(cooler, msg("Cooler on"), msg("Cooler off")),
    settings: (["camera.filter", "camera.binning", "camera.gain"] as const).flatMap((role) => commandsWith(device, role)),
  };
}

/** Whether what a device streams is its exposures, one by one, and no film. */
export function showsExposures(device: DeviceShape): boolean {
  return cameraCommands(device).expose.length > 0;
}

// ── power ──

export interface Outlet {
  readonly signal: SignalShape;
  readonly on: CommandButton | undefined;
  readonly off: CommandButton | undefined;
}

/** Each outlet, with the commands that switch it where there are any: one of its own id, or two with an ending. */
export function outletsOf(device: DeviceShape): readonly Outlet[] {
  return device.signals.filter(({ role }) => role === "power.outlet").map((signal) => {
    const both = commandsWith(device, "power.switch").find(({ id }) => id === signal.id);
    const makeButton = (on: boolean): CommandButton | undefined => {
      const own = commandsWith(device, on ? "power.on" : "power.off").find(({ id }) => id === `${signal.id}_${on ? "on" : "off"}`);
      const command = both ?? own;
      const args = both === undefined ? {} : switchArguments(both, on);
      return command === undefined ? undefined : { command, args, label: on ? msg(str`${signal.name}: on`) : msg(str`${signal.name}: off`), kind: "plain" };
    };
    return { signal, on: makeButton(true), off: makeButton(false) };
  });
}
