/** Draws the charts of a page in rounds, so that all of them together stay within their share. */

import { Pace } from "../../series/draw-rate.js";

/** What is drawn in rounds. */
export interface Paintable {
  /** Whether there is anything new to draw. */
  wants(nowMs: number): boolean;
  paint(nowMs: number): void;
  /** It moves by itself: look again at the next frame. */
  readonly moving: boolean;
}

/** A hidden tab gets no frames, so nothing is drawn there. */
export class Painter {
  private readonly charts = new Set<Paintable>();
  private frame = 0;

  constructor(private readonly pace = new Pace()) {}

  /** Returns the way to take the chart out again. */
  add(chart: Paintable): () => void {
    this.charts.add(chart);
    this.wake();
    return () => {
      this.charts.delete(chart);
    };
  }

  /** A chart has something new. */
  wake(): void {
    if (this.frame === 0) this.frame = requestAnimationFrame(this.round);
  }

  private readonly round = (): void => {
    this.frame = 0;
    const started = performance.now();
    let again = false;
    if (this.pace.due(started)) {
      let drawn = false;
      for (const chart of this.charts) {
        if (chart.wants(started)) {
          chart.paint(started);
          drawn = true;
        }
        again ||= chart.moving;
      }
      if (drawn) this.pace.drew(started, performance.now() - started);
    } else {
      again = true;
    }
    if (again) this.wake();
  };
}
