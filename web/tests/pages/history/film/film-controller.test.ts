import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import { FilmController } from "../../../../src/pages/history/film/film-controller.js";
import type { FilmListShape, FilmShape } from "../../../../src/generated/api.js";

const NAMES = new Map([["cam/front", "Front"]]);
const SPAN = { fromUs: 100e6, toUs: 160e6 };

function film(id: string, begin_us: number, end_us: number): FilmShape {
  return { id, stream: "cam/front", state: "complete", why: "", who: "", note: "", begin_us, end_us, size: 1, have: 1, pictures: 3 };
}

/** A page with these films in its window; what left the window is told in `left`. */
async function page(...films: readonly FilmShape[]): Promise<{ control: FilmController; left: number[] }> {
  const list: FilmListShape = { films: [...films], more: false, unfilmed: [], filming: [], may_film: false, why_not: "" };
  const left: number[] = [];
  const host = { addController: () => undefined, removeController: () => undefined, requestUpdate: () => undefined, updateComplete: Promise.resolve(true) };
  const control = new FilmController(host, () => ({ listFilms: () => Promise.resolve(list) }), (us) => left.push(us));
  control.load("site", SPAN, NAMES);
  await vi.waitFor(() => {
    control.load("site", SPAN, NAMES);
    expect(control.reels.length).toBe(films.length === 0 ? 0 : 1);
  });
  return { control, left };
}

describe("films and the charts' cursor", () => {
  beforeEach(() => {
    vi.useFakeTimers({ toFake: ["setTimeout", "clearTimeout", "performance"] });
    // There is no screen here: a frame comes every 16 ms.
    vi.stubGlobal("requestAnimationFrame", (draw: (nowMs: number) => void) =>
      setTimeout(() => {
        draw(performance.now());
      }, 16),
    );
    vi.stubGlobal("cancelAnimationFrame", clearTimeout);
  });
  afterEach(() => {
    vi.unstubAllGlobals();
    vi.useRealTimers();
  });

  it("begin with the first film, and have no cursor until a person wants one", async () => {
    const { control } = await page(film("a", 110e6, 120e6));
    expect([control.us, control.cursorUs]).toEqual([110e6, null]);
    control.previewMoment(115e6);
    expect([control.us, control.cursorUs]).toEqual([115e6, null]);
    control.seek(112e6);
    expect(control.cursorUs).toBe(112e6);
    // Another window: its own films count.
    control.load("site", { fromUs: 90e6, toUs: 111e6 }, NAMES);
    expect([control.us, control.cursorUs]).toEqual([110e6, null]);
  });

  it("play on with the next film where there is none, and stand at the last one's end", async () => {
    const { control, left } = await page(film("a", 110e6, 112e6), film("b", 150e6, 152e6));
    control.seek(111e6);
    control.play();
    vi.advanceTimersByTime(500);
    expect(control.us).toBeGreaterThan(111.4e6);
    expect(control.us).toBeLessThan(111.6e6);
    vi.advanceTimersByTime(1000);
    expect(control.us).toBeGreaterThan(150e6);
    expect(control.playing).toBe(true);
    vi.advanceTimersByTime(3000);
    expect(control.playing).toBe(false);
    expect(control.us).toBeGreaterThan(152e6);
    expect(control.us).toBeLessThan(152.3e6);
    expect(left).toEqual([]);
    // Played again from its end, it begins anew.
    control.play();
    expect(control.us).toBe(110e6);
  });

  it("stand still while a picture has not come, and turn the window when they leave it", async () => {
    const { control, left } = await page(film("a", 110e6, 300e6));
    control.setSpeed(16);
    control.seek(159e6);
    control.play();
    control.setWaiting(true);
    vi.advanceTimersByTime(2000);
    expect(control.us).toBe(159e6);
    control.setWaiting(false);
    vi.advanceTimersByTime(500);
    expect(left[0]).toBeGreaterThan(160e6);
  });

  it("are not there where the window has none", async () => {
    const { control } = await page();
    control.play();
    expect([control.us, control.playing, control.reels]).toEqual([null, false, []]);
  });
});
