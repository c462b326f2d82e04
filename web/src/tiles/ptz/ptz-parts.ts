/** What a description has of a camera that turns: presets, home and how it stands, by role. Pure. */

import type { CommandShape, DeviceShape, SignalShape } from "../../generated/api.js";
import type { CommandButton } from "../observatory/roles.js";

/** More buttons than these nobody finds one among. */
const MOST_PRESETS = 300;

export interface PtzParts {
  readonly presets: SignalShape | undefined;
  readonly goto: CommandShape | undefined;
  readonly keep: CommandShape | undefined;
  readonly remove: CommandShape | undefined;
  readonly home: CommandShape | undefined;
  readonly stop: CommandShape | undefined;
}

export function ptzParts({ signals, commands }: DeviceShape): PtzParts {
  const command = (role: CommandShape["role"]): CommandShape | undefined => commands.find((candidate) => candidate.role === role);
  return {
    presets: signals.find(({ role }) => role === "camera.presets"),
    goto: command("camera.goto_preset"),
    keep: command("camera.set_preset"),
    remove: command("camera.remove_preset"),
    home: command("camera.home"),
    stop: command("camera.abort"),
  };
}

/** The names of presets, of a text that has one a line. */
export function presetNames(text: string): readonly string[] {
  const names = text.split("\n").map((name) => name.trim());
  return [...new Set(names.filter((name) => name !== ""))].slice(0, MOST_PRESETS);
}

/** A button for each preset, for home, and one that stops. */
export function ptzButtons({ goto, home, stop }: PtzParts, names: readonly string[]): readonly CommandButton[] {
  const argument = goto?.arguments[0]?.id;
  return [
    ...(goto === undefined || argument === undefined ? [] : names.map((name): CommandButton => ({ command: goto, args: { [argument]: name }, label: name, kind: "plain" }))),
    ...(home === undefined ? [] : [{ command: home, args: {}, label: home.name, kind: "plain" } as const]),
    ...(stop === undefined ? [] : [{ command: stop, args: {}, label: stop.name, kind: "danger" } as const]),
  ];
}
