import type { ReactiveControllerHost } from "lit";
import { expect, test } from "vitest";
import { OpenSubject } from "../../src/controllers/open-subject.js";

/** An element as far as a controller sees it: drawn again as often as it was asked. */
class DrawnHost implements ReactiveControllerHost {
  drawn = 0;
  readonly updateComplete = Promise.resolve(true);

  addController(): void {
    // Nothing of a life cycle is needed here.
  }

  removeController(): void {
    // Nothing either.
  }

  requestUpdate(): void {
    this.drawn += 1;
  }
}

test("what is opened is its subject until it is closed, and the element is drawn for both", () => {
  const host = new DrawnHost();
  const form = new OpenSubject<string>(host);
  expect(form.isOpen).toBe(false);
  form.open("rule 4");
  expect([form.isOpen, form.subject, host.drawn]).toEqual([true, "rule 4", 1]);
  form.close();
  expect([form.isOpen, form.subject, host.drawn]).toEqual([false, null, 2]);
});

test("an empty text is a subject too: a new thing has no id yet", () => {
  const form = new OpenSubject<string>(new DrawnHost());
  form.open("");
  expect(form.isOpen).toBe(true);
});

test("closing what is closed draws nothing", () => {
  const host = new DrawnHost();
  new OpenSubject<string>(host).close();
  expect(host.drawn).toBe(0);
});
