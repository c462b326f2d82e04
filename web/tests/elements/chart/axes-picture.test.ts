import { describe, expect, it } from "vitest";
import { AxesPicture } from "../../../src/elements/chart/axes-picture.js";

/** A canvas whose picture is a word. */
class WordCanvas {
  width = 300;
  height = 150;
  picture = "";
  readonly pen = {
    canvas: this,
    globalCompositeOperation: "source-over",
    clearRect: (): void => {
      this.picture = "";
    },
    drawImage: ({ picture }: WordCanvas): void => {
      this.picture = this.pen.globalCompositeOperation === "copy" ? picture : this.picture + picture;
    },
  };

  getContext(): unknown {
    return this.pen;
  }

  get canvas(): HTMLCanvasElement {
    return this as unknown as HTMLCanvasElement;
  }
}

/** What a chart does with each picture; gives what is on its canvas, and whether the axes were drawn for it. */
function paint(axes: AxesPicture, chart: WordCanvas, key: string, trace: string): readonly [picture: string, drawn: boolean] {
  const kept = axes.drawOn(chart.pen as unknown as CanvasRenderingContext2D, key);
  if (!kept) {
    chart.picture = `axes of ${key}`;
    axes.keep(chart.canvas, key);
  }
  chart.picture += `, ${trace}`;
  return [chart.picture, !kept];
}

describe("the axes of a chart", () => {
  it("are drawn until they have been the same twice, and then put there without the traces of before", () => {
    const axes = new AxesPicture(new WordCanvas().canvas);
    const chart = new WordCanvas();
    const found = ["a", "b", "c", "d"].map((trace) => paint(axes, chart, "noon", trace));
    expect(found).toEqual([
      ["axes of noon, a", true],
      ["axes of noon, b", true],
      ["axes of noon, c", false],
      ["axes of noon, d", false],
    ]);
  });

  it("are drawn anew when they are others, and when they were forgotten", () => {
    const axes = new AxesPicture(new WordCanvas().canvas);
    const chart = new WordCanvas();
    for (const trace of ["a", "b", "c"]) paint(axes, chart, "noon", trace);
    expect(paint(axes, chart, "one", "d")).toEqual(["axes of one, d", true]);
    expect(paint(axes, chart, "noon", "e")).toEqual(["axes of noon, e", true]);
    paint(axes, chart, "noon", "f");
    expect(paint(axes, chart, "noon", "g")[1]).toBe(false);
    axes.forget();
    expect(paint(axes, chart, "noon", "h")).toEqual(["axes of noon, h", true]);
  });
});
