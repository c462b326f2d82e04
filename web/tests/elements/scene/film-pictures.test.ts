import { afterEach, beforeEach, describe, expect, it, vi } from "vitest";
import { FilmPictures } from "../../../src/elements/scene/film-pictures.js";
import type { FilmListShape, FilmShape } from "../../../src/generated/api.js";
import type { ScenePicture } from "../../../src/scene/scene-model.js";
import { comeback } from "../../../src/wire/backoff.js";
import type { FilmPicture } from "../../../src/wire/films-api.js";
import { DecoderOfBytes, MadeChunk, settle } from "../camera/made-decoder.js";

const S = 1e6;
const HOUR = 3600 * S;
/** In the middle of an hour. */
const BEGIN = 500_000 * HOUR + 1800 * S;
const KEY = "/front/camera_info";
const FRONT = new Map([[KEY, "base/front"]]);

const film = (fromS: number, toS: number, more: Partial<FilmShape> = {}): FilmShape =>
  ({ id: `film${String(fromS)}`, stream: "base/front", state: "complete", begin_us: BEGIN + fromS * S, end_us: BEGIN + toS * S, pictures: 10, size: 10, have: 10, why: "", who: "", note: "", ...more });
const listOf = (films: readonly FilmShape[], more: Partial<FilmListShape> = {}): FilmListShape => ({ films, more: false, unfilmed: [], filming: [], may_film: false, why_not: "", ...more });

/** A picture each second, each of them whole: its byte is its second. */
function pictureAt(us: number): FilmPicture {
  const at = Math.floor((us - BEGIN) / S);
  const timeUs = BEGIN + at * S;
  return { codec: "avc1.42C01E", description: Uint8Array.of(1), timesUs: [timeUs], beforeUs: timeUs - S, nextUs: timeUs + S, data: [Uint8Array.of(at)] };
}

class Past {
  us = BEGIN + 2 * S;
  playing = false;
  isSettled = true;
  jumps = 0;
  readonly watchers = new Set<() => void>();

  subscribe(watcher: () => void): () => void {
    this.watchers.add(watcher);
    return () => this.watchers.delete(watcher);
  }

  update(): void {
    for (const watcher of [...this.watchers]) watcher();
  }

  seek(second: number): void {
    this.us = BEGIN + second * S;
    this.jumps += 1;
    this.update();
  }
}

class Page {
  hidden = false;
  readonly listeners = new Set<() => void>();

  addEventListener(_type: string, listener: () => void): void {
    this.listeners.add(listener);
  }

  removeEventListener(_type: string, listener: () => void): void {
    this.listeners.delete(listener);
  }

  show(hidden: boolean): void {
    this.hidden = hidden;
    for (const listener of this.listeners) listener();
  }
}

function makePictures() {
  const past = new Past();
  const page = new Page();
  const shown = new Map<string, ScenePicture>();
  const words = new Map<string, string>();
  const missing = new Map<string, boolean>();
  const hub = { list: listOf([film(0, 10)]), lists: [] as [number, number][], asked: [] as number[], broken: "", waits: [] as (() => void)[], holds: false, aborted: 0 };
  let now = 0;
  const pictures = new FilmPictures(
    {
      site: "agv", past, page, now: () => now,
      copyFrame: (frame) => ({ number: (frame as unknown as { picture: number }).picture, close: () => undefined }) as unknown as ImageBitmap,
      lists: {
        listFilms: (_site, fromUs, toUs) => {
          hub.lists.push([fromUs, toUs]);
          return hub.broken === "lists" ? Promise.reject(new Error("away")) : Promise.resolve(hub.list);
        },
      },
      pictures: {
        findPicture: async (_site, _film, us, signal) => {
          hub.asked.push((us - BEGIN) / S);
          signal?.addEventListener("abort", () => {
            hub.aborted += 1;
          });
          if (hub.holds) await new Promise<void>((resolve) => hub.waits.push(resolve));
          if (hub.broken === "pictures") throw new Error("gone");
          return pictureAt(us);
        },
      },
    },
    {
      onPicture: (key, picture) => {
        if (picture === null) shown.delete(key);
        else shown.set(key, picture);
      },
      onTrouble: (key, why) => words.set(key, why),
      onMissing: (key, is) => missing.set(key, is),
    },
  );
  const pass = async (ms: number): Promise<void> => {
    now += ms;
    vi.advanceTimersByTime(ms);
    await settle();
  };
  const seek = async (second: number): Promise<void> => {
    past.seek(second);
    await pass(1000);
  };
  const number = (): unknown => (shown.get(KEY)?.image as unknown as { number: number } | undefined)?.number;
  return { pictures, past, page, shown, words, missing, hub, pass, seek, number };
}

describe("films' pictures in a scene of a past moment", () => {
  beforeEach(() => {
    vi.useFakeTimers();
    vi.stubGlobal("VideoDecoder", DecoderOfBytes);
    vi.stubGlobal("EncodedVideoChunk", MadeChunk);
    DecoderOfBytes.made = [];
  });
  afterEach(() => {
    vi.useRealTimers();
    vi.unstubAllGlobals();
  });

  it("are those of the moment, with the time at which they came", async () => {
    const { pictures, shown, seek, number, pass } = makePictures();
    pictures.followStreams(FRONT);
    await pass(0);
    expect(number()).toBe(2);
    expect(shown.get(KEY)).toMatchObject({ timeUs: BEGIN + 2 * S, heardMs: (BEGIN + 2 * S) / 1000, rectified: false });
    await seek(7.5);
    expect(number()).toBe(7);
    expect(shown.get(KEY)?.heardMs).toBe((BEGIN + 7 * S) / 1000);
  });

  it("are taken away beyond a film, which is said, and stand there again within it", async () => {
    const { pictures, shown, words, missing, seek, pass, number } = makePictures();
    pictures.followStreams(FRONT);
    await pass(0);
    await seek(60);
    expect([shown.size, words.get(KEY), missing.get(KEY)]).toEqual([0, "No film of this moment", true]);
    await seek(3);
    expect([number(), words.get(KEY), missing.get(KEY)]).toEqual([3, "", false]);
  });

  it("say in words why there are none of a film that is not whole, or of a camera without any", async () => {
    const { pictures, words, hub, pass } = makePictures();
    hub.list = listOf([film(0, 10, { state: "uploading" })]);
    pictures.followStreams(new Map([...FRONT, ["/rear/camera_info", "base/rear"]]));
    await pass(0);
    expect([...words]).toEqual([[KEY, "This film is still being uploaded"], ["/rear/camera_info", "No film of this moment"]]);
    expect(hub.asked).toEqual([]);
  });

  it("are asked for five times a second while somebody plays, and two at a time however slow the hub is", async () => {
    const { pictures, past, hub, pass, seek, number } = makePictures();
    hub.list = listOf([film(0, 60)]);
    pictures.followStreams(FRONT);
    await pass(0);
    past.playing = true;
    // 2 s at ten times the speed, drawn as often as a board is: each time it is another picture's.
    const play = async (): Promise<void> => {
      for (let i = 0; i < 20; i += 1) {
        past.us += S;
        past.update();
        await pass(100);
      }
    };
    await play();
    expect(hub.asked.length).toBe(1 + 9);
    past.playing = false;
    past.update();
    await pass(500);
    expect(number()).toBe(22);
    await seek(0);
    past.playing = true;
    hub.holds = true;
    await play();
    expect(hub.waits.length).toBe(2);
  });

  it("are not asked for by a page that nobody sees", async () => {
    const { pictures, page, hub, seek, pass, number } = makePictures();
    pictures.followStreams(FRONT);
    await pass(0);
    const before = [hub.asked.length, hub.lists.length];
    page.show(true);
    await seek(5);
    await seek(4000);
    expect([hub.asked.length, hub.lists.length]).toEqual(before);
    await seek(5);
    page.show(false);
    await pass(0);
    expect(number()).toBe(5);
  });

  it("need one list of films for hours around, and another one beyond", async () => {
    const { pictures, past, hub, seek, pass } = makePictures();
    past.isSettled = false;
    pictures.followStreams(FRONT);
    await pass(0);
    expect(hub.lists).toEqual([]);
    past.isSettled = true;
    for (const second of [1, 5, 900, -900, 8]) await seek(second);
    expect(hub.lists).toEqual([[BEGIN - 1.5 * HOUR, BEGIN + 1.5 * HOUR]]);
    hub.list = listOf([], { more: true });
    await seek(3 * 3600);
    // More than a list has room for: a shorter stretch.
    expect(hub.lists.map(([from, to]) => (to - from) / HOUR)).toEqual([3, 3, 0.5]);
  });

  it("that cannot be had are said so, not asked for in vain, and had again at another moment or when the hub is back", async () => {
    const { pictures, past, shown, words, missing, hub, seek, pass, number } = makePictures();
    hub.broken = "pictures";
    pictures.followStreams(FRONT);
    await pass(0);
    expect([shown.size, missing.get(KEY)]).toEqual([0, true]);
    expect(words.get(KEY)).toContain("cannot be had");
    past.update();
    await pass(500);
    expect(hub.asked).toEqual([2]);
    hub.broken = "";
    await seek(4);
    expect([number(), words.get(KEY), missing.get(KEY)]).toEqual([4, "", false]);
    hub.broken = "lists";
    await seek(8 * 3600);
    expect([shown.size, words.get(KEY)]).toEqual([0, "The hub did not say which films there are."]);
    hub.broken = "";
    comeback.announce();
    await pass(0);
    expect(words.get(KEY)).toBe("No film of this moment");
  });

  it("are none without WebCodecs, which is said, and nothing is asked", async () => {
    vi.stubGlobal("VideoDecoder", undefined);
    const { pictures, words, missing, hub, pass } = makePictures();
    pictures.followStreams(FRONT);
    await pass(0);
    expect(words.get(KEY)).toContain("WebCodecs");
    expect([missing.get(KEY), hub.lists, hub.asked]).toEqual([true, [], []]);
  });

  it("end with the scene: questions, decoders and all that listens", async () => {
    const { pictures, past, page, shown, hub, seek, pass } = makePictures();
    pictures.followStreams(FRONT);
    await pass(0);
    hub.holds = true;
    await seek(6);
    pictures.close();
    hub.waits.forEach((answer) => {
      answer();
    });
    await pass(0);
    expect([shown.size, past.watchers.size, page.listeners.size]).toEqual([0, 0, 0]);
    expect(hub.aborted).toBeGreaterThan(0);
    expect(DecoderOfBytes.made.map(({ state }) => state)).toEqual(["closed"]);
  });
});
