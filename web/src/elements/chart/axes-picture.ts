/** The axes of a chart as a picture, kept while they stay as they are: to write their numbers takes longer than to draw the traces. */

export class AxesPicture {
  private key = "";
  private holds = false;

  constructor(private readonly canvas: HTMLCanvasElement = document.createElement("canvas")) {}

  /** Puts the axes on a canvas, and clears the rest of it; false where others are kept. */
  drawOn(ctx: CanvasRenderingContext2D, key: string): boolean {
    if (!this.holds || key !== this.key) return false;
    const { width, height } = ctx.canvas;
    ctx.clearRect(0, 0, width, height);
    ctx.drawImage(this.canvas, 0, 0);
    return true;
  }

  /** Keeps what was drawn on a canvas, the second time that it is the same: of axes that move with each picture none is made. */
  keep(from: HTMLCanvasElement, key: string): void {
    this.holds = key === this.key;
    this.key = key;
    if (!this.holds) return;
    const { width, height } = from;
    // Another size empties it, too.
    if (this.canvas.width !== width || this.canvas.height !== height) [this.canvas.width, this.canvas.height] = [width, height];
    const ctx = this.canvas.getContext("2d");
    if (ctx === null) {
      this.holds = false;
      return;
    }
    ctx.globalCompositeOperation = "copy";
    ctx.drawImage(from, 0, 0);
  }

  /** What is kept is not true any more. */
  forget(): void {
    this.key = "";
    this.holds = false;
  }
}
