import { describe, expect, it } from "vitest";
import { EditHistory } from "../../src/state/edit-history.js";

describe("what was done to a text", () => {
  it("is taken back and done again", () => {
    const edits = new EditHistory("a");
    edits.recordEdit("b");
    edits.recordEdit("c");
    edits.undoEdit();
    expect(edits.text).toBe("b");
    edits.redoEdit();
    expect(edits.text).toBe("c");
    edits.undoEdit();
    edits.recordEdit("d");
    expect(edits.canRedo).toBe(false);
    edits.undoEdit();
    edits.undoEdit();
    edits.undoEdit();
    expect([edits.text, edits.canUndo]).toEqual(["a", false]);
  });

  it("takes typing back in one step", () => {
    const edits = new EditHistory("");
    edits.recordEdit("x");
    edits.recordEdit("xy", true);
    edits.recordEdit("xyz", true);
    edits.undoEdit();
    expect(edits.text).toBe("");
  });
});
