/**
 * Where the person pushes: forward and turn, each from -1 to 1.
 *
 * Signs follow REP-103, like everything sent to the robot: forward is positive, and a turn to
 * the left (counter-clockwise) is positive.
 */

export interface Stick {
  /** -1 backward … 1 forward */
  readonly forward: number;
  /** -1 right … 1 left */
  readonly turn: number;
  /** -1 right … 1 left, without turning; nothing: 0 */
  readonly side?: number;
  /** -1 … 1 of each joint that is driven, in the description's order; nothing: 0 */
  readonly joints?: readonly number[];
}

export type Direction = "forward" | "backward" | "left" | "right" | "sideLeft" | "sideRight";

export const CENTRE: Stick = { forward: 0, turn: 0 };

export const PUSH: Readonly<Record<Direction, Stick>> = {
  forward: { forward: 1, turn: 0 },
  backward: { forward: -1, turn: 0 },
  left: { forward: 0, turn: 1 },
  right: { forward: 0, turn: -1 },
  sideLeft: { forward: 0, turn: 0, side: 1 },
  sideRight: { forward: 0, turn: 0, side: -1 },
};

/**
 * Forward and left held as two keys would spin the robot almost on the spot: its turning limit is
 * high against its speed. While it also moves, a key's turn counts this much, which gives a curve.
 */
export const CURVE = 0.4;

/** A thumb resting in the middle of the pad does not drive. */
const PAD_REST = 0.12;

export function limitedUnit(value: number): number {
  if (!Number.isFinite(value)) return 0;
  return Math.min(1, Math.max(-1, value)) + 0;
}

/** Everything held at once, as one push. Opposite directions cancel. */
export function combinedStick(sticks: Iterable<Stick>): Stick {
  let forward = 0;
  let turn = 0;
  let side = 0;
  const joints: number[] = [];
  for (const stick of sticks) {
    forward += limitedUnit(stick.forward);
    turn += limitedUnit(stick.turn);
    side += limitedUnit(stick.side ?? 0);
    for (const [index, push] of (stick.joints ?? []).entries()) joints[index] = (joints[index] ?? 0) + limitedUnit(push);
  }
  const push: Stick = { forward: limitedUnit(forward), turn: limitedUnit(turn) };
  return { ...push, ...(side === 0 ? {} : { side: limitedUnit(side) }), ...(joints.length === 0 ? {} : { joints: joints.map(limitedUnit) }) };
}

/** One joint that is pushed, of so many. */
export function jointPush(index: number, count: number, push: 1 | -1): Stick {
  return { ...CENTRE, joints: Array.from({ length: count }, (_joint, at) => (at === index ? push : 0)) };
}

/**
 * How far an axis of a camera is pushed by what would drive: forward tilts it up, a turn to the
 * right pans it to the right, and the right of the sideways keys zooms in.
 */
export function aimPush(axis: string, { forward, turn, side = 0 }: Stick): number {
  switch (axis) {
    case "pan":
      return -turn + 0;
    case "tilt":
      return forward;
    case "zoom":
      return -side + 0;
    default:
      return 0;
  }
}

/** A push on a pad that goes sideways where it would turn. */
export function asideStick({ forward, turn }: Stick): Stick {
  return { forward, turn: 0, side: turn };
}

/** Directions held as keys or buttons, as one push; see `CURVE`. */
export function curvedPush(push: Stick): Stick {
  return push.forward === 0 ? push : { ...push, turn: push.turn * CURVE };
}

function easedValue(value: number): number {
  // The square gives fine control near the middle and keeps the full range.
  return value * Math.abs(value);
}

/**
 * A point on the round pad as a push.
 *
 * @param right - from the middle to the right (px)
 * @param down - from the middle down (px)
 * @param radius - of the pad (px)
 */
export function padStick(right: number, down: number, radius: number): Stick {
  const distance = Math.hypot(right, down);
  if (!(radius > 0) || !Number.isFinite(distance) || distance < radius * PAD_REST) return CENTRE;
  const reach = Math.min(1, (distance / radius - PAD_REST) / (1 - PAD_REST));
  const forward = (-down / distance) * reach;
  const turn = (-right / distance) * reach;
  return { forward: limitedUnit(easedValue(forward)), turn: limitedUnit(easedValue(turn)) };
}
