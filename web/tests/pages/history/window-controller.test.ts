import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import { readView } from "../../../src/pages/history/history-query.js";
import { WindowController } from "../../../src/pages/history/window-controller.js";

const NOW = Date.parse("2026-11-21T10:00:00Z");
const US = NOW * 1000;

function page(first: string): { window: WindowController; went: string[]; search: () => string } {
  let search = first;
  const went: string[] = [];
  const host = { addController: () => undefined, removeController: () => undefined, requestUpdate: () => undefined, updateComplete: Promise.resolve(true) };
  const go = (to: string): void => {
    search = to;
    went.push(to);
  };
  return { window: new WindowController(host, { searchPart: () => search, navigate: go, width: () => 1000 }), went, search: () => search };
}

describe("the window of the history page", () => {
  beforeEach(() => {
    vi.useFakeTimers({ now: NOW });
    vi.stubGlobal("document", { visibilityState: "visible" });
  });
  afterEach(() => {
    vi.useRealTimers();
    vi.unstubAllGlobals();
  });

  it("stays where it is when it is asked for a window without moments", () => {
    const { window, went } = page("?last=60");
    window.applySpanChange({ span: { fromUs: Number.NaN, toUs: Number.NaN }, settled: true });
    window.applySpanChange({ span: { fromUs: Number.NaN, toUs: US }, settled: false });
    vi.advanceTimersByTime(1000);
    expect(went).toEqual([]);
    window.applySpanChange({ span: { fromUs: US - 100e6, toUs: US - 50e6 }, settled: true });
    expect(went).toEqual([`?from=${String(US - 100e6)}&to=${String(US - 50e6)}`]);
  });

  it("goes with the time while it follows, and stands while hands are at it", () => {
    const { window } = page("?last=60");
    window.hostConnected();
    expect(window.span).toEqual({ fromUs: US - 60e6, toUs: US });
    vi.advanceTimersByTime(3000);
    expect(window.span.toUs).toBe(US + 3e6);
    window.applySpanChange({ span: { fromUs: US - 100e6, toUs: US - 50e6 }, settled: false });
    vi.advanceTimersByTime(300);
    expect(window.span).toEqual({ fromUs: US - 100e6, toUs: US - 50e6 });
    window.hostDisconnected();
  });

  it("writes one line into the address bar for a whole row of keys", () => {
    const { window, went } = page("?c=a&last=60");
    for (const by of [10e6, 20e6, 30e6]) window.applySpanChange({ span: { fromUs: US - 60e6 - by, toUs: US - by }, settled: false });
    expect(went).toEqual([]);
    vi.advanceTimersByTime(1000);
    expect(went).toEqual([`?c=a&from=${String(US - 90e6)}&to=${String(US - 30e6)}`]);
  });

  it("does not run ahead of the time", () => {
    const { window } = page("?last=100");
    window.applySpanChange({ span: { fromUs: US, toUs: US + 100e6 }, settled: true });
    expect(window.span.toUs).toBe(US + 5e6);
  });

  it("goes back window by window, and never out of the page", () => {
    const { window, search } = page("?last=60");
    window.applySpanChange({ span: { fromUs: US - 50e6, toUs: US - 40e6 }, settled: true });
    window.applySpanChange({ span: { fromUs: US - 46e6, toUs: US - 44e6 }, settled: true });
    window.resetWindow();
    expect(readView(search()).shown).toEqual({ fromUs: US - 50e6, toUs: US - 40e6 });
    window.resetWindow();
    expect(readView(search()).shown).toEqual({ last: 60 });
    // Nothing is left to go back to: twice as much, and still not ahead of the time.
    window.resetWindow();
    expect(window.span).toEqual({ fromUs: US - 114e6, toUs: US + 6e6 });
  });
});
