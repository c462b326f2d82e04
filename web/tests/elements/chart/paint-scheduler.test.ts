import { describe, expect, it } from "vitest";
import { PaintScheduler, type FrameClock, type Paintable } from "../../../src/elements/chart/paint-scheduler.js";

/** Frames every 16 ms of a clock that the test moves. */
class MadeFrames implements FrameClock {
  time = 0;
  asked = 0;
  private run: (() => void) | null = null;
  private readonly timers = new Map<() => void, number>();

  now(): number {
    return this.time;
  }

  nextFrame(run: () => void): void {
    this.asked += 1;
    this.run = run;
  }

  after(ms: number, run: () => void): () => void {
    this.timers.set(run, this.time + ms);
    return () => this.timers.delete(run);
  }

  /** Lets time go on, frame by frame. */
  pass(ms: number): void {
    for (const end = this.time + ms; this.time < end; ) {
      this.time += 16;
      for (const [run, at] of [...this.timers]) {
        if (at > this.time) continue;
        this.timers.delete(run);
        run();
      }
      const { run } = this;
      this.run = null;
      run?.();
    }
  }
}

class MadeChart implements Paintable {
  isFresh = true;
  readonly painted: number[] = [];

  /** @param everyMs it has moved so long after it was drawn */
  constructor(private readonly everyMs = Infinity) {}

  needsPaint(nowMs: number): boolean {
    return this.isFresh || this.restMs(nowMs) === 0;
  }

  paintFrame(nowMs: number): void {
    this.isFresh = false;
    this.painted.push(nowMs);
  }

  restMs(nowMs: number): number {
    return Math.max(0, (this.painted.at(-1) ?? 0) + this.everyMs - nowMs);
  }
}

function shown(...charts: MadeChart[]): { readonly frames: MadeFrames; readonly painter: PaintScheduler } {
  const frames = new MadeFrames();
  const painter = new PaintScheduler(undefined, frames);
  for (const chart of charts) painter.addChart(chart);
  return { frames, painter };
}

describe("the charts of a page", () => {
  it("are drawn with the next frame, all that have something new in one go", () => {
    const charts = [new MadeChart(), new MadeChart(), new MadeChart()];
    const { frames, painter } = shown(...charts);
    frames.pass(16);
    for (const chart of charts) {
      chart.isFresh = true;
      painter.wakeUp();
    }
    // Sooner after the last round than movement would be drawn.
    frames.pass(16);
    expect(charts.map(({ painted }) => painted)).toEqual([[16, 32], [16, 32], [16, 32]]);
  });

  it("ask for no frames while nothing moves", () => {
    const { frames } = shown(new MadeChart());
    frames.pass(10_000);
    expect(frames.asked).toBe(1);
  });

  it("rest until the first of them has moved", () => {
    const [slow, quick] = [new MadeChart(5000), new MadeChart(200)];
    const { frames } = shown(slow, quick);
    frames.pass(1000);
    expect(quick.painted).toHaveLength(5);
    expect(slow.painted).toHaveLength(1);
    expect(frames.asked).toBeLessThan(15);
  });

  it("are woken from their rest by what is new", () => {
    const chart = new MadeChart(5000);
    const { frames, painter } = shown(chart);
    frames.pass(64);
    chart.isFresh = true;
    painter.wakeUp();
    frames.pass(16);
    expect(chart.painted.at(-1)).toBe(80);
  });

  it("are drawn 30 times a second at the most where they only move", () => {
    const chart = new MadeChart(1);
    const { frames } = shown(chart);
    frames.pass(960);
    expect(chart.painted.length).toBeLessThan(32);
    expect(chart.painted.length).toBeGreaterThan(25);
  });
});
