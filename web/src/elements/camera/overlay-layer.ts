/** What a model tells of a picture, as it is drawn over it and said in words: pure sums. */

import { msg, str } from "@lit/localize";
import { fixedText } from "../../format/number.js";
import type { PictureModelShape } from "../../generated/api.js";
import type { OverlayLayer } from "../../generated/wire.js";

/** So many colours tell classes apart; a ninth class has the first one's, and its name. */
const COLOURS = 8;
/** A class that covers less than this is in the words below, and has no name on the picture. */
const NAMED_FROM = 0.02;
/** Depth comes in so many steps. */
export const DEPTH_STEPS = 15;
/** Classes that say what nothing else is: they are not painted. */
const PLAIN: ReadonlySet<string> = new Set(["background", "other", "others", "none", "nothing", "unlabeled", "unlabelled", "void"]);

/** A stretch of cells in one row. */
export interface CellRun {
  readonly row: number;
  readonly column: number;
  readonly length: number;
  readonly value: number;
}

/** A class on the picture: how much of it it covers (0 to 1), and where its name stands (parts of the picture). */
export interface CoveredClass {
  readonly number: number;
  readonly name: string;
  readonly share: number;
  readonly x: number;
  readonly y: number;
}

/** What a model told, and of which picture: of an earlier one than is shown, or of this one. */
export interface PictureOverlay {
  readonly model: PictureModelShape;
  readonly layer: OverlayLayer;
  readonly earlier: boolean;
}

/** The map's stretches, row by row; empty where its runs are not as many cells as it has. */
export function cellRuns({ rows, columns, runs }: Pick<OverlayLayer, "rows" | "columns" | "runs">): CellRun[] {
  const found: CellRun[] = [];
  let at = 0;
  for (let i = 0; i + 1 < runs.length; i += 2) {
    const value = runs[i + 1] ?? 0;
    let left = runs[i] ?? 0;
    while (left > 0 && at < rows * columns) {
      const column = at % columns;
      const length = Math.min(left, columns - column);
      const row = Math.floor(at / columns);
      const before = found.at(-1);
      // One stretch may have come in pieces.
      if (before?.row === row && before.value === value) found.splice(-1, 1, { ...before, length: before.length + length });
      else found.push({ row, column, length, value });
      at += length;
      left -= length;
    }
    if (left > 0) return [];
  }
  return at === rows * columns ? found : [];
}

/** Which of the colours a class has, from 1 on; 0 for what is not painted. */
export function colourNumber(model: Pick<PictureModelShape, "classes">, number: number): number {
  const name = model.classes[number];
  return name === undefined || PLAIN.has(name.toLowerCase()) ? 0 : (number % COLOURS) + 1;
}

/** The classes that are painted, the largest first, each with a place within it for its name. */
export function coveredClasses(model: Pick<PictureModelShape, "classes">, layer: OverlayLayer): CoveredClass[] {
  const of = new Map<number, CellRun[]>();
  for (const run of cellRuns(layer)) {
    if (colourNumber(model, run.value) === 0) continue;
    const runs = of.get(run.value);
    if (runs === undefined) of.set(run.value, [run]);
    else runs.push(run);
  }
  const cells = layer.rows * layer.columns;
  return [...of]
    .map(([number, runs]) => {
      const count = runs.reduce((sum, { length }) => sum + length, 0);
      const middle = runs.reduce((sum, { row, length }) => sum + row * length, 0) / count;
      // The longest stretch near its middle row: the name lies within the class, whatever its shape.
      const best = runs.reduce((one, other) => (other.length - Math.abs(other.row - middle) > one.length - Math.abs(one.row - middle) ? other : one));
      return {
        number,
        name: model.classes[number] ?? "",
        share: count / cells,
        x: (best.column + best.length / 2) / layer.columns,
        y: (best.row + 0.5) / layer.rows,
      };
    })
    .sort((one, other) => other.share - one.share);
}

/** Those whose names stand on the picture. */
export function namedClasses(model: Pick<PictureModelShape, "classes">, layer: OverlayLayer): CoveredClass[] {
  return coveredClasses(model, layer).filter(({ share }) => share >= NAMED_FROM);
}

/** `42 %`; of what is there, but hardly, `<1 %`. */
export function percentText(share: number): string {
  return share > 0 && share < 0.01 ? "<1\u00a0%" : `${String(Math.round(share * 100))}\u00a0%`;
}

function metresText(metres: number): string {
  return `${metres < 10 ? fixedText(metres, 1) : String(Math.round(metres))}\u00a0m`;
}

/** What a layer says, one fact a piece: `floor 42 %`, `2 persons`, `near 0.8 m`. */
export function layerWords(model: Pick<PictureModelShape, "classes" | "kind">, layer: OverlayLayer): string[] {
  switch (model.kind) {
    case "segmentation":
      return coveredClasses(model, layer).map(({ name, share }) => `${name} ${percentText(share)}`);
    case "classification":
      return layer.likely.map(({ label, share }) => `${label} ${percentText(share)}`);
    case "depth": {
      if (cellRuns(layer).every(({ value }) => value > DEPTH_STEPS)) return [msg("no depth")];
      const { near, far } = layer;
      return near === null || far === null ? [msg("bright is near"), msg("clear is far")] : [msg(str`bright is near, ${metresText(near)}`), msg(str`clear is far, ${metresText(far)}`)];
    }
    case "keypoints":
      return layer.poses.length === 0 ? [msg("nobody seen")] : [`${String(layer.poses.length)}\u00a0× ${model.classes[0] ?? "thing"}`];
    case "nanodet":
    case "yolo":
      return [];
  }
}
