/**
 * A gamepad in the standard layout as a hold, and as the keys beside it.
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

/** What a button does that is pressed once, as the keys S, Escape, − and + do. */
export type PadPress = "halt" | "STOP" | "slower" | "faster";

/** The four at the right thumb, from the lowest round to the top one. */
const PRESSES: readonly PadPress[] = ["halt", "STOP", "slower", "faster"];

function beyondRest(value: number | undefined): number {
  const reading = limitedUnit(value ?? 0);
  const reach = (Math.abs(reading) - REST) / (1 - REST);
  return reach <= 0 ? 0 : Math.sign(reading) * Math.min(1, reach);
}

/** Whether the hand is on the pad. */
export function isGripped(pad: PadReading): boolean {
  return GRIPS.some((button) => pad.buttons[button]?.pressed === true);
}

/** Left stick or cross as a push; the right stick goes sideways. */
export function pushOf(pad: PadReading): Stick {
  const buttonValue = (button: number): number => (pad.buttons[button]?.pressed === true ? 1 : 0);
  const forward = buttonValue(UP) - buttonValue(DOWN) - beyondRest(pad.axes[1]);
  const turn = buttonValue(LEFT) - buttonValue(RIGHT) - beyondRest(pad.axes[0]);
  const side = -beyondRest(pad.axes[2]) + 0;
  if (forward === 0 && turn === 0 && side === 0) return CENTRE;
  return { forward: limitedUnit(forward), turn: limitedUnit(turn), ...(side === 0 ? {} : { side }) };
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

/** Compares the single buttons of one pad with the reading before. One held since before we looked does not count. */
export class GamepadPresses {
  private was: readonly boolean[] | null = null;

  readPresses(pad: PadReading): readonly PadPress[] {
    const is = PRESSES.map((_press, button) => pad.buttons[button]?.pressed === true);
    const before = this.was ?? is;
    this.was = is;
    return PRESSES.filter((_press, button) => is[button] === true && before[button] !== true);
  }
}

/** Of the pads at this device: one can be driven by, there are only others, or none. */
export type PadsFound = "ready" | "other" | "none";

/** @param mappings - of each pad that is there, as browsers give them */
export function padsFound(mappings: readonly string[]): PadsFound {
  if (mappings.length === 0) return "none";
  return mappings.includes("standard") ? "ready" : "other";
}
