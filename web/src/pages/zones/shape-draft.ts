/** What a person has drawn so far on one camera, with steps back. */

import type { ShapeEdit } from "../../elements/camera/shape-handles.js";
import { EditHistory } from "../../state/edit-history.js";
import type { JsonObject } from "../description/json-schema.js";
import { movedPoint, movedShape, newShape, readShapes, withoutPoint, withPointAfter, withShapes, type DrawnShape, type ShapeKind } from "./zone-shapes.js";

export class ShapeDraft {
  private edits: EditHistory;
  private before: string;

  /**
   * @param from the description that it was begun with
   * @param chosen the shape that has handles; -1 for none
   */
  constructor(
    private readonly from: JsonObject,
    readonly camera: string,
    public chosen: number,
  ) {
    this.before = JSON.stringify(readShapes(from, camera));
    this.edits = new EditHistory(this.before);
    this.chooseShape(chosen);
  }

  get shapes(): readonly DrawnShape[] {
    return JSON.parse(this.edits.text) as readonly DrawnShape[];
  }

  get isChanged(): boolean {
    return this.edits.text !== this.before;
  }

  get canUndo(): boolean {
    return this.edits.canUndo;
  }

  get canRedo(): boolean {
    return this.edits.canRedo;
  }

  /** The description with what is drawn. */
  described(): JsonObject {
    return withShapes(this.from, this.camera, this.shapes);
  }

  chooseShape(index: number): void {
    this.chosen = Math.min(index, this.shapes.length - 1);
  }

  addShape(kind: ShapeKind, counts: string): void {
    const { shapes } = this;
    this.record([...shapes, newShape(kind, counts, shapes)], false);
    this.chosen = shapes.length;
  }

  /** @param shape what stands there now; null for nothing */
  replaceShape(index: number, shape: DrawnShape | null, along: boolean): void {
    this.record(this.shapes.flatMap((each, at) => (at === index ? (shape === null ? [] : [shape]) : [each])), along);
    this.chooseShape(shape === null ? -1 : index);
  }

  applyEdit(edit: ShapeEdit): void {
    const shape = this.shapes[edit.shape];
    if (shape === undefined) return;
    switch (edit.what) {
      case "choose":
        this.chooseShape(edit.shape);
        return;
      case "move point":
        this.replaceShape(edit.shape, movedPoint(shape, edit.point, edit.to), edit.along);
        return;
      case "move":
        this.replaceShape(edit.shape, movedShape(shape, edit.dx, edit.dy), edit.along);
        return;
      case "add point":
        this.replaceShape(edit.shape, withPointAfter(shape, edit.after), false);
        return;
      case "delete point":
        this.replaceShape(edit.shape, withoutPoint(shape, edit.point), false);
        return;
    }
  }

  undoEdit(): void {
    this.edits.undoEdit();
    this.chooseShape(this.chosen);
  }

  redoEdit(): void {
    this.edits.redoEdit();
    this.chooseShape(this.chosen);
  }

  /** The gateway goes by it now, so nothing is changed any more. */
  keepEdits(): void {
    this.before = this.edits.text;
  }

  private record(shapes: readonly DrawnShape[], along: boolean): void {
    this.edits.recordEdit(JSON.stringify(shapes), along);
  }
}
