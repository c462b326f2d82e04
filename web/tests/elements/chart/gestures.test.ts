import { expect, test } from "vitest";
import { Gestures } from "../../../src/elements/chart/gestures.js";
import type { TimeSpan } from "../../../src/series/time-window.js";

/** A chart of 100 pixels, and what its window is asked to be. */
class DraggedPlace extends EventTarget {
  readonly clientWidth = 100;
  readonly asked: TimeSpan[] = [];
  span: TimeSpan | null = null;

  constructor() {
    super();
    new Gestures(this as unknown as HTMLElement, {
      span: () => this.span,
      partAt: (x) => x / 100,
      moveCursor: () => undefined,
      showSelection: () => undefined,
      hideSelection: () => undefined,
      changeSpan: (span) => {
        this.asked.push(span);
      },
      resetSpan: () => undefined,
      zoomable: true,
    });
  }

  setPointerCapture(): void {
    // Nothing else is there to catch the pointer.
  }

  send(type: string, clientX: number, pointerType = "mouse"): void {
    this.dispatchEvent(Object.assign(new Event(type), { pointerId: 1, button: 0, shiftKey: false, clientX, pointerType }));
  }
}

test.each(["mouse", "touch"])("a drag by %s that begins before there is a window asks for none", (pointerType) => {
  const place = new DraggedPlace();
  place.send("pointerdown", 20, pointerType);
  place.send("pointermove", 50, pointerType);
  place.span = { fromUs: 0, toUs: 1000 };
  place.send("pointermove", 60, pointerType);
  place.send("pointerup", 60, pointerType);
  expect(place.asked).toEqual([]);
  place.send("pointerdown", 20, pointerType);
  place.send("pointermove", 60, pointerType);
  place.send("pointerup", 60, pointerType);
  expect(place.asked.at(-1)).toEqual(pointerType === "mouse" ? { fromUs: 200, toUs: 600 } : { fromUs: -400, toUs: 600 });
});
