/** uPlot as we use it: axes, grid and layout. The traces are drawn by `draw.ts` from thinned columns. */

import type UPlotType from "uplot";
import { formatNumber } from "../../format/number.js";
import { decimalsOf, type Range } from "../../series/range.js";
import { tickText, timeStep, timeTicks } from "../../series/timeticks.js";
import { lengthOf, type Span } from "../../series/window.js";
import type { ZoneClock } from "../../series/zone.js";
import { clipped, type Plot } from "./draw.js";
import type { Palette } from "./palette.js";

/** A rectangle in CSS pixels, from the chart's own corner. */
export interface Box {
  readonly left: number;
  readonly top: number;
  readonly width: number;
  readonly height: number;
}

export interface ViewOptions {
  readonly clock: ZoneClock;
  /** Width kept for the value axis (CSS pixels), so that charts below each other line up. */
  readonly axisWidth: number;
  /** Without a value axis, for states. */
  readonly bare: boolean;
}

const TICK_APART = 84;
const LABEL_HALF = 30;
const TYPE = 12;
const CHAR = 7;
const GAP = 6;

export class ChartView {
  private readonly plot: UPlotType;
  private readonly ticks = new Map<number, string>();
  private drawInside: (plot: Plot) => void = () => undefined;
  private span: Span = { fromUs: 0, toUs: 1 };
  private range: Range = { low: 0, high: 1 };
  private step = 0;

  constructor(
    engine: typeof UPlotType,
    place: HTMLElement,
    size: { width: number; height: number },
    private palette: Palette,
    private readonly options: ViewOptions,
  ) {
    this.plot = new engine(this.settings(size), [[0, 1]], place);
  }

  /** Where the traces are (CSS pixels). */
  get box(): Box {
    const { left, top, width, height } = this.plot.bbox;
    const ratio = this.ratio;
    return { left: left / ratio, top: top / ratio, width: width / ratio, height: height / ratio };
  }

  resize(size: { width: number; height: number }): void {
    this.plot.setSize(size);
  }

  recolour(palette: Palette): void {
    this.palette = palette;
  }

  /** Draw all, once, at the end of the running task. */
  paint(span: Span, range: Range, inside: (plot: Plot) => void): void {
    this.span = span;
    this.range = range;
    this.drawInside = inside;
    const step = timeStep(lengthOf(span), this.box.width / TICK_APART);
    if (step !== this.step) this.ticks.clear();
    this.step = step;
    this.plot.batch(() => {
      this.plot.setScale("x", { min: span.fromUs, max: span.toUs });
      this.plot.setScale("y", { min: range.low, max: range.high });
      // A change of colour alone moves no scale, but must be drawn.
      this.plot.redraw(false, false);
    });
  }

  destroy(): void {
    this.plot.destroy();
  }

  private get ratio(): number {
    return this.plot.ctx.canvas.width / Math.max(1, this.plot.width);
  }

  private settings(size: { width: number; height: number }): UPlotType.Options {
    const { bare } = this.options;
    return {
      ...size,
      padding: [8, 10, 0, bare ? 10 : 0],
      legend: { show: false },
      cursor: { show: false },
      series: [{}],
      scales: { x: { time: false, auto: false, range: (_u, min, max) => [min, max] }, y: { auto: false, range: () => [this.range.low, this.range.high] } },
      axes: [this.timeAxis(), this.valueAxis()],
      hooks: { draw: [this.draw] },
    };
  }

  private timeAxis(): UPlotType.Axis {
    return {
      ...this.look(),
      size: TYPE + 16,
      splits: (_u, _axis, min, max) => timeTicks(min, max, this.step || 1e6, this.options.clock),
      values: (_u, splits) => splits.map((us) => (this.hasRoom(us) ? this.tickText(us) : "")),
    };
  }

  private valueAxis(): UPlotType.Axis {
    const { axisWidth, bare } = this.options;
    return {
      ...this.look(),
      show: !bare,
      scale: "y",
      space: 30,
      // uPlot asks once before it has any values, whatever its types say.
      size: (_u, values: string[] | null) => Math.max(axisWidth, ...(values ?? []).map((text) => text.length * CHAR + GAP + 8)),
      values: (_u, splits, _axis, _space, step) => {
        const decimals = decimalsOf(step);
        return splits.map((value) => formatNumber(value, decimals));
      },
    };
  }

  private look(): UPlotType.Axis {
    return {
      stroke: () => this.palette.muted,
      font: `${String(TYPE)}px ${this.palette.font}`,
      gap: GAP,
      grid: { stroke: () => this.palette.line, width: 1 },
      ticks: { show: false },
    };
  }

  // A label too near to the edge would be cut.
  private hasRoom(us: number): boolean {
    const { left, width } = this.box;
    const x = left + ((us - this.span.fromUs) / lengthOf(this.span)) * width;
    return x >= LABEL_HALF && x <= this.plot.width - LABEL_HALF;
  }

  private tickText(us: number): string {
    let text = this.ticks.get(us);
    if (text === undefined) {
      if (this.ticks.size > 200) this.ticks.clear();
      text = tickText(us, this.step, this.options.clock);
      this.ticks.set(us, text);
    }
    return text;
  }

  private readonly draw = (plot: UPlotType): void => {
    const { left, top, width, height } = plot.bbox;
    const inside: Plot = {
      ctx: plot.ctx,
      left,
      top,
      width,
      height,
      span: this.span,
      range: this.range,
      ratio: this.ratio,
      font: this.palette.font,
    };
    clipped(inside, () => {
      this.drawInside(inside);
    });
  };
}
