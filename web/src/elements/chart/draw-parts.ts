/** What stands on a chart's canvas between its axes: traces, bands, states and gaps. */

import { msg } from "@lit/localize";
import type { Columns } from "../../series/columns.js";
import type { StateRun } from "../../series/state-runs.js";
import type { AxisRange } from "../../series/axis-range.js";
import { lengthOf, type TimeSpan } from "../../series/time-window.js";
import type { GapShape } from "../../generated/api.js";

/** The place to draw in (canvas pixels), with what its sides stand for. */
export interface Plot {
  readonly ctx: CanvasRenderingContext2D;
  readonly left: number;
  readonly top: number;
  readonly width: number;
  readonly height: number;
  readonly span: TimeSpan;
  readonly range: AxisRange;
  /** Canvas pixels for one CSS pixel. */
  readonly ratio: number;
  readonly font: string;
}

const LINE = 1.6;
const BAND = 0.3;
const OUTLINE = 0.6;
const DOT = 2.6;
/** So many columns, on average no further apart than this (canvas pixels), are drawn pixel by pixel. */
const DENSE = 64;
const DENSE_APART = 2.5;

export function xOf(plot: Plot, us: number): number {
  return plot.left + ((us - plot.span.fromUs) / lengthOf(plot.span)) * plot.width;
}

export function yOf(plot: Plot, value: number): number {
  const { low, high } = plot.range;
  return plot.top + (1 - (value - low) / (high - low)) * plot.height;
}

/** Draw inside the plot only. */
export function drawClipped(plot: Plot, draw: () => void): void {
  plot.ctx.save();
  plot.ctx.beginPath();
  plot.ctx.rect(plot.left, plot.top, plot.width, plot.height);
  plot.ctx.clip();
  draw();
  plot.ctx.restore();
}

export interface TraceLook {
  /** CSS pixels drawn and left out, in turn; empty for an unbroken line. */
  readonly dash: readonly number[];
  /** The newest sample is marked. */
  readonly dot: boolean;
  /** The band has an outline, so that a spike one pixel wide is not overlooked. */
  readonly outlined: boolean;
  /** How much of the colour is seen; 1 for all. */
  readonly faint?: number;
}

/** A line through the means and, where a column holds more than one value, a band from least to greatest. */
export function drawTrace(plot: Plot, columns: Columns, colour: string, options: TraceLook): void {
  const { ctx } = plot;
  const first = Math.max(0, columns.firstFrom(plot.span.fromUs) - 1);
  const line = new Path2D();
  const band = new Path2D();
  const outline = new Path2D();
  const faint = options.faint ?? 1;
  let last = first;
  let thick = false;
  let dense = false;
  ctx.fillStyle = colour;
  ctx.globalAlpha = BAND * faint;
  for (let i = first; i < columns.length; i = last) {
    last = runEnd(columns, i, plot.span.toUs);
    traceLine(plot, columns, i, last, line);
    if (isThick(columns, i, last)) {
      thick = true;
      traceBand(plot, columns, i, last, outline);
      if (isDense(plot, columns, i, last)) {
        dense = true;
        fillDense(plot, columns, i, last);
      } else traceBand(plot, columns, i, last, band);
    }
    if (last < columns.length && columns.timeAt(last) > plot.span.toUs) break;
  }
  if (thick) {
    ctx.fill(band);
    ctx.globalAlpha = OUTLINE * faint;
    ctx.strokeStyle = colour;
    ctx.lineWidth = plot.ratio;
    if (options.outlined) ctx.stroke(outline);
  }
  ctx.globalAlpha = faint;
  ctx.strokeStyle = colour;
  // Through a band that changes with every pixel a broad line takes ten times as long, and hides it.
  ctx.lineWidth = (dense ? 1 : LINE) * plot.ratio;
  ctx.lineJoin = "bevel";
  ctx.lineCap = "round";
  ctx.setLineDash(options.dash.map((pixels) => pixels * plot.ratio));
  ctx.stroke(line);
  ctx.globalAlpha = 1;
  if (options.dot && columns.length > 0) drawDot(plot, columns, colour);
}

/** Index after the last column of the unbroken stretch that begins at `from`; one beyond the window counts. */
function runEnd(columns: Columns, from: number, toUs: number): number {
  let end = from + 1;
  while (end < columns.length && !columns.isBroken(end) && columns.timeAt(end - 1) <= toUs) end += 1;
  return end;
}

function traceLine(plot: Plot, columns: Columns, from: number, to: number, path: Path2D): void {
  const x = xOf(plot, columns.timeAt(from));
  const y = yOf(plot, columns.meanAt(from));
  path.moveTo(x, y);
  // A sample that stands alone is a dot: the round cap of a line without length.
  if (to === from + 1) path.lineTo(x + 0.01, y);
  for (let i = from + 1; i < to; i += 1) path.lineTo(xOf(plot, columns.timeAt(i)), yOf(plot, columns.meanAt(i)));
}

function isThick(columns: Columns, from: number, to: number): boolean {
  for (let i = from; i < to; i += 1) if (columns.maxAt(i) > columns.minAt(i)) return true;
  return false;
}

/** Whether there is a column for about every pixel. */
function isDense(plot: Plot, columns: Columns, from: number, to: number): boolean {
  return to - from > DENSE && to - from > (xOf(plot, columns.timeAt(to - 1)) - xOf(plot, columns.timeAt(from))) / DENSE_APART;
}

/** A band pixel by pixel: one shape with thousands of corners would take several times as long. */
function fillDense(plot: Plot, columns: Columns, from: number, to: number): void {
  const { ctx } = plot;
  let left = Math.floor(xOf(plot, columns.timeAt(from)));
  let top = Infinity;
  let bottom = -Infinity;
  for (let i = from; i < to; i += 1) {
    const x = Math.floor(xOf(plot, columns.timeAt(i)));
    if (x > left) {
      ctx.fillRect(left, top, x - left, bottom - top);
      left = x;
      top = Infinity;
      bottom = -Infinity;
    }
    top = Math.min(top, yOf(plot, columns.maxAt(i)));
    bottom = Math.max(bottom, yOf(plot, columns.minAt(i)));
  }
  ctx.fillRect(left, top, 1, bottom - top);
}

function traceBand(plot: Plot, columns: Columns, from: number, to: number, path: Path2D): void {
  if (to === from + 1) {
    const x = xOf(plot, columns.timeAt(from));
    path.rect(x - plot.ratio / 2, yOf(plot, columns.maxAt(from)), plot.ratio, yOf(plot, columns.minAt(from)) - yOf(plot, columns.maxAt(from)));
    return;
  }
  path.moveTo(xOf(plot, columns.timeAt(from)), yOf(plot, columns.maxAt(from)));
  for (let i = from + 1; i < to; i += 1) path.lineTo(xOf(plot, columns.timeAt(i)), yOf(plot, columns.maxAt(i)));
  for (let i = to - 1; i >= from; i -= 1) path.lineTo(xOf(plot, columns.timeAt(i)), yOf(plot, columns.minAt(i)));
  path.closePath();
}

function drawDot(plot: Plot, columns: Columns, colour: string): void {
  const last = columns.length - 1;
  plot.ctx.beginPath();
  plot.ctx.arc(xOf(plot, columns.timeAt(last)), yOf(plot, columns.meanAt(last)), DOT * plot.ratio, 0, 2 * Math.PI);
  plot.ctx.fillStyle = colour;
  plot.ctx.fill();
}

/** Hatched stretches without samples, with the reason where there is room for it. */
export function drawGaps(plot: Plot, gaps: readonly GapShape[], ink: string): void {
  const { ctx, ratio } = plot;
  for (const gap of gaps) {
    const left = Math.max(plot.left, xOf(plot, gap.from_us));
    const right = Math.min(plot.left + plot.width, xOf(plot, gap.to_us));
    if (right <= left) continue;
    const width = Math.max(right - left, ratio);
    ctx.save();
    ctx.beginPath();
    ctx.rect(left, plot.top, width, plot.height);
    ctx.clip();
    ctx.fillStyle = ink;
    ctx.globalAlpha = 0.1;
    ctx.fillRect(left, plot.top, width, plot.height);
    drawHatch(plot, left, width, ink);
    ctx.globalAlpha = 1;
    drawGapReason(plot, gap, left, width, ink);
    ctx.restore();
  }
}

function drawHatch(plot: Plot, left: number, width: number, ink: string): void {
  const { ctx, ratio, top, height } = plot;
  const apart = 9 * ratio;
  ctx.beginPath();
  for (let x = Math.floor((left - height) / apart) * apart; x < left + width; x += apart) {
    ctx.moveTo(x, top + height);
    ctx.lineTo(x + height, top);
  }
  ctx.strokeStyle = ink;
  ctx.lineWidth = ratio;
  ctx.globalAlpha = 0.22;
  ctx.setLineDash([]);
  ctx.stroke();
}

function drawGapReason(plot: Plot, gap: GapShape, left: number, width: number, ink: string): void {
  const { ctx, ratio } = plot;
  const text = gap.reason === "" ? msg("no samples") : gap.reason;
  ctx.font = `${String(11 * ratio)}px ${plot.font}`;
  const size = ctx.measureText(text).width;
  if (size + 12 * ratio > width) return;
  ctx.textAlign = "center";
  ctx.textBaseline = "top";
  ctx.fillStyle = ink;
  ctx.fillText(text, left + width / 2, plot.top + 5 * ratio);
}

/** How a state looks: its word, and its place among the colours. */
export interface StateLook {
  readonly word: string;
  readonly colour: string;
}

/** States as bars, one after the other, with their words where there is room. */
export function drawRuns(plot: Plot, runs: readonly StateRun[], lookOf: (value: number) => StateLook, ink: string): void {
  const { ctx, ratio } = plot;
  const top = plot.top + 3 * ratio;
  const height = plot.height - 6 * ratio;
  ctx.font = `600 ${String(12 * ratio)}px ${plot.font}`;
  ctx.textAlign = "left";
  ctx.textBaseline = "middle";
  for (const run of runs) {
    const left = Math.max(plot.left, xOf(plot, run.fromUs));
    const right = Math.min(plot.left + plot.width, xOf(plot, run.toUs));
    if (right <= left) continue;
    const look = lookOf(run.value);
    ctx.fillStyle = look.colour;
    ctx.globalAlpha = 0.35;
    ctx.fillRect(left, top, Math.max(right - left - ratio, ratio), height);
    ctx.globalAlpha = 1;
    // Where states change faster than pixels, the marks of their beginnings would hide them.
    if (right - left > 8 * ratio) ctx.fillRect(left, top, 3 * ratio, height);
    const word = cutTo(ctx, look.word, right - left - 16 * ratio);
    ctx.fillStyle = ink;
    ctx.fillText(word, left + 8 * ratio, top + height / 2);
  }
}

/** A text cut to a width (canvas pixels); empty where hardly a letter would be left. */
function cutTo(ctx: CanvasRenderingContext2D, text: string, width: number): string {
  const full = ctx.measureText(text).width;
  if (full <= width) return text;
  const letters = Math.floor((text.length * width) / full) - 1;
  return letters < LEAST_LETTERS ? "" : `${text.slice(0, letters)}…`;
}

const LEAST_LETTERS = 4;
