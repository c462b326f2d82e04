/** Draws the charts of a page in rounds, so that all of them together stay within their share. */

import { DrawRate } from "../../series/draw-rate.js";

/** What is drawn in rounds. */
export interface Paintable {
  /** Samples or a change that have not been drawn. */
  readonly isFresh: boolean;
  /** Whether there is anything to draw: something fresh, or it has moved. */
  needsPaint(nowMs: number): boolean;
  paintFrame(nowMs: number): void;
  /** How soon (ms) it will have moved; Infinity: not by itself. */
  restMs(nowMs: number): number;
}

/** When there are frames, and what time it is (ms). */
export interface FrameClock {
  now(): number;
  nextFrame(run: () => void): void;
  /** Gives what ends it. */
  after(ms: number, run: () => void): () => void;
}

const BROWSER_FRAMES: FrameClock = {
  now: () => performance.now(),
  nextFrame: (run) => {
    requestAnimationFrame(run);
  },
  after: (ms, run) => {
    const timer = setTimeout(run, ms);
    return () => {
      clearTimeout(timer);
    };
  },
};
/** A rest shorter than two frames is none. */
const LEAST_REST_MS = 34;
/** However slowly a chart moves, it is looked at this often (ms): what fails to wake us is not late for long. */
const MOST_REST_MS = 250;

/** A hidden tab gets no frames, so nothing is drawn there. */
export class PaintScheduler {
  private readonly charts = new Set<Paintable>();
  private asked = false;
  private endRest: (() => void) | null = null;

  constructor(
    private readonly pace = new DrawRate(),
    private readonly frames = BROWSER_FRAMES,
  ) {}

  /** Returns the way to take the chart out again. */
  addChart(chart: Paintable): () => void {
    this.charts.add(chart);
    this.wakeUp();
    return () => {
      this.charts.delete(chart);
    };
  }

  /** A chart has something new: all that came until the next frame is drawn with it, in one go. */
  readonly wakeUp = (): void => {
    this.endRest?.();
    this.endRest = null;
    if (this.asked) return;
    this.asked = true;
    this.frames.nextFrame(this.paintRound);
  };

  private readonly paintRound = (): void => {
    this.asked = false;
    const started = this.frames.now();
    const waiting = [...this.charts].filter((chart) => chart.needsPaint(started));
    if (waiting.length > 0) {
      if (!this.pace.isDue(started, waiting.some(({ isFresh }) => isFresh))) {
        this.wakeUp();
        return;
      }
      for (const chart of waiting) chart.paintFrame(started);
      this.pace.recordRound(started, this.frames.now() - started);
    }
    this.rest(Math.min(...[...this.charts].map((chart) => chart.restMs(started))));
  };

  /** Frames in which nothing moves are not asked for: each costs, drawn or not. */
  private rest(ms: number): void {
    if (ms === Infinity || this.asked) return;
    if (ms < LEAST_REST_MS) this.wakeUp();
    else this.endRest = this.frames.after(Math.min(ms, MOST_REST_MS), this.wakeUp);
  }
}
