/**
 * The driver's hands: keys, gamepad, and everything that takes the hands off (focus, sight,
 * dialogs), from the window to the seat. The pad on screen reports by itself; see `t-pad`.
 */

import { PadGrip, pushOf } from "./gamepad.js";
import { meaningOf, sourceOf, usesKeys, type KeyTaker } from "./drive-keys.js";
import type { DriveSeat } from "./drive-session.js";
import { PUSH } from "./stick.js";
import type { StopLine } from "./stop-client.js";

const STEP = 0.1;

export class Hands {
  private readonly grips = new Map<number, PadGrip>();
  private poll = 0;
  private dialog: HTMLDialogElement | null = null;
  private leaving: AbortController | null = null;

  /** @param seat - null for someone who may press STOP but not drive */
  constructor(
    private readonly seat: DriveSeat | null,
    private readonly stop: StopLine,
  ) {}

  open(): void {
    this.leaving = new AbortController();
    const { signal } = this.leaving;
    window.addEventListener("keydown", this.keyDown, { signal });
    window.addEventListener("keyup", this.keyUp, { signal });
    window.addEventListener("blur", this.blur, { signal });
    window.addEventListener("focus", this.focus, { signal });
    window.addEventListener("focusin", this.focusIn, { signal });
    window.addEventListener("pagehide", this.sight, { signal });
    document.addEventListener("visibilitychange", this.sight, { signal });
    window.addEventListener("gamepadconnected", this.watchPads, { signal });
    window.addEventListener("gamepaddisconnected", this.padGone, { signal });
    this.watchPads();
  }

  close(): void {
    this.leaving?.abort();
    this.leaving = null;
    cancelAnimationFrame(this.poll);
    this.poll = 0;
    this.grips.clear();
  }

  private readonly keyDown = (event: KeyboardEvent): void => {
    if (event.key === "Meta") {
      // macOS tells nothing of keys let go while Command is down.
      this.seat?.halt("cancelled");
      return;
    }
    const meaning = meaningOf(event);
    if (meaning?.kind === "STOP") {
      this.stop.press();
      return;
    }
    const { seat } = this;
    if (!meaning || !seat || usesKeys(event.composedPath() as KeyTaker[], event.code)) return;
    this.seeDialog();
    if (!seat.machine.mayDrive) return;
    event.preventDefault();
    switch (meaning.kind) {
      case "push":
        seat.press(sourceOf(event), PUSH[meaning.direction]);
        return;
      case "halt":
        seat.halt("stop key");
        return;
      case "faster":
        seat.setLevel(seat.machine.level + STEP);
        return;
      case "slower":
        seat.setLevel(seat.machine.level - STEP);
        return;
    }
  };

  private readonly keyUp = (event: KeyboardEvent): void => {
    this.seat?.release(sourceOf(event));
  };

  private readonly blur = (): void => {
    this.seat?.halt("blur");
  };

  private readonly focus = (): void => {
    this.seat?.refocus();
  };

  private readonly sight = (event: Event): void => {
    if (event.type === "pagehide" || document.visibilityState === "hidden") this.seat?.hide();
    else this.seat?.lift("hidden");
  };

  /** A modal dialog takes the focus: that is how one in any shadow tree is noticed. */
  private readonly focusIn = (event: FocusEvent): void => {
    const dialog = event.composedPath().find((target) => target instanceof HTMLDialogElement);
    if (dialog?.open === true) {
      this.dialog = dialog;
      this.seat?.bar("dialog");
    } else this.seeDialog();
  };

  private seeDialog(): void {
    if (!this.dialog || (this.dialog.open && this.dialog.isConnected)) return;
    this.dialog = null;
    this.seat?.lift("dialog");
  }

  private readonly padGone = (event: GamepadEvent): void => {
    const source = `gamepad:${String(event.gamepad.index)}`;
    this.grips.delete(event.gamepad.index);
    if (this.seat?.machine.holds(source)) this.seat.halt("gamepad lost");
  };

  private readonly watchPads = (): void => {
    if (this.poll !== 0 || !this.seat || !navigator.getGamepads().some(Boolean)) return;
    this.poll = requestAnimationFrame(this.readPads);
  };

  private readonly readPads = (): void => {
    this.poll = 0;
    this.seeDialog();
    for (const pad of navigator.getGamepads()) {
      if (pad?.mapping === "standard") this.readPad(pad);
    }
    this.watchPads();
  };

  private readPad(pad: Gamepad): void {
    const { seat } = this;
    if (!seat) return;
    const grip = this.grips.get(pad.index) ?? new PadGrip();
    this.grips.set(pad.index, grip);
    const source = `gamepad:${String(pad.index)}`;
    switch (grip.read(pad)) {
      case "press":
        seat.press(source, pushOf(pad), "analog");
        return;
      case "move":
        seat.move(source, pushOf(pad));
        return;
      case "release":
        seat.release(source);
        return;
      case "none":
        return;
    }
  }
}
