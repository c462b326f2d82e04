/** Draws the charts of a page in rounds, so that all of them together stay within their share. */

import { DrawRate } from "../../series/draw-rate.js";

/** What is drawn in rounds. */
export interface Paintable {
  /** Whether there is anything new to draw. */
  needsPaint(nowMs: number): boolean;
  paintFrame(nowMs: number): void;
  /** It moves by itself: look again at the next frame. */
  readonly isMoving: boolean;
}

/** A hidden tab gets no frames, so nothing is drawn there. */
export class PaintScheduler {
  private readonly charts = new Set<Paintable>();
  private frame = 0;

  constructor(private readonly pace = new DrawRate()) {}

  /** Returns the way to take the chart out again. */
  addChart(chart: Paintable): () => void {
    this.charts.add(chart);
    this.wakeUp();
    return () => {
      this.charts.delete(chart);
    };
  }

  /** A chart has something new. */
  wakeUp(): void {
    if (this.frame === 0) this.frame = requestAnimationFrame(this.paintRound);
  }

  private readonly paintRound = (): void => {
    this.frame = 0;
    const started = performance.now();
    let again = false;
    if (this.pace.isDue(started)) {
      let drawn = false;
      for (const chart of this.charts) {
        if (chart.needsPaint(started)) {
          chart.paintFrame(started);
          drawn = true;
        }
        again ||= chart.isMoving;
      }
      if (drawn) this.pace.recordRound(started, performance.now() - started);
    } else {
      again = true;
    }
    if (again) this.wakeUp();
  };
}
