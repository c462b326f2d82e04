import { expect, test } from "vitest";
import { formText } from "../../src/format/form-values.js";

test("what stands in a form is read without the blanks around it; a file or nothing is no text", () => {
  const said = new FormData();
  said.set("name", "  two words ");
  said.set("file", new Blob(["text"]));
  expect(["name", "file", "other"].map((name) => formText(said, name))).toEqual(["two words", "", ""]);
});
