/**
 * A gamepad in the standard layout as a hold.
 *
 * A stick drifts and a pad lies on the desk, so a stick alone does not drive: one of the two
 * shoulder buttons must be held, and after every halt let go and held anew.
 */

import { CENTRE, limitedUnit, type Stick } from "./stick.js";

export interface PadReading {
  readonly axes: readonly number[];
  readonly buttons: readonly { readonly pressed: boolean }[];
}

const REST = 0.15;
/** Left and right shoulder button of the standard layout. */
const GRIPS = [4, 5] as const;
const [UP, DOWN, LEFT, RIGHT] = [12, 13, 14, 15] as const;

function beyondRest(value: number | undefined): number {
  const reading = limitedUnit(value ?? 0);
  const reach = (Math.abs(reading) - REST) / (1 - REST);
  return reach <= 0 ? 0 : Math.sign(reading) * Math.min(1, reach);
}

/** Whether the hand is on the pad. */
export function isGripped(pad: PadReading): boolean {
  return GRIPS.some((button) => pad.buttons[button]?.pressed === true);
}

/** Left stick or cross as a push. */
export function pushOf(pad: PadReading): Stick {
  const buttonValue = (button: number): number => (pad.buttons[button]?.pressed === true ? 1 : 0);
  const forward = buttonValue(UP) - buttonValue(DOWN) - beyondRest(pad.axes[1]);
  const turn = buttonValue(LEFT) - buttonValue(RIGHT) - beyondRest(pad.axes[0]);
  if (forward === 0 && turn === 0) return CENTRE;
  return { forward: limitedUnit(forward), turn: limitedUnit(turn) };
}

/** What a reading changes. `none` when nothing did. */
export type PadChange = "none" | "press" | "move" | "release";

/** Compares readings of one pad. A grip held since before we looked does not count. */
export class GamepadGrip {
  private was: boolean | null = null;

  readChange(pad: PadReading): PadChange {
    const is = isGripped(pad);
    const before = this.was;
    this.was = is;
    if (before === null) return "none";
    if (is && !before) return "press";
    if (!is && before) return "release";
    return is ? "move" : "none";
  }
}
