import { expect, test } from "vitest";
import type { CameraPicture } from "../../../src/generated/wire.js";
import { JpegPlayer } from "../../../src/elements/camera/jpeg-player.js";

const shot = (seq: number): CameraPicture => ({
  t: "shot", seq, time_us: 0, hub_us: 0, width: 1, height: 1, format: "jpeg", key: true, codec: "", small: false, data: new Uint8Array(),
});
const bitmap = { width: 1, height: 1, close: () => undefined } as ImageBitmap;

function desk(): { newest: JpegPlayer; drawn: number[]; paid: number[]; failed: number[]; finish: (good?: boolean) => Promise<void>; show: (seq: number) => void } {
  const drawn: number[] = [];
  const paid: number[] = [];
  const failed: number[] = [];
  let settle: ((good: boolean) => void) | null = null;
  const newest = new JpegPlayer({
    decode: () =>
      new Promise((resolve, reject) => {
        settle = (good) => {
          if (good) resolve(bitmap);
          else reject(new Error("spoilt"));
        };
      }),
    draw: (_bitmap, { seq }) => drawn.push(seq),
    failed: ({ seq }) => failed.push(seq),
  });
  return {
    newest, drawn, paid, failed,
    show: (seq) => {
      newest.receivePicture(shot(seq), () => paid.push(seq));
    },
    finish: async (good = true) => {
      settle?.(good);
      await new Promise((resolve) => setTimeout(resolve, 0));
    },
  };
}

test("a picture is paid for after it is drawn", async () => {
  const { drawn, paid, show, finish } = desk();
  show(1);
  expect(paid).toEqual([]);
  await finish();
  expect([drawn, paid]).toEqual([[1], [1]]);
});

test("of those that come while one is decoded only the newest is drawn; all are paid for", async () => {
  const { drawn, paid, show, finish } = desk();
  show(1);
  show(2);
  show(3);
  expect(paid).toEqual([2]);
  await finish();
  await finish();
  expect(drawn).toEqual([1, 3]);
  expect([...paid].sort()).toEqual([1, 2, 3]);
});

test("a spoilt picture is paid for too, and the next one is drawn", async () => {
  const { drawn, paid, failed, show, finish } = desk();
  show(1);
  await finish(false);
  show(2);
  await finish();
  expect([drawn, paid, failed]).toEqual([[2], [1, 2], [1]]);
});

test("nothing is drawn after it is closed", async () => {
  const { newest, drawn, failed, show, finish } = desk();
  show(1);
  newest.close();
  await finish();
  show(2);
  expect([drawn, failed]).toEqual([[], []]);
});
