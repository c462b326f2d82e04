import { beforeEach, expect, test } from "vitest";
import type { CameraPictureBoxes } from "../../../src/generated/wire.js";
import { BoxDelay } from "../../../src/tiles/camera/box-delay.js";
import { BoxSync } from "../../../src/tiles/camera/box-sync.js";

const FRAME_MS = 33;
const closed: number[] = [];

interface Shot {
  readonly seq: number;
  readonly time_us: number;
}
class Picture {
  constructor(readonly seq: number) {}
  close(): void {
    closed.push(this.seq);
  }
}

const boxes = (seq: number): CameraPictureBoxes => ({
  t: "shot_boxes", seq, time_us: seq * FRAME_MS * 1000,
  things: [{ t: "thing", label: "dog", score: 0.9, left: seq / 1000, top: 0, right: 1, bottom: 1 }],
});
const shot = (seq: number): Shot => ({ seq, time_us: seq * FRAME_MS * 1000 });
const at = (seq: number): number => seq * FRAME_MS;

let step: BoxSync<Picture, Shot>;
beforeEach(() => {
  closed.length = 0;
  step = new BoxSync();
});

/** What is on screen after each step: the picture's number, and of which picture the boxes are. */
interface Screen {
  readonly now: number;
  readonly seq: number;
  readonly of: number | null;
  readonly standing: string | null;
}

/** A camera at 30 Hz, each third picture looked at; the boxes come `late` ms after their picture. */
function film(frames: number, late: number, age = 40): Screen[] {
  const screens: Screen[] = [];
  let shown = 0;
  for (let now = 0; now <= at(frames); now += 1) {
    if (now % FRAME_MS === 0) step.addPicture(new Picture(now / FRAME_MS), shot(now / FRAME_MS), age, now);
    const seq = (now - late) / FRAME_MS;
    if (Number.isInteger(seq) && seq >= 0 && seq % 3 === 0) step.addBoxes(boxes(seq), now);
    const due = step.takeDuePicture(now);
    if (due !== null) shown = due.shot.seq;
    const seen = step.currentBoxes(now);
    const first = seen?.things[0];
    if (due !== null) screens.push({ now, seq: shown, of: first === undefined ? null : Math.round(first.left * 1000), standing: seen?.standing ?? null });
  }
  return screens;
}

test("once the detector's time is known, each picture it looked at is drawn with its own boxes", () => {
  const settled = film(90, 70).filter(({ now }) => now > 500);
  expect(settled.length).toBeGreaterThan(60);
  for (const { seq, of, standing } of settled) expect([seq, of, standing]).toEqual([seq, seq - (seq % 3), "same"]);
  const waits = settled.map(({ now, seq }) => now - at(seq));
  expect(Math.min(...waits)).toBe(80);
  expect(Math.max(...waits)).toBe(80);
});

test("every picture is drawn, in order, while they wait", () => {
  const seqs = film(60, 70).map(({ seq }) => seq);
  const settled = seqs.slice(seqs.indexOf(15));
  expect(settled).toEqual(settled.map((_, i) => 15 + i));
});

test("no picture waits where nothing is known to come", () => {
  step.addPicture(new Picture(1), shot(1), 40, 0);
  expect(step.takeDuePicture(0)?.shot.seq).toBe(1);
  expect(step.dueAt).toBeNull();
});

test("a detector that is too slow to wait for holds nothing up, and its late boxes are told as such", () => {
  const settled = film(60, 15 * FRAME_MS).filter(({ now }) => now > 700);
  for (const { now, seq } of settled) expect(now).toBe(at(seq));
  expect(new Set(settled.map(({ standing }) => standing))).toEqual(new Set(["earlier"]));
});

test("waiting makes no picture old that is live: what came late waits less, or not at all", () => {
  for (const [age, wait] of [[380, 20], [400, 0], [900, 0], [Number.NaN, 0]] as const) {
    step = new BoxSync();
    step.addPicture(new Picture(1), shot(1), 0, 0);
    step.addBoxes(boxes(1), 70);
    step.takeDuePicture(80);
    step.addPicture(new Picture(2), shot(2), age, 100);
    expect(step.dueAt).toBe(100 + wait);
  }
});

test("who drives gets the newest picture at once, what waited is closed, and boxes of before are told apart", () => {
  film(30, 70);
  step.addPicture(new Picture(31), shot(31), 40, at(31));
  step.setPrompt(true);
  expect(step.takeDuePicture(at(31))?.shot.seq).toBe(31);
  expect([step.dueAt, closed]).toEqual([null, expect.arrayContaining([29, 30])]);
  expect(closed).not.toContain(31);
  expect(step.currentBoxes(at(31))?.standing).toBe("earlier");
  step.addBoxes(boxes(31), at(31) + 60);
  expect(step.currentBoxes(at(31) + 60)?.standing).toBe("same");
  expect(step.currentBoxes(at(31) + 5000)?.standing).toBe("same");
});

test("a driver's boxes of an earlier picture are gone after 300 ms, also when no new picture comes", () => {
  step.setPrompt(true);
  step.addPicture(new Picture(1), shot(1), 40, 0);
  step.takeDuePicture(0);
  step.addBoxes(boxes(1), 50);
  step.addPicture(new Picture(2), shot(2), 40, FRAME_MS);
  step.takeDuePicture(FRAME_MS);
  expect(step.currentBoxes(FRAME_MS)?.standing).toBe("earlier");
  expect(step.currentBoxes(300)?.standing).toBe("earlier");
  expect(step.currentBoxes(301)).toBeNull();
  step.addPicture(new Picture(11), shot(11), 40, 400);
  step.takeDuePicture(400);
  expect(step.currentBoxes(400)).toBeNull();
});

test("boxes that are newer than the picture on screen wait for theirs", () => {
  step.addPicture(new Picture(1), shot(1), 40, 0);
  step.takeDuePicture(0);
  step.addBoxes(boxes(2), 10);
  expect(step.currentBoxes(10)).toBeNull();
  step.addPicture(new Picture(2), shot(2), Number.NaN, 20);
  step.takeDuePicture(20);
  expect(step.currentBoxes(20)?.things).toEqual(boxes(2).things);
});

test("boxes of a picture that was left out are drawn on the next one", () => {
  step.addPicture(new Picture(1), shot(1), 40, 0);
  step.addPicture(new Picture(3), shot(3), 40, 66);
  step.takeDuePicture(66);
  step.addBoxes(boxes(2), 70);
  expect([step.currentBoxes(70)?.standing, step.currentBoxes(70)?.things]).toEqual(["same", boxes(2).things]);
});

test("the same boxes are the same object, so that nothing is drawn anew for each picture", () => {
  step.addPicture(new Picture(1), shot(1), 40, 0);
  step.takeDuePicture(0);
  step.addBoxes(boxes(1), 10);
  const first = step.currentBoxes(10);
  step.addPicture(new Picture(2), shot(2), Number.NaN, 33);
  step.takeDuePicture(33);
  expect(step.currentBoxes(33)).toBe(first);
});

test("a camera that begins anew has nothing of before on it", () => {
  step.addPicture(new Picture(500), shot(500), 40, 0);
  step.addBoxes(boxes(500), 10);
  step.addPicture(new Picture(1), shot(1), 40, 40);
  step.takeDuePicture(400);
  expect([step.currentBoxes(400), step.lastBoxesAt]).toEqual([null, null]);
});

test("a decoder is never left without room: too many waiting pictures go, the oldest first", () => {
  step.addPicture(new Picture(0), shot(0), 40, 0);
  step.addBoxes(boxes(0), 280);
  step.takeDuePicture(280);
  for (let seq = 1; seq <= 20; seq += 1) step.addPicture(new Picture(seq), shot(seq), 40, 281);
  expect(closed).toEqual([1, 2, 3, 4, 5, 6, 7, 8]);
});

test("what waits is closed with the camera", () => {
  step.addPicture(new Picture(1), shot(1), 40, 0);
  step.addBoxes(boxes(1), 100);
  step.takeDuePicture(0);
  step.addPicture(new Picture(2), shot(2), 40, 101);
  step.close();
  expect([closed, step.takeDuePicture(1000), step.currentBoxes(1000)]).toEqual([[2], null, null]);
});

test("waiting follows what is measured: longer at once, shorter only when it is worth it, and never over the most", () => {
  const hold = new BoxDelay();
  expect(hold.delayMs(0)).toBe(0);
  hold.recordLatency(65, 0);
  expect(hold.delayMs(1)).toBe(80);
  hold.recordLatency(110, 2);
  expect(hold.delayMs(3)).toBe(120);
  hold.recordLatency(70, 3100);
  expect(hold.delayMs(3101)).toBe(80);
  hold.recordLatency(50, 6200);
  expect(hold.delayMs(6201)).toBe(80);
  hold.recordLatency(20, 9300);
  expect(hold.delayMs(9301)).toBe(40);
  hold.recordLatency(500, 12_400);
  expect(hold.delayMs(12_401)).toBe(0);
  hold.recordLatency(290, 15_500);
  expect(hold.delayMs(15_501)).toBe(300);
  expect(hold.delayMs(20_000)).toBe(0);
});

test("one late answer among many keeps nobody waiting for longer", () => {
  const hold = new BoxDelay();
  for (let number = 0; number < 29; number += 1) hold.recordLatency(60, number * 50);
  hold.recordLatency(280, 1500);
  expect(hold.delayMs(1501)).toBe(80);
});
