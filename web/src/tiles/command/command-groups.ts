/** Many commands in an order in which they are found: what stops, what is used, what is set up once. */

import type { CommandShape, DeviceShape } from "../../generated/api.js";

export interface CommandGroups {
  readonly device: DeviceShape;
  /** What stops or makes safe: never behind a closed section. */
  readonly urgent: readonly CommandShape[];
  readonly first: readonly CommandShape[];
  /** what it can be asked besides. */
  readonly more: readonly CommandShape[];
}

/** A list of so many is seen at a glance. */
const FEW = 6;
/** A section of fewer than these hides more than it clears. */
const LEAST_MORE = 3;
const URGENT = /^(?:dome\.close|camera\.abort|.+\.stop)$/u;

/** Whether somebody who may use the device stops it by this, without a word more. */
function isUrgent(device: DeviceShape, { role, arguments: asked }: CommandShape): boolean {
  return URGENT.test(role) && asked.length === 0 && device.rights.includes("use");
}

function isMatch(words: readonly string[], device: DeviceShape, command: CommandShape): boolean {
  const text = [device.name, command.name, command.description, ...command.arguments.map(({ name }) => name)].join(" ").toLowerCase();
  return words.every((word) => text.includes(word));
}

/**
 * The commands of each device that has some, in the order of the description.
 *
 * @param search - only commands in which each of these words stands; then none is behind another section
 */
export function groupCommands(devices: readonly DeviceShape[], search = ""): readonly CommandGroups[] {
  const words = search.toLowerCase().split(/\s+/u).filter((word) => word !== "");
  return devices
    .map((device): CommandGroups => {
      const shown = device.commands.filter((command) => isMatch(words, device, command));
      const urgent = shown.filter((command) => isUrgent(device, command));
      const others = shown.filter((command) => !urgent.includes(command));
      const roles = others.filter(({ role }) => role !== "none");
      const rest = others.length - roles.length;
      if (words.length > 0 || roles.length === 0 || rest < LEAST_MORE || device.commands.length <= FEW) return { device, urgent, first: others, more: [] };
      return { device, urgent, first: roles, more: others.filter(({ role }) => role === "none") };
    })
    .filter(({ urgent, first, more }) => urgent.length + first.length + more.length > 0);
}

/** Whether there are so many that all of them at once are a long way to go. */
export function isLongList(devices: readonly DeviceShape[]): boolean {
  return devices.reduce((sum, { commands }) => sum + commands.length, 0) > 2 * FEW;
}
