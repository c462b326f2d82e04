/** uPlot as we use it: axes, grid and layout. The traces are drawn by `draw-parts.ts` from thinned columns. */

import type UPlotType from "uplot";
import { formatNumber } from "../../format/number.js";
import { decimalsOf, type AxisRange } from "../../series/axis-range.js";
import { tickText, timeStep, timeTicks } from "../../series/time-ticks.js";
import { lengthOf, type TimeSpan } from "../../series/time-window.js";
import type { ZoneClock } from "../../series/zone-clock.js";
import { AxesPicture } from "./axes-picture.js";
import { drawClipped, type Plot } from "./draw-parts.js";
import type { ChartIndent } from "./chart-model.js";
import { seriesColour, type Palette } from "./palette.js";

/** A rectangle in CSS pixels, from the chart's own corner. */
export interface PlotBox {
  readonly left: number;
  readonly top: number;
  readonly width: number;
  readonly height: number;
}

/** What stands beside a value axis, and in which colour. */
export interface AxisLook {
  /** Empty where the chart's surroundings say it. */
  readonly title: string;
  /** Place among the colours of series; -1 for the colour of all axes. */
  readonly colour: number;
}

export interface UplotViewOptions {
  readonly clock: ZoneClock;
  /** Width kept for each value axis (CSS pixels), so that charts below each other line up. */
  readonly axisWidth: number;
  /** The value axes, in turn left and right; none for states alone. */
  readonly axes: readonly AxisLook[];
  /** Room kept at the sides, also where no axes take it (CSS pixels). */
  readonly indent: ChartIndent;
}

const TICK_APART = 84;
const LABEL_HALF = 30;
const TYPE = 12;
const CHAR = 7;
const GAP = 6;
const TITLE = 14;

export class UplotView {
  private readonly plot: UPlotType;
  private readonly ticks = new Map<number, string>();
  private drawInside: (plot: Plot) => void = () => undefined;
  private span: TimeSpan = { fromUs: 0, toUs: 1 };
  private ranges: readonly AxisRange[] = [];
  private step = 0;
  private readonly axes = new AxesPicture();
  /** Of the axes that are drawn now; null: they are not those of `span` and `ranges`. */
  private axesKey: string | null = null;

  constructor(
    engine: typeof UPlotType,
    place: HTMLElement,
    size: { width: number; height: number },
    private palette: Palette,
    private readonly options: UplotViewOptions,
  ) {
    this.plot = new engine(this.uplotOptions(size), [[0, 1]], place);
  }

  /** Where the traces are (CSS pixels). */
  get plotBox(): PlotBox {
    const { left, top, width, height } = this.plot.bbox;
    const ratio = this.pixelRatio;
    return { left: left / ratio, top: top / ratio, width: width / ratio, height: height / ratio };
  }

  resize(size: { width: number; height: number }): void {
    this.axes.forget();
    this.plot.setSize(size);
  }

  recolour(palette: Palette): void {
    this.axes.forget();
    this.palette = palette;
  }

  /**
   * Draw all, once, at the end of the running task.
   *
   * @param ranges one for each axis; at least one
   */
  paintView(span: TimeSpan, ranges: readonly AxisRange[], inside: (plot: Plot) => void): void {
    this.span = span;
    this.ranges = ranges;
    this.drawInside = inside;
    const step = timeStep(lengthOf(span), this.plotBox.width / TICK_APART);
    // Another width alone moves no scale: the engine would keep the ticks of the old one.
    const others = step !== this.step;
    if (others) this.ticks.clear();
    this.step = step;
    const key = this.keyOfAxes();
    if (this.axes.drawOn(this.plot.ctx, key)) {
      this.drawPlot();
      return;
    }
    this.axesKey = key;
    this.plot.batch(() => {
      this.plot.setScale("x", { min: span.fromUs, max: span.toUs });
      ranges.forEach(({ low, high }, i) => {
        this.plot.setScale(scaleOf(i), { min: low, max: high });
      });
      // A change of colour alone moves no scale, but must be drawn.
      this.plot.redraw(false, others);
    });
    this.axesKey = null;
  }

  destroy(): void {
    this.plot.destroy();
  }

  private get pixelRatio(): number {
    return this.plot.ctx.canvas.width / Math.max(1, this.plot.width);
  }

  private uplotOptions(size: { width: number; height: number }): UPlotType.Options {
    const { axes, axisWidth, indent } = this.options;
    const titled = axes.some(({ title }) => title !== "");
    const left = Math.max(0, indent.left - Math.ceil(axes.length / 2) * axisWidth);
    const right = Math.max(0, indent.right - Math.floor(axes.length / 2) * axisWidth);
    return {
      ...size,
      padding: [titled ? 8 + TITLE : 8, right, 0, left],
      legend: { show: false },
      cursor: { show: false },
      series: [{}],
      scales: {
        x: { time: false, auto: false, range: (_u, min, max) => [min, max] },
        ...Object.fromEntries(Array.from({ length: Math.max(1, axes.length) }, (_, i) => [scaleOf(i), this.valueScale(i)])),
      },
      axes: [this.timeAxis(), ...axes.map((look, i) => this.valueAxis(look, i))],
      hooks: { drawAxes: [this.finishAxes], draw: [this.drawPlot] },
    };
  }

  private timeAxis(): UPlotType.Axis {
    return {
      ...this.gridLook(),
      size: TYPE + 16,
      splits: (_u, _axis, min, max) => timeTicks(min, max, this.step || 1e6, this.options.clock),
      values: (_u, splits) => splits.map((us) => (this.hasRoom(us) ? this.tickText(us) : "")),
    };
  }

  private valueScale(index: number): UPlotType.Scale {
    return {
      auto: false,
      range: () => {
        const { low, high } = this.ranges[index] ?? UNIT;
        return [low, high];
      },
    };
  }

  private valueAxis(axis: AxisLook, index: number): UPlotType.Axis {
    const { axisWidth } = this.options;
    const look = this.gridLook();
    return {
      ...look,
      stroke: () => this.inkOf(axis),
      // One grid: several would not meet.
      grid: { ...look.grid, show: index === 0 },
      scale: scaleOf(index),
      // The engine's names of the sides are gone at run time: 3 is left, 1 is right.
      // eslint-disable-next-line @typescript-eslint/no-unsafe-enum-assignment
      side: index % 2 === 0 ? 3 : 1,
      space: 30,
      // uPlot asks once before it has any values, whatever its types say.
      size: (_u, values: string[] | null) => Math.max(axisWidth, ...(values ?? []).map((text) => text.length * CHAR + GAP + 8)),
      values: (_u, splits, _axis, _space, step) => {
        const decimals = decimalsOf(step);
        return splits.map((value) => formatNumber(value, decimals));
      },
    };
  }

  private inkOf({ colour }: AxisLook): string {
    return colour < 0 ? this.palette.muted : seriesColour(this.palette, colour);
  }

  private gridLook(): UPlotType.Axis {
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
    const { left, width } = this.plotBox;
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

  /** The same for axes that look the same: ends of the values, and which marks of the time stand where (canvas pixels). */
  private keyOfAxes(): string {
    const { span, step } = this;
    const { canvas } = this.plot.ctx;
    const { left, width } = this.plot.bbox;
    const marks = timeTicks(span.fromUs, span.toUs, step, this.options.clock).map((us) => {
      const x = Math.round(left + width * ((us - span.fromUs) / (span.toUs - span.fromUs)));
      return `${String(us)} ${String(x)} ${String(this.hasRoom(us))}`;
    });
    return [canvas.width, canvas.height, step, ...this.ranges.flatMap(({ low, high }) => [low, high]), ...marks].join();
  }

  private readonly finishAxes = (): void => {
    this.drawTitles(this.inside());
    if (this.axesKey !== null) this.axes.keep(this.plot.ctx.canvas, this.axesKey);
  };

  private readonly drawPlot = (): void => {
    const inside = this.inside();
    drawClipped(inside, () => {
      this.drawInside(inside);
    });
  };

  /** Where the traces are, and what its sides stand for. */
  private inside(): Plot {
    const { plot } = this;
    const { left, top, width, height } = plot.bbox;
    return {
      ctx: plot.ctx,
      left,
      top,
      width,
      height,
      span: this.span,
      range: this.ranges[0] ?? UNIT,
      ratio: this.pixelRatio,
      font: this.palette.font,
    };
  }

  /** The unit over each axis, at its outer edge. */
  private drawTitles({ ctx, left, top, width, ratio }: Plot): void {
    const { axes, axisWidth } = this.options;
    ctx.save();
    ctx.font = `600 ${String(TYPE * ratio)}px ${this.palette.font}`;
    ctx.textBaseline = "bottom";
    axes.forEach((axis, i) => {
      const apart = (Math.floor(i / 2) * axisWidth + GAP) * ratio;
      ctx.textAlign = i % 2 === 0 ? "right" : "left";
      ctx.fillStyle = this.inkOf(axis);
      ctx.fillText(axis.title, i % 2 === 0 ? left - apart : left + width + apart, top - GAP * ratio);
    });
    ctx.restore();
  }
}

const UNIT: AxisRange = { low: 0, high: 1 };

function scaleOf(index: number): string {
  return `y${String(index)}`;
}
