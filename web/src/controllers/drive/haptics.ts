/** What a driver feels in the hand: STOP, an interlock, and a limit that slows the vehicle. */

/** What is felt: each has a rhythm of its own, so that it is known without a look. */
export type HapticCue = "stop" | "interlock" | "limit";

/** Times (ms) of shaking and of rest, in turn. */
const RHYTHMS: Readonly<Record<HapticCue, readonly number[]>> = {
  stop: [300, 80, 300],
  interlock: [90, 60, 90, 60, 90],
  limit: [60],
};
/** The same is not felt again within this time (ms): a limit that comes and goes would buzz. */
const REST_MS = 1500;

/** How things stand for whoever drives. */
export interface FeltState {
  /** STOP is on, or asked for. */
  readonly stopped: boolean;
  /** An interlock refuses driving. */
  readonly locked: boolean;
  /** The vehicle is told less than what is asked of it. */
  readonly limited: boolean;
}

/** Finds what is new, and says it once. How it stands when the page opens is no news. */
export class HapticCues {
  private was: FeltState | null = null;
  private readonly felt = new Map<HapticCue, number>();

  /** @param now - ms on any clock that only goes forward */
  nextCue(state: FeltState, now: number): HapticCue | null {
    const before = this.was ?? state;
    this.was = state;
    if (state.stopped && !before.stopped) return this.rested("stop", now);
    if (state.locked && !before.locked) return this.rested("interlock", now);
    if (state.limited && !before.limited) return this.rested("limit", now);
    return null;
  }

  private rested(cue: HapticCue, now: number): HapticCue | null {
    const last = this.felt.get(cue);
    if (last !== undefined && now - last < REST_MS) return null;
    this.felt.set(cue, now);
    return cue;
  }
}

/** What of a gamepad shakes. */
export interface ShakingPad {
  readonly vibrationActuator?: { playEffect(type: "dual-rumble", effect: { duration: number; strongMagnitude: number; weakMagnitude: number }): Promise<unknown> } | null;
}

/** What of a browser's `navigator` shakes; where there is nothing, nothing is felt. */
export interface ShakingDevice {
  vibrate?(pattern: number[]): boolean;
  getGamepads?(): readonly (ShakingPad | null)[];
  readonly userActivation?: { readonly hasBeenActive: boolean };
}

/** Lets the device and its gamepads shake. */
export function playCue(cue: HapticCue, device: ShakingDevice): void {
  const rhythm = RHYTHMS[cue];
  // A browser refuses it, aloud, before anybody has touched the page.
  if (device.userActivation?.hasBeenActive !== false) device.vibrate?.([...rhythm]);
  const strength = cue === "limit" ? 0.4 : 1;
  const effect = { duration: rhythm.reduce((sum, ms) => sum + ms, 0), strongMagnitude: strength, weakMagnitude: strength };
  for (const pad of device.getGamepads?.() ?? []) void pad?.vibrationActuator?.playEffect("dual-rumble", effect).catch(() => undefined);
}
