/**
 * Pictures and what is seen on them, drawn together. Pure: it knows no clock, socket or canvas.
 *
 * A detector takes its time, so boxes come after their picture. Where nobody drives by this
 * picture, pictures wait for them for a little; where somebody does, none ever waits, and boxes of
 * an earlier picture are told apart from those of this one. See docs/decisions/0057.
 */

import type { CameraPictureBoxes, DetectedObject } from "../../generated/wire.js";
import { BoxDelay } from "./box-delay.js";

/** On a driver's picture, boxes of a picture this much earlier are gone (ms). */
export const EARLIER_MS = 300;
/** On others' they are marked from then on, and gone after this. */
export const LONGEST_MS = 1000;
/** Waiting never makes a picture look this old (ms); 500 is not live any more. */
const OLD_MS = 400;
/** More than these do not wait: a decoder has no end of room for them. */
const MOST_WAITING = 12;
const MOST_BOXES = 12;

/** `same`: of this picture, or so near to it that a person sees no difference. */
export type StandingBoxes = "same" | "earlier";

export interface CurrentBoxes {
  readonly things: readonly DetectedObject[];
  readonly standing: StandingBoxes;
}

export interface Timed {
  readonly seq: number;
  /** When it was taken (µs). */
  readonly time_us: number;
}

interface WaitingPicture<P, S> {
  readonly picture: P;
  readonly shot: S;
  readonly dueAt: number;
}

export class BoxSync<P extends { close(): void }, S extends Timed> {
  private waiting: WaitingPicture<P, S>[] = [];
  private boxes: CameraPictureBoxes[] = [];
  private arrivals: { readonly seq: number; readonly at: number }[] = [];
  private hold = new BoxDelay();
  private prompt = false;
  private shown: { readonly shot: S; readonly at: number } | null = null;
  private told: CurrentBoxes | null = null;
  private heardAt: number | null = null;

  /** From now on no picture waits, since somebody drives by them; or they may again. */
  setPrompt(prompt: boolean): void {
    this.prompt = prompt;
  }

  /** When boxes last came; null for never. */
  get lastBoxesAt(): number | null {
    return this.heardAt;
  }

  /** A picture is ready to be drawn. It is ours now; `age` is its own (ms), NaN where not known. */
  addPicture(picture: P, shot: S, age: number, now: number): void {
    const newest = this.arrivals.at(-1);
    // The camera began anew: numbers mean something else now.
    if (newest !== undefined && shot.seq < newest.seq) this.dropStaleBoxes();
    this.arrivals = [...this.arrivals.slice(-60), { seq: shot.seq, at: now }];
    if (this.boxes.some(({ seq }) => seq === shot.seq)) this.hold.recordLatency(0, now);
    // A picture whose age is not known is not live, and must not become older still.
    const room = Number.isFinite(age) ? Math.max(0, OLD_MS - age) : 0;
    const dueAt = now + (this.prompt ? 0 : Math.min(this.hold.delayMs(now), room));
    this.waiting.push({ picture, shot, dueAt });
    while (this.waiting.length > MOST_WAITING) this.waiting.shift()?.picture.close();
  }

  /** What is seen on a picture that came, will come, or was left out. */
  addBoxes(boxes: CameraPictureBoxes, now: number): void {
    this.heardAt = now;
    const arrival = this.arrivals.find(({ seq }) => seq === boxes.seq);
    if (arrival !== undefined) this.hold.recordLatency(now - arrival.at, now);
    this.boxes = [...this.boxes.filter(({ seq }) => seq !== boxes.seq), boxes].sort((a, b) => a.seq - b.seq).slice(-MOST_BOXES);
  }

  /** Nobody wants boxes any more. */
  clearBoxes(): void {
    this.boxes = [];
    this.hold = new BoxDelay();
    this.heardAt = null;
  }

  /** The picture to draw now, the newest that is due; what it overtakes is closed. */
  takeDuePicture(now: number): { readonly picture: P; readonly shot: S } | null {
    const due = this.waiting.filter(({ dueAt }) => this.prompt || dueAt <= now).at(-1);
    if (due === undefined) return null;
    for (const { picture } of this.waiting.splice(0, this.waiting.indexOf(due) + 1).slice(0, -1)) picture.close();
    this.shown = { shot: due.shot, at: now };
    return due;
  }

  /** When `due` has something next; null while nothing waits. */
  get dueAt(): number | null {
    return this.waiting.length === 0 ? null : Math.min(...this.waiting.map(({ dueAt }) => dueAt));
  }

  /** What belongs on the picture that is shown: the newest that is not newer than it. The same object while it is the same. */
  currentBoxes(now: number): CurrentBoxes | null {
    const { shown } = this;
    const newest = shown === null ? undefined : this.boxes.filter(({ seq }) => seq <= shown.shot.seq).at(-1);
    const standing = shown === null || newest === undefined ? null : this.standingBoxes(newest, shown, now);
    if (newest === undefined || standing === null) this.told = null;
    else if (this.told?.things !== newest.things || this.told.standing !== standing) this.told = { things: newest.things, standing };
    return this.told;
  }

  close(): void {
    for (const { picture } of this.waiting) picture.close();
    this.waiting = [];
    this.shown = null;
    this.dropStaleBoxes();
  }

  private standingBoxes(boxes: CameraPictureBoxes, shown: { readonly shot: S; readonly at: number }, now: number): StandingBoxes | null {
    if (boxes.seq === shown.shot.seq) return "same";
    // While a picture stands still, what is seen on an earlier one gets older, too.
    const lag = (shown.shot.time_us - boxes.time_us) / 1000 + (now - shown.at);
    if (this.prompt) return lag <= EARLIER_MS ? "earlier" : null;
    if (lag <= EARLIER_MS) return "same";
    return lag <= LONGEST_MS ? "earlier" : null;
  }

  private dropStaleBoxes(): void {
    this.arrivals = [];
    this.clearBoxes();
  }
}
