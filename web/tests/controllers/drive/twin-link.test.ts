import { beforeEach, describe, expect, test } from "vitest";
import { TwinLink } from "../../../src/controllers/drive/twin-link.js";
import type { TwinUpdate } from "../../../src/generated/wire.js";
import { FakeLine } from "./fake-connection.js";

const AT = { site: "agv", device: "base" } as const;
const FRAME = { epoch: 4, seq: 1, tick: 1, held_ms: 0, linear: 0.1, angular: 0, picture_ms: -1 };
const news = (live: boolean): TwinUpdate => ({
  t: "twin_news", ...AT, twin: "twin", live, who: "", why: "", path: [], metres: 0, seconds: 0, verdicts: [],
});

let line: FakeLine;
let ended: number;
let twin: TwinLink;

beforeEach(() => {
  line = new FakeLine();
  ended = 0;
  twin = new TwinLink(line, AT.site, AT.device, () => {
    ended += 1;
  });
  twin.open();
});

const frameIsLive = (): unknown => {
  const said = twin.messageOf({ ...AT, limits: { maxSpeed: 1, maxReverse: 1, maxTurn: 1 } }, FRAME);
  return said.t === "twin_drive" ? said.live : "another message";
};

describe("a frame for a twin", () => {
  test("never says live by itself, whatever the gateway says", () => {
    line.say(news(true));
    expect(frameIsLive()).toBe(false);
  });

  test("does not say live before the gateway has said so", () => {
    twin.setLive(true, 4);
    expect(line.take("twin_ask")).toMatchObject([{ ...AT, op: "live", epoch: 4 }]);
    expect(frameIsLive()).toBe(false);
    line.say(news(true));
    expect(frameIsLive()).toBe(true);
  });

  test("says live no more once the gateway has ended it, and not again by itself", () => {
    twin.setLive(true, 4);
    line.say(news(true));
    line.say(news(false));
    expect(ended).toBeGreaterThan(0);
    line.say(news(true));
    expect(frameIsLive()).toBe(false);
  });

  test("says live no more in the very turn in which it is switched off", () => {
    twin.setLive(true, 4);
    line.say(news(true));
    twin.setLive(false, 4);
    expect(frameIsLive()).toBe(false);
    expect(ended).toBeGreaterThan(0);
  });

  test("is not live after the site went away", () => {
    twin.setLive(true, 4);
    line.say(news(true));
    line.say({ t: "site", site: "agv", online: false, since_us: 0, catalogue: "", loop_ms: 0, skew_ms: 0, why: "", rival_us: 0, away: false });
    line.say(news(true));
    expect(frameIsLive()).toBe(false);
  });
});
