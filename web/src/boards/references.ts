/**
 * How a tile names what it shows: `device/signal`, `$device/signal` for the board's device, or by role,
 * `@weather.wind`: of the board's device if it has one, else of the site. So one board serves every
 * robot of a kind. Pure.
 */

import { msg, str } from "@lit/localize";
import type { CommandShape, DeviceShape, SignalShape, SignalType, SiteShape, StreamShape } from "../generated/api.js";

/** What a board is looked at with. */
export interface BoardSubjects {
  readonly detail: SiteShape;
  /** What `$device` stands for; null where nothing fits. */
  readonly device: DeviceShape | null;
}

export const DEVICE = "$device";

/** The devices in the order in which a role is looked for. */
function rolesFirst({ detail, device }: BoardSubjects): readonly DeviceShape[] {
  return device === null ? detail.devices : [device, ...detail.devices.filter((other) => other !== device)];
}

export function findDevice(name: string, { detail, device }: BoardSubjects): DeviceShape | null {
  if (name === DEVICE || name === "") return device;
  return detail.devices.find(({ id }) => id === name) ?? null;
}

function splitName(name: string): readonly [device: string, rest: string] {
  const at = name.indexOf("/");
  return at < 0 ? ["", name] : [name.slice(0, at), name.slice(at + 1)];
}

export function findSignal(name: string, subjects: BoardSubjects): SignalShape | null {
  if (name.startsWith("@")) {
    const role = name.slice(1);
    return rolesFirst(subjects).flatMap(({ signals }) => signals).find((signal) => signal.role === role) ?? null;
  }
  const [owner, id] = splitName(name);
  return findDevice(owner, subjects)?.signals.find((signal) => signal.id === id) ?? null;
}

/** Those that are there, each once. */
export function findSignals(names: readonly string[], subjects: BoardSubjects): readonly SignalShape[] {
  return [...new Set(names.flatMap((name) => findSignal(name, subjects) ?? []))];
}

/** A camera's stream; `$device` alone is the first one of the board's device. */
export function findStream(name: string, subjects: BoardSubjects): StreamShape | null {
  if (name === DEVICE) return subjects.device?.streams[0] ?? subjects.detail.devices.flatMap(({ streams }) => streams)[0] ?? null;
  const [owner, id] = splitName(name);
  return findDevice(owner, subjects)?.streams.find((stream) => stream.id === id) ?? null;
}

/** Those that are named, or all of the site. */
export function findStreams(names: readonly string[], subjects: BoardSubjects): readonly StreamShape[] {
  if (names.length === 0) return subjects.detail.devices.flatMap(({ streams }) => streams);
  return [...new Set(names.flatMap((name) => findStream(name, subjects) ?? []))];
}

export interface FoundCommand {
  readonly device: DeviceShape;
  readonly command: CommandShape;
}

export function findCommand(name: string, subjects: BoardSubjects): FoundCommand | null {
  if (name.startsWith("@")) {
    for (const device of rolesFirst(subjects)) {
      const command = device.commands.find(({ role }) => role === name.slice(1));
      if (command !== undefined) return { device, command };
    }
    return null;
  }
  const [owner, id] = splitName(name);
  const device = findDevice(owner, subjects);
  const command = device?.commands.find((candidate) => candidate.id === id);
  return device === null || command === undefined ? null : { device, command };
}

/** The device that a board begins with: the one that is asked for, its own, or the first of its kind. */
export function boardDevice(detail: SiteShape, asked: string, board: { readonly device: string; readonly kind: string }): DeviceShape | null {
  const named = (id: string): DeviceShape | undefined => (id === "" ? undefined : detail.devices.find((device) => device.id === id));
  const fits = detail.devices.find(({ kind }) => board.kind !== "" && kind === board.kind);
  return named(asked) ?? named(board.device) ?? fits ?? (board.kind === "" ? (detail.devices[0] ?? null) : null);
}

/** A name, as it is chosen in a form, with the words for it. */
export interface ReferenceChoice {
  readonly value: string;
  readonly label: string;
}

/** What can be named of signals: of the board's device first, then all. */
export function signalChoices({ detail, device }: BoardSubjects, types: readonly SignalType[]): readonly ReferenceChoice[] {
  const fits = (signal: SignalShape): boolean => types.length === 0 || types.includes(signal.type);
  const own = (device?.signals ?? []).filter(fits).map(({ id, name }) => ({ value: `${DEVICE}/${id}`, label: msg(str`${name} of the chosen device`) }));
  const all = detail.devices.flatMap((other) => other.signals.filter(fits).map(({ address, name }) => ({ value: address, label: `${other.name}: ${name}` })));
  return [...all, ...own];
}
