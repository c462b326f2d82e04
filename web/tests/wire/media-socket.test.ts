import { afterEach, beforeEach, describe, expect, test, vi } from "vitest";
import { comeback } from "../../src/wire/backoff.js";
import { mediaPath, MediaSocket, socketUrl, type MediaState } from "../../src/wire/media-socket.js";
import type { CameraPicture, CameraPictureBoxes } from "../../src/generated/wire.js";
import { FakeSocket } from "./fake-socket.js";

const sockets: FakeSocket[] = [];
const states: [MediaState, string][] = [];
const shots: [CameraPicture, () => void][] = [];
const troubles: string[] = [];
const seen: CameraPictureBoxes[] = [];

const opened: MediaSocket[] = [];

function open(): MediaSocket {
  const socket = new MediaSocket(
    {
      url: "ws://hub/ws/media",
      openSocket: () => {
        const socket = new FakeSocket();
        sockets.push(socket);
        return socket as unknown as WebSocket;
      },
      random: () => 0,
    },
    {
      onShot: (shot, shown) => shots.push([shot, shown]),
      onBoxes: (boxes) => seen.push(boxes),
      onTrouble: (why) => troubles.push(why),
      onState: (state, why) => states.push([state, why]),
    },
  );
  opened.push(socket);
  return socket;
}

/** What was sent but pings. */
const asked = (at: number): unknown[] => sockets[at]?.sent.filter(({ t }) => t !== "ping") ?? [];

const shot = { t: "shot", seq: 7, time_us: 1, hub_us: 2, width: 2, height: 1, format: "jpeg", data: new Uint8Array([9]) };

beforeEach(() => {
  vi.useFakeTimers();
  for (const list of [sockets, states, shots, troubles, seen]) list.length = 0;
});
afterEach(() => {
  for (const socket of opened.splice(0)) socket.close();
  vi.useRealTimers();
});

test("the next picture is asked for only once this one is drawn", () => {
  open();
  sockets[0]?.say(shot);
  expect(asked(0)).toEqual([]);
  shots[0]?.[1]();
  expect(asked(0)).toEqual([{ t: "shown", seq: 7 }]);
  expect(shots[0]?.[0].data).toEqual(new Uint8Array([9]));
});

test("a picture drawn after the loss asks nothing of a dead socket", () => {
  open();
  sockets[0]?.say(shot);
  sockets[0]?.die();
  shots[0]?.[1]();
  expect(asked(0)).toEqual([]);
});

test("it goes on once somebody has signed in again, and not after it was closed", () => {
  const camera = open();
  sockets[0]?.say({ t: "ended", reason: "your session is over" });
  vi.advanceTimersByTime(60_000);
  expect([sockets.length, states.at(-1)]).toEqual([1, ["refused", "your session is over"]]);
  comeback.announce();
  expect(sockets).toHaveLength(2);
  // One that stands is left alone.
  comeback.announce();
  camera.close();
  comeback.announce();
  expect(sockets).toHaveLength(2);
});

test("it comes back after a loss", () => {
  open();
  sockets[0]?.onopen?.();
  sockets[0]?.die();
  vi.advanceTimersByTime(125);
  expect(states.map(([state]) => state)).toEqual(["connecting", "open", "lost", "connecting"]);
});

test("a refusal is told in the hub's words and not tried again", () => {
  open();
  sockets[0]?.say({ t: "problem", code: "forbidden", message: "This camera is not yours to see." });
  vi.advanceTimersByTime(60_000);
  expect(states.at(-1)).toEqual(["refused", "This camera is not yours to see."]);
  expect(sockets).toHaveLength(1);
});

test("a camera that is away is tried again, and nonsense is answered with a fresh socket", () => {
  open();
  sockets[0]?.say({ t: "problem", code: "offline", message: "The site is not connected." });
  expect(states.at(-1)).toEqual(["lost", "The site is not connected."]);
  vi.advanceTimersByTime(125);
  sockets[1]?.onmessage?.({ data: new Uint8Array([0xc1]).buffer });
  vi.advanceTimersByTime(250);
  expect(sockets).toHaveLength(3);
});

test("a camera whose pictures cannot be shown says why and is not closed", () => {
  open();
  sockets[0]?.say({ t: "problem", code: "picture", message: "/i: 'yuv9' is not one of: rgb8" });
  expect(troubles).toEqual(["/i: 'yuv9' is not one of: rgb8"]);
  expect([sockets.length, sockets[0]?.closed]).toEqual([1, false]);
});

test("a hidden page says so once, and again to a fresh socket", () => {
  const media = open();
  sockets[0]?.onopen?.();
  media.setLowRate(true);
  media.setLowRate(true);
  expect(asked(0)).toEqual([{ t: "glance", still: true }]);
  sockets[0]?.die();
  vi.advanceTimersByTime(125);
  sockets[1]?.onopen?.();
  expect(asked(1)).toEqual([{ t: "glance", still: true }]);
  media.setLowRate(false);
  expect(asked(1).at(-1)).toEqual({ t: "glance", still: false });
});

test("boxes are asked for once, of a fresh socket again, and cost no receipt", () => {
  const media = open();
  sockets[0]?.onopen?.();
  media.requestBoxes(true);
  media.requestBoxes(true);
  const boxes = { t: "shot_boxes", seq: 7, time_us: 1, things: [{ t: "thing", label: "dog", score: 0.5, left: 0, top: 0, right: 1, bottom: 1 }] };
  sockets[0]?.say(boxes);
  expect(seen).toEqual([boxes]);
  expect(asked(0)).toEqual([{ t: "boxes_ask", on: true }]);
  sockets[0]?.die();
  vi.advanceTimersByTime(125);
  sockets[1]?.onopen?.();
  expect(asked(1)).toEqual([{ t: "boxes_ask", on: true }]);
  media.requestBoxes(false);
  expect(asked(1).at(-1)).toEqual({ t: "boxes_ask", on: false });
});

test("nothing is opened after it was closed", () => {
  const media = open();
  media.close();
  vi.advanceTimersByTime(60_000);
  expect([sockets.length, sockets[0]?.closed]).toEqual([1, true]);
});

test("the socket is as safe as the page", () => {
  expect(socketUrl("/ws", { protocol: "https:", host: "hub:8443" })).toBe("wss://hub:8443/ws");
  expect(socketUrl("/ws", { protocol: "http:", host: "127.0.0.1:1" })).toBe("ws://127.0.0.1:1/ws");
});

test("names in the address can not change its meaning", () => {
  expect(mediaPath("a&b", "camera/front", ["h264", "jpeg"])).toBe(
    "/ws/media?site=a%26b&stream=camera%2Ffront&forms=h264%2Cjpeg",
  );
  expect(mediaPath("a", "camera/front", ["jpeg"], true)).toBe("/ws/media/unblurred?site=a&stream=camera%2Ffront&forms=jpeg");
});

test("overlays are asked for beside boxes, and of a fresh socket again", () => {
  const socket = open();
  sockets[0]?.onopen?.();
  socket.requestOverlays(true);
  socket.requestOverlays(true);
  socket.requestBoxes(true);
  expect(asked(0)).toEqual([
    { t: "boxes_ask", on: false, overlays: true },
    { t: "boxes_ask", on: true, overlays: true },
  ]);
  sockets[0]?.die();
  vi.advanceTimersByTime(125);
  sockets[1]?.onopen?.();
  expect(asked(1)).toEqual([{ t: "boxes_ask", on: true, overlays: true }]);
});

describe("the age of a picture", () => {
  const elsewhere = (): number => 777;

  function answerPing(at: number, hubUs: number): void {
    const { n, at_ms } = sockets[at]?.sent.filter(({ t }) => t === "ping").at(-1) ?? {};
    sockets[at]?.say({ t: "pong", n, at_ms, hub_us: hubUs });
  }

  test("goes by the clock of the hub that sent it, asked over the same socket", () => {
    const media = open();
    sockets[0]?.onopen?.();
    answerPing(0, 5_000_000);
    vi.advanceTimersByTime(250);
    expect(media.ageMsOf(4_900_000, elsewhere)).toBeCloseTo(350);
  });

  test("is not known before that clock is, also of a fresh socket", () => {
    const media = open();
    sockets[0]?.onopen?.();
    expect(media.ageMsOf(1, elsewhere)).toBeNaN();
    answerPing(0, 5_000_000);
    sockets[0]?.die();
    vi.advanceTimersByTime(125);
    sockets[1]?.onopen?.();
    expect(media.ageMsOf(1, elsewhere)).toBeNaN();
  });

  test("goes by the page's other socket where the hub is too old to answer", () => {
    const media = open();
    sockets[0]?.onopen?.();
    vi.advanceTimersByTime(10_000);
    expect(media.ageMsOf(1, elsewhere)).toBe(777);
  });

  test("is followed by a few pings soon, and then by fewer", () => {
    const media = open();
    sockets[0]?.onopen?.();
    const pings = (): number => sockets[0]?.sent.filter(({ t }) => t === "ping").length ?? 0;
    vi.advanceTimersByTime(3000);
    expect(pings()).toBe(4);
    vi.advanceTimersByTime(10_000);
    expect(pings()).toBe(6);
    media.close();
    vi.advanceTimersByTime(10_000);
    expect(pings()).toBe(6);
  });
});
