import { expect, test } from "vitest";
import { registerWorker, WORKER_PATH } from "../../src/worker/shell-worker.js";

test("while the pages are developed there is no shell to keep, and messages go on by their own worker", () => {
  expect(WORKER_PATH).toBe("/push.js");
  const check = registerWorker(undefined, () => {
    throw new Error("nothing is new");
  });
  expect(() => {
    check();
  }).not.toThrow();
});
