/** A place on the floor as a command of the description that takes one: `vehicle.goal`, `vehicle.initial_pose`. Pure. */

import type { CommandShape, DeviceShape } from "../generated/api.js";

export const POSE_ROLES = ["vehicle.goal", "vehicle.initial_pose"] as const;
export type PoseRole = (typeof POSE_ROLES)[number];

/** Where something is to be, on the floor of a frame. */
export interface FloorPose {
  readonly frame: string;
  /** m */
  readonly x: number;
  readonly y: number;
  /** rad, counter-clockwise from x */
  readonly yaw: number;
}

export interface PoseCommand {
  readonly device: DeviceShape;
  readonly command: CommandShape;
  readonly role: PoseRole;
}

/** The commands of a site that are given by a place. */
export function poseCommands(devices: readonly DeviceShape[]): readonly PoseCommand[] {
  return devices.flatMap((device) =>
    device.commands.flatMap((command) => {
      const role = POSE_ROLES.find((known) => known === command.role);
      return role === undefined ? [] : [{ device, command, role }];
    }),
  );
}

/** The command with a place filled in, in the command's own units; whoever sends it may still change it. */
export function filledCommand(command: CommandShape, { frame, x, y, yaw }: FloorPose): CommandShape {
  const values: Readonly<Record<string, number | string>> = {
    frame, x: rounded(x), y: rounded(y), qz: rounded(Math.sin(yaw / 2)), qw: rounded(Math.cos(yaw / 2)),
  };
  return {
    ...command,
    arguments: command.arguments.map((argument) => {
      const value = argument.id === "yaw" ? rounded(argument.unit === "°" ? (yaw * 180) / Math.PI : yaw) : values[argument.id];
      return value === undefined ? argument : { ...argument, default: value };
    }),
  };
}

/** To a millimetre: what is shown is what is sent. */
function rounded(value: number): number {
  return Math.round(value * 1000) / 1000 + 0;
}
