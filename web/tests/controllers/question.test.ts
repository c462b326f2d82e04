import type { ReactiveControllerHost } from "lit";
import { expect, test } from "vitest";
import { QuestionController } from "../../src/controllers/question.js";

const host: ReactiveControllerHost = {
  addController: () => undefined,
  removeController: () => undefined,
  requestUpdate: () => undefined,
  updateComplete: Promise.resolve(true),
};

/** All that was promised so far has come. */
const settled = async (): Promise<void> => {
  for (let turn = 0; turn < 10; turn += 1) await Promise.resolve();
};

test("a yes does what was asked about, and closes the question", async () => {
  const removed: string[] = [];
  const question = new QuestionController<string>(host, (name, action) =>
    action.run("remove it", () => Promise.resolve(removed.push(name))),
  );
  question.open("mail");
  question.confirm();
  await settled();
  expect([removed, question.isOpen]).toEqual([["mail"], false]);
});

test("what fails leaves the question open, with the reason", async () => {
  const question = new QuestionController<string>(host, (_name, action) =>
    action.run("remove it", () => Promise.reject(new Error("no"))),
  );
  question.open("mail");
  question.confirm();
  await settled();
  expect(question.isOpen).toBe(true);
  expect(question.action.problem).not.toBeNull();
});

test("asked anew it says nothing of the last failure", async () => {
  const question = new QuestionController<string>(host, (_name, action) =>
    action.run("remove it", () => Promise.reject(new Error("no"))),
  );
  question.open("mail");
  question.confirm();
  await settled();
  question.close();
  question.open("chat");
  expect(question.action.problem).toBeNull();
});

test("a yes to a question that is closed does nothing", async () => {
  let asked = 0;
  const question = new QuestionController<string>(host, () => Promise.resolve((asked += 1) > 0));
  question.confirm();
  await settled();
  expect(asked).toBe(0);
});
