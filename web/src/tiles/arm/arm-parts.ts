/**
 * What a description has of an arm, by its shape: joints with ends, a jog, named poses.
 *
 * `talaia init` writes no kind and no roles for arms: joints come from their model with both ends,
 * a servo's topic is a command with one number for each axis, and a pose is a command without
 * arguments. Pure.
 */

import { msg, str } from "@lit/localize";
import type { CommandShape, DeviceShape, SignalShape } from "../../generated/api.js";
import type { CommandButton } from "../observatory/roles.js";

/** One axis of a jog: along or about x, y or z of the frame that the command names. */
const AXIS = /^(linear|angular)_([xyz])$/;
/** One joint alone may be a gripper, a head or a valve. */
const FEWEST_JOINTS = 2;
/** What a base rolls on and steers by is no arm, though it has both ends. */
const OF_A_BASE = /wheel|steer|caster/i;

/** Units of what turns. */
const TURNS: readonly string[] = ["rad", "°"];

export interface ArmParts {
  readonly device: DeviceShape;
  /** Numbers with both ends. */
  readonly joints: readonly SignalShape[];
  /** One step of the tool for each time that it is asked. */
  readonly jog: CommandShape | null;
  /** Each moves all of the arm to where the description says. */
  readonly poses: readonly CommandShape[];
}

/** The parts of an arm; null of a device that is none. */
export function armParts(device: DeviceShape): ArmParts | null {
  const jogged = device.drive?.joints ?? [];
  // What moves as a whole is a vehicle, whatever it carries.
  if ((device.drive !== null && (jogged.length === 0 || device.drive.ptz)) || (device.kind !== "other" && device.kind !== "vehicle")) return null;
  const joints = device.signals.filter(isJoint);
  const jog = device.commands.find(isJog) ?? null;
  if (jogged.length === 0 && joints.length < FEWEST_JOINTS) return null;
  // Lengths alone are what sensors of distance tell, unless something moves them.
  if (jogged.length === 0 && jog === null && !joints.some(({ unit }) => TURNS.includes(unit))) return null;
  return {
    device,
    joints,
    jog,
    poses: device.commands.filter(({ arguments: args, ros }) => args.length === 0 && ros === ""),
  };
}

function isJoint({ id, type, unit, minimum, maximum }: SignalShape): boolean {
  return type === "number" && !OF_A_BASE.test(id) && ["rad", "°", "m", "mm"].includes(unit) && minimum !== null && maximum !== null && minimum < maximum;
}

/** Each of its numbers is an axis that goes both ways and stands at rest where nothing is said. */
function isJog({ arguments: args }: CommandShape): boolean {
  return args.length > 0 && args.every(({ id, type, minimum, maximum, default: rest }) => AXIS.test(id) && type === "number" && (minimum ?? 0) < 0 && (maximum ?? 0) > 0 && rest === 0);
}

/**
 * A button for each way of each axis.
 *
 * @param share - how much of what the description allows at the most, over 0 to 1
 */
export function jogButtons(jog: CommandShape, share: number): readonly CommandButton[] {
  const rest = Object.fromEntries(jog.arguments.map(({ id }) => [id, 0]));
  return jog.arguments.flatMap(({ id, minimum, maximum }) => {
    const [, part = "", axis = ""] = AXIS.exec(id) ?? [];
    const words = (way: string): string => (part === "linear" ? msg(str`Move ${way}`) : msg(str`Turn ${way}`));
    const button = (sign: string, most: number): CommandButton => ({ command: jog, args: { ...rest, [id]: most * share }, label: words(`${sign}${axis}`), kind: "plain" });
    return [button("+", maximum ?? 0), button("−", minimum ?? 0)];
  });
}

/** Where a joint stands between its ends: 0 to 1; NaN where it is not known. */
export function jointShare({ minimum, maximum }: Pick<SignalShape, "minimum" | "maximum">, value: number): number {
  const [low, high] = [minimum ?? Number.NaN, maximum ?? Number.NaN];
  return Math.min(1, Math.max(0, (value - low) / (high - low)));
}

/** Nearer to an end than this share of all its way, a joint is told of. */
const NEAR = 0.05;

export function isNearEnd(share: number): boolean {
  return share < NEAR || share > 1 - NEAR;
}
