/** Pointer, wheel, fingers and keys on a chart, told as what they ask for. */

import { panned, pinched, zoomed, type TimeSpan } from "../../series/time-window.js";

/** What a chart does when asked. Places are parts of the plot's width: 0 left, 1 right. */
export interface GestureTarget {
  /** The window, or null while there is none. */
  span(): TimeSpan | null;
  /** Part of the plot's width at a place on the screen. */
  partAt(clientX: number): number;
  moveCursor(part: number | null): void;
  /** Show the stretch that would be zoomed to; null takes it away. */
  showSelection(from: number, to: number): void;
  hideSelection(): void;
  changeSpan(span: TimeSpan, settled: boolean): void;
  /** Back to where it was before zooming. */
  resetSpan(): void;
  readonly zoomable: boolean;
}

const WHEEL = 0.0015;
/** Shorter drags are clicks (CSS pixels). */
const LEAST_DRAG = 6;
const SETTLE_MS = 180;

interface Finger {
  x: number;
  readonly startX: number;
  us: number;
  readonly mouse: boolean;
}

export class Gestures {
  private readonly fingers = new Map<number, Finger>();
  private settle: ReturnType<typeof setTimeout> | undefined;

  constructor(
    private readonly place: HTMLElement,
    private readonly asked: GestureTarget,
  ) {
    place.addEventListener("pointerdown", this.onPointerDown);
    place.addEventListener("pointermove", this.onPointerMove);
    place.addEventListener("pointerup", this.onPointerUp);
    place.addEventListener("pointercancel", this.onPointerCancel);
    place.addEventListener("pointerleave", this.onPointerLeave);
    place.addEventListener("dblclick", this.onDoubleClick);
    place.addEventListener("wheel", this.onWheel, { passive: false });
  }

  private timeAt(clientX: number): number {
    const span = this.asked.span();
    return span === null ? NaN : span.fromUs + this.asked.partAt(clientX) * (span.toUs - span.fromUs);
  }

  private readonly onPointerDown = (event: PointerEvent): void => {
    if (!this.asked.zoomable || (event.pointerType === "mouse" && event.button !== 0)) return;
    this.place.setPointerCapture(event.pointerId);
    const mouse = event.pointerType === "mouse" && !event.shiftKey;
    this.fingers.set(event.pointerId, { x: event.clientX, startX: event.clientX, us: this.timeAt(event.clientX), mouse });
  };

  private readonly onPointerMove = (event: PointerEvent): void => {
    this.asked.moveCursor(this.asked.partAt(event.clientX));
    const finger = this.fingers.get(event.pointerId);
    if (finger === undefined) return;
    finger.x = event.clientX;
    if (finger.mouse) this.asked.showSelection(this.asked.partAt(finger.startX), this.asked.partAt(finger.x));
    else this.applyDrag(false);
  };

  private readonly onPointerUp = (event: PointerEvent): void => {
    const finger = this.fingers.get(event.pointerId);
    if (finger === undefined) return;
    const moved = Math.abs(finger.x - finger.startX) >= LEAST_DRAG;
    if (finger.mouse) {
      this.asked.hideSelection();
      const [a, b] = [finger.us, this.timeAt(finger.x)];
      // A drag that began before the chart had a window began at no moment.
      if (moved && Number.isFinite(a) && Number.isFinite(b)) this.asked.changeSpan({ fromUs: Math.min(a, b), toUs: Math.max(a, b) }, true);
    } else if (moved) {
      this.applyDrag(true);
    }
    this.fingers.delete(event.pointerId);
    this.regripRemaining();
  };

  private readonly onPointerCancel = (event: PointerEvent): void => {
    this.fingers.delete(event.pointerId);
    this.asked.hideSelection();
    this.regripRemaining();
  };

  private readonly onPointerLeave = (event: PointerEvent): void => {
    if (event.pointerType === "mouse" && this.fingers.size === 0) this.asked.moveCursor(null);
  };

  private readonly onDoubleClick = (): void => {
    if (this.asked.zoomable) this.asked.resetSpan();
  };

  // A wheel that passes over a chart scrolls the page; it zooms once the chart has been clicked.
  private readonly onWheel = (event: WheelEvent): void => {
    const span = this.asked.span();
    const meant = event.ctrlKey || event.metaKey || this.place.matches(":focus, :focus-within");
    if (!this.asked.zoomable || span === null || !meant) return;
    event.preventDefault();
    const sideways = Math.abs(event.deltaX) > Math.abs(event.deltaY);
    const pixels = event.deltaMode === 0 ? 1 : 30;
    const next = sideways
      ? panned(span, (event.deltaX * pixels * (span.toUs - span.fromUs)) / Math.max(1, this.place.clientWidth))
      : zoomed(span, Math.exp(event.deltaY * pixels * WHEEL), this.timeAt(event.clientX));
    this.asked.changeSpan(next, false);
    clearTimeout(this.settle);
    this.settle = setTimeout(() => {
      const now = this.asked.span();
      if (now !== null) this.asked.changeSpan(now, true);
    }, SETTLE_MS);
  };

  /** Puts the moments that the fingers hold under the fingers. */
  private applyDrag(settled: boolean): void {
    const span = this.asked.span();
    const [one, two] = [...this.fingers.values()];
    if (span === null || one === undefined || ![...this.fingers.values()].every(({ us }) => Number.isFinite(us))) return;
    if (two === undefined) {
      this.asked.changeSpan(panned(span, one.us - this.timeAt(one.x)), settled);
      return;
    }
    const next = pinched(one.us, two.us, this.asked.partAt(one.x), this.asked.partAt(two.x));
    if (next !== null) this.asked.changeSpan(next, settled);
  }

  // When one of two fingers goes, the other holds on to where it is now.
  private regripRemaining(): void {
    for (const finger of this.fingers.values()) finger.us = this.timeAt(finger.x);
  }
}
