/** What lies over a chart's canvas: the cursor with its values, and the stretch being chosen. */

import type { Box } from "./uplot-view.js";

export class Overlay {
  constructor(
    private readonly line: HTMLElement,
    private readonly values: HTMLElement,
    private readonly chosen: HTMLElement,
  ) {}

  /** @param part 0 at the left of the plot, 1 at its right */
  cursor(box: Box, part: number): void {
    const x = Math.round(box.left + part * box.width);
    this.line.hidden = false;
    this.line.style.cssText = `transform: translate(${String(x)}px, ${String(box.top)}px); block-size: ${String(box.height)}px`;
  }

  /** @param within the chart's whole width (CSS pixels) */
  read(box: Box, part: number, within: number, text: string): void {
    const x = box.left + part * box.width;
    this.values.hidden = false;
    this.values.textContent = text;
    this.values.style.cssText = part < 0.5 ? `left: ${String(x + BESIDE)}px` : `right: ${String(within - x + BESIDE)}px`;
  }

  noCursor(): void {
    this.line.hidden = true;
    this.noRead();
  }

  noRead(): void {
    this.values.hidden = true;
  }

  choosing(box: Box, from: number, to: number): void {
    const left = box.left + Math.min(from, to) * box.width;
    const width = Math.abs(to - from) * box.width;
    this.chosen.hidden = false;
    this.chosen.style.cssText =
      `transform: translate(${String(left)}px, ${String(box.top)}px); ` +
      `inline-size: ${String(width)}px; block-size: ${String(box.height)}px`;
  }

  notChoosing(): void {
    this.chosen.hidden = true;
  }
}

const BESIDE = 10;
