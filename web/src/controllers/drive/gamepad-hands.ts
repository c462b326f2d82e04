/**
 * Gamepads on the way to the seat: the same holds, the same halts and the same STOP as by keys.
 *
 * A key reaches only the window that has the focus. A browser gives a gamepad's readings to every
 * page in sight, so that the focus is asked for here.
 */

import { applySeatPress, type DriveSession } from "./drive-session.js";
import { GamepadGrip, GamepadPresses, pushOf, type PadPress, type PadReading } from "./gamepad.js";
import type { StopClient } from "./stop-client.js";

/** What is read of a gamepad. */
export interface PadInPlace extends PadReading {
  readonly index: number;
  readonly mapping: string;
}

interface HeldPad {
  readonly grip: GamepadGrip;
  readonly presses: GamepadPresses;
}

type PadSeat = Pick<DriveSession, "machine" | "pressHold" | "moveHold" | "releaseHold" | "haltMotion" | "setLevel">;

export class GamepadHands {
  private readonly known = new Map<number, HeldPad>();

  /** @param seat - null for someone who may press STOP but not drive */
  constructor(
    private readonly seat: PadSeat | null,
    private readonly stop: Pick<StopClient, "pressStop">,
  ) {}

  /**
   * Reads all pads once; call it for each frame that is drawn.
   *
   * @param pads - as the browser gives them: with holes, and with pads of other layouts
   * @param focused - the window has the focus
   */
  read(pads: readonly (PadInPlace | null)[], focused: boolean): void {
    const there = pads.filter((pad) => pad?.mapping === "standard").filter((pad) => pad !== null);
    // Some systems take a pad away without an event.
    const lost = [...this.known.keys()].filter((index) => !there.some((pad) => pad.index === index));
    for (const index of lost) this.forget(index);
    for (const pad of there) this.readPad(pad, focused);
  }

  /** The pad is gone. Whoever drove by it has let go. */
  forget(index: number): void {
    this.known.delete(index);
    if (this.seat?.machine.isHeld(sourceOfPad(index)) === true) this.seat.haltMotion("gamepad lost");
  }

  forgetAll(): void {
    for (const index of [...this.known.keys()]) this.forget(index);
  }

  private readPad(pad: PadInPlace, focused: boolean): void {
    const held = this.known.get(pad.index) ?? { grip: new GamepadGrip(), presses: new GamepadPresses() };
    this.known.set(pad.index, held);
    // Read in any case: what was pressed elsewhere is no press here afterwards.
    const change = held.grip.readChange(pad);
    const presses = held.presses.readPresses(pad);
    const source = sourceOfPad(pad.index);
    if (!focused) {
      if (this.seat?.machine.isHeld(source) === true) this.seat.haltMotion("blur");
      return;
    }
    for (const press of presses) this.applyPress(press);
    const { seat } = this;
    if (!seat) return;
    switch (change) {
      case "press":
        seat.pressHold(source, pushOf(pad), "analog");
        return;
      case "move":
        seat.moveHold(source, pushOf(pad));
        return;
      case "release":
        seat.releaseHold(source);
        return;
      case "none":
        return;
    }
  }

  private applyPress(press: PadPress): void {
    if (press === "STOP") {
      this.stop.pressStop();
      return;
    }
    const { seat } = this;
    if (seat?.machine.mayDrive !== true) return;
    applySeatPress(seat, press);
  }
}

function sourceOfPad(index: number): string {
  return `gamepad:${String(index)}`;
}
