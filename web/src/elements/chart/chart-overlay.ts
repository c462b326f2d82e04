/** What lies over a chart's canvas: the cursor with its values, and the stretch being chosen. */

import type { PlotBox } from "./uplot-view.js";

export class ChartOverlay {
  constructor(
    private readonly line: HTMLElement,
    private readonly values: HTMLElement,
    private readonly chosen: HTMLElement,
  ) {}

  /** @param part 0 at the left of the plot, 1 at its right */
  showCursor(box: PlotBox, part: number): void {
    const x = Math.round(box.left + part * box.width);
    this.line.hidden = false;
    this.line.style.cssText = `transform: translate(${String(x)}px, ${String(box.top)}px); block-size: ${String(box.height)}px`;
  }

  /** @param within the chart's whole width (CSS pixels) */
  showReadOut(box: PlotBox, part: number, within: number, text: string): void {
    const x = box.left + part * box.width;
    this.values.hidden = false;
    this.values.textContent = text;
    this.values.style.cssText = part < 0.5 ? `left: ${String(x + BESIDE)}px` : `right: ${String(within - x + BESIDE)}px`;
  }

  hideCursor(): void {
    this.line.hidden = true;
    this.hideReadOut();
  }

  hideReadOut(): void {
    this.values.hidden = true;
  }

  showSelection(box: PlotBox, from: number, to: number): void {
    const left = box.left + Math.min(from, to) * box.width;
    const width = Math.abs(to - from) * box.width;
    this.chosen.hidden = false;
    this.chosen.style.cssText =
      `transform: translate(${String(left)}px, ${String(box.top)}px); ` +
      `inline-size: ${String(width)}px; block-size: ${String(box.height)}px`;
  }

  hideSelection(): void {
    this.chosen.hidden = true;
  }
}

const BESIDE = 10;
