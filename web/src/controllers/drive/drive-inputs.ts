/**
 * The driver's hands: keys, gamepad, and everything that takes the hands off (focus, sight,
 * dialogs), from the window to the seat. The pad on screen reports by itself; see `t-pad`.
 */

import { GamepadHands } from "./gamepad-hands.js";
import { meaningOf, sourceOf, usesKeys, type KeyTaker } from "./drive-keys.js";
import { applySeatPress, type DriveSession } from "./drive-session.js";
import { PUSH } from "./stick.js";
import type { StopClient } from "./stop-client.js";

export class DriveInputs {
  private readonly pads: GamepadHands;
  private poll = 0;
  private dialog: HTMLDialogElement | null = null;
  private leaving: AbortController | null = null;

  /** @param seat - null for someone who may press STOP but not drive */
  constructor(
    private readonly seat: DriveSession | null,
    private readonly stop: StopClient,
  ) {
    this.pads = new GamepadHands(seat, stop);
  }

  open(): void {
    this.leaving = new AbortController();
    const { signal } = this.leaving;
    window.addEventListener("keydown", this.onKeyDown, { signal });
    window.addEventListener("keyup", this.onKeyUp, { signal });
    window.addEventListener("blur", this.onBlur, { signal });
    window.addEventListener("focus", this.onFocus, { signal });
    window.addEventListener("focusin", this.onFocusIn, { signal });
    window.addEventListener("pagehide", this.onVisibilityChange, { signal });
    document.addEventListener("visibilitychange", this.onVisibilityChange, { signal });
    document.addEventListener("freeze", this.onFreeze, { signal });
    window.addEventListener("gamepadconnected", this.startReadingGamepads, { signal });
    window.addEventListener("gamepaddisconnected", this.onGamepadDisconnected, { signal });
    this.startReadingGamepads();
  }

  close(): void {
    this.leaving?.abort();
    this.leaving = null;
    cancelAnimationFrame(this.poll);
    this.poll = 0;
    this.pads.forgetAll();
  }

  private readonly onKeyDown = (event: KeyboardEvent): void => {
    if (event.key === "Meta") {
      // macOS tells nothing of keys let go while Command is down.
      this.seat?.haltMotion("cancelled");
      return;
    }
    const meaning = meaningOf(event);
    if (meaning?.kind === "STOP") {
      this.stop.pressStop();
      return;
    }
    const { seat } = this;
    if (!meaning || !seat || usesKeys(event.composedPath() as KeyTaker[], event.code)) return;
    this.checkDialog();
    if (!seat.machine.mayDrive || (meaning.kind === "push" && !seat.machine.obeys(PUSH[meaning.direction]))) return;
    event.preventDefault();
    if (meaning.kind === "push") seat.pressHold(sourceOf(event), PUSH[meaning.direction]);
    else applySeatPress(seat, meaning.kind);
  };

  private readonly onKeyUp = (event: KeyboardEvent): void => {
    this.seat?.releaseHold(sourceOf(event));
  };

  private readonly onBlur = (): void => {
    this.seat?.haltMotion("blur");
  };

  private readonly onFocus = (): void => {
    this.seat?.onFocus();
  };

  private readonly onVisibilityChange = (event: Event): void => {
    if (event.type === "pagehide" || document.visibilityState === "hidden") this.seat?.onHidden();
    else this.seat?.unblock("hidden");
  };

  /** The browser puts the page to sleep: no timer runs any more. */
  private readonly onFreeze = (): void => {
    this.seat?.onHidden();
  };

  /** A modal dialog takes the focus: that is how one in any shadow tree is noticed. */
  private readonly onFocusIn = (event: FocusEvent): void => {
    const dialog = event.composedPath().find((target) => target instanceof HTMLDialogElement);
    if (dialog?.open === true) {
      this.dialog = dialog;
      this.seat?.block("dialog");
    } else this.checkDialog();
  };

  private checkDialog(): void {
    if (!this.dialog || (this.dialog.open && this.dialog.isConnected)) return;
    this.dialog = null;
    this.seat?.unblock("dialog");
  }

  private readonly onGamepadDisconnected = (event: GamepadEvent): void => {
    this.pads.forget(event.gamepad.index);
  };

  private readonly startReadingGamepads = (): void => {
    if (this.poll !== 0 || !navigator.getGamepads().some(Boolean)) return;
    this.poll = requestAnimationFrame(this.readGamepads);
  };

  private readonly readGamepads = (): void => {
    this.poll = 0;
    this.checkDialog();
    this.pads.read(navigator.getGamepads(), document.hasFocus());
    this.startReadingGamepads();
  };
}
