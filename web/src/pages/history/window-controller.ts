/** Which window is shown: by the address, by the time that goes on, and by fingers that are at it. */

import type { ReactiveController, ReactiveControllerHost } from "lit";
import type { SpanChange } from "../../elements/chart/chart-model.js";
import { lengthOf, notAfter, zoomed, type TimeSpan } from "../../series/time-window.js";
import { HOUR_US, SECOND_US } from "../../series/zone-clock.js";
import { readView, spanOf, writeView, type HistoryView } from "./history-query.js";

/** The address bar, as far as it is this page's. */
export interface AddressBar {
  searchPart(): string;
  /** Goes to the same page with another search part. */
  navigate(search: string): void;
  /** Pixels of a chart's width. */
  width(): number;
}

/** A window that follows moves on this often (ms), or each time it has moved two pixels. */
const FOLLOW_LEAST_MS = 1000;
const FOLLOW_PIXELS = 2;
/** Windows may end a little in the future, so that "now" is not stuck to the edge. */
const AHEAD = 0.05;
/** Keys and wheel rest for so long before the address bar follows them. */
const SETTLE_MS = 400;
/** Ways back that are remembered. */
const MOST_BACK = 50;

export class WindowController implements ReactiveController {
  nowUs = Date.now() * 1000;
  /** The window while fingers, keys or the wheel are at it. */
  moving: TimeSpan | null = null;
  private timer: ReturnType<typeof setTimeout> | undefined;
  private settling: ReturnType<typeof setTimeout> | undefined;
  private readonly before: HistoryView["shown"][] = [];

  constructor(
    private readonly host: ReactiveControllerHost,
    private readonly bar: AddressBar,
  ) {
    host.addController(this);
  }

  hostConnected(): void {
    this.followNow();
  }

  hostDisconnected(): void {
    clearTimeout(this.timer);
    this.applyAddress();
    this.before.length = 0;
  }

  get view(): HistoryView {
    return readView(this.bar.searchPart());
  }

  get span(): TimeSpan {
    return this.moving ?? spanOf(this.view.shown, this.nowUs);
  }

  get isFollowing(): boolean {
    return this.moving === null && "last" in this.view.shown;
  }

  /** The address has changed: it says what is shown. */
  applyAddress(): void {
    clearTimeout(this.settling);
    this.moving = null;
  }

  updateView(part: Partial<HistoryView>): void {
    const now = this.view;
    if (part.shown !== undefined) {
      this.before.push(now.shown);
      if (this.before.length > MOST_BACK) this.before.shift();
    }
    // Another window begins where its own films do.
    const at = part.shown === undefined ? now.at : undefined;
    this.showView({ ...now, at, ...part });
  }

  /** Fingers, keys or the wheel ask for a window. */
  applySpanChange({ span, settled }: SpanChange): void {
    // No moment, no window: written into the address, nothing could be zoomed any more.
    if (!Number.isFinite(span.fromUs) || !Number.isFinite(span.toUs)) return;
    clearTimeout(this.settling);
    const latest = Date.now() * 1000 + Math.max(lengthOf(span) * AHEAD, SECOND_US);
    const next = notAfter(span, latest);
    if (settled) {
      this.updateView({ shown: { fromUs: Math.round(next.fromUs), toUs: Math.round(next.toUs) } });
      return;
    }
    this.moving = next;
    this.settling = setTimeout(() => {
      this.applySpanChange({ span: next, settled: true });
    }, SETTLE_MS);
    this.host.requestUpdate();
  }

  /** The window from before; without one, twice as much about the same middle. */
  resetWindow(): void {
    const shown = this.before.pop();
    if (shown !== undefined) this.showView({ ...this.view, shown });
    else this.applySpanChange({ span: zoomed(this.span, 2, (this.span.fromUs + this.span.toUs) / 2), settled: false });
  }

  private showView(view: HistoryView): void {
    this.applyAddress();
    this.nowUs = Date.now() * 1000;
    this.bar.navigate(writeView(view));
    this.host.requestUpdate();
    this.followNow();
  }

  /** Moves the window on, as often as it is worth it. */
  private followNow(): void {
    clearTimeout(this.timer);
    const { shown } = this.view;
    const pixelMs = "last" in shown ? (shown.last * 1000) / Math.max(300, this.bar.width()) : Infinity;
    const everyMs = Math.min(HOUR_US / 1000, Math.max(FOLLOW_LEAST_MS, pixelMs * FOLLOW_PIXELS));
    this.timer = setTimeout(() => {
      if (document.visibilityState === "visible" && this.isFollowing) {
        this.nowUs = Date.now() * 1000;
        this.host.requestUpdate();
      }
      this.followNow();
    }, everyMs);
  }
}
