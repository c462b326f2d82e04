/**
 * The driving machine of the page: what is held goes in, driving frames come out.
 *
 * It knows no clock, socket or element: times are handed in (ms on one monotonic clock), frames
 * are handed back to be sent at once. It promises:
 *
 * - no frame without a lease of mine, and none while the link is away;
 * - the first frame leaves with the press itself; while held, one every `FRAME_MS`;
 * - when the last hold ends, for whatever reason, `ZEROS` zero frames follow, then silence;
 * - what was held when it ended drives again only after it was let go and pressed anew.
 */

import { aimPush, CENTRE, curvedPush, combinedStick, limitedUnit, type Stick } from "./stick.js";

/** One frame each 50 ms: 20 Hz. */
export const FRAME_MS = 50;
export const ZEROS = 3;
/** No time mark from the gateway for so long while driving: the way there is dead, let go. */
export const SILENT_MS = 1000;
export const LEVEL_STEP = 0.1;

/** What the description allows at full level. */
export interface DriveLimits {
  /** m/s */
  readonly maxSpeed: number;
  /** m/s, given positive */
  readonly maxReverse: number;
  /** rad/s */
  readonly maxTurn: number;
  /** m/s to each side; nothing: it does not move sideways. */
  readonly maxSideways?: number;
  /** rad to each side, of wheels that steer; nothing: it turns by itself. */
  readonly maxSteering?: number;
  /** rad/s or m/s of each joint, of an arm. */
  readonly jointSpeeds?: readonly number[];
  /** Those joints are a camera's `pan`, `tilt` and `zoom`, in this order: keys turn it, too. */
  readonly aims?: readonly string[];
}

/** What is asked of a robot: m/s and rad/s, an angle of its wheels (rad), speeds of its joints. */
export interface RequestedVelocity {
  readonly linear: number;
  readonly angular: number;
  readonly lateral?: number;
  readonly steering?: number;
  readonly joints?: readonly number[];
}

/** Whether anything is asked for. */
export function asksAnything({ linear, angular, lateral, steering, joints }: RequestedVelocity): boolean {
  return [linear, angular, lateral ?? 0, steering ?? 0, ...(joints ?? [])].some((value) => value !== 0);
}

/** The part of a `Drive` message that the machine decides. */
export interface VelocityFrame extends RequestedVelocity {
  readonly epoch: number;
  readonly seq: number;
  readonly tick: number;
  readonly held_ms: number;
  readonly picture_ms: number;
}

/** Why a hold ended. */
export type HaltReason =
  | "released"
  | "stop key"
  | "cancelled"
  | "blur"
  | "hidden"
  | "gamepad lost"
  | "dialog"
  | "silent"
  | "freed"
  | "lease lost"
  | "offline"
  | "stop"
  | "interlock";

/** While one of these stands, no press counts. */
export type DriveBlock = "offline" | "stop" | "hidden" | "dialog" | "interlock";

/**
 * idle: no lease; ready: may drive, nothing is held; driving: something is held;
 * braking: the zero frames after a hold.
 */
export type DrivePhase = "idle" | "ready" | "driving" | "braking";

type HoldKind = "digital" | "analog";

interface HeldInput {
  readonly kind: HoldKind;
  readonly stick: Stick;
}

export class DriveMachine {
  private readonly limits: DriveLimits;
  private epoch = 0;
  private seq = 0;
  private tickNumber = 0;
  private tickAt: number | null = null;
  /** Since when we wait for a time mark: the newest one, or the grant. */
  private heardAt = 0;
  private pictureAt: number | null = null;
  private readonly held = new Map<string, HeldInput>();
  private readonly bars = new Set<DriveBlock>();
  private zerosLeft = 0;
  private nextAt = 0;
  private steps = 5;
  private stopped: HaltReason | null = null;

  constructor(limits: DriveLimits) {
    this.limits = limits;
  }

  get phase(): DrivePhase {
    if (this.epoch === 0) return "idle";
    if (this.held.size > 0) return "driving";
    return this.zerosLeft > 0 ? "braking" : "ready";
  }

  /** Share of the limit that a full push asks for: 0.1 to 1. */
  get speedLevel(): number {
    return this.steps / 10;
  }

  /** What is asked of the robot now: m/s and rad/s. */
  get requestedVelocity(): RequestedVelocity {
    const push = this.combinedPush();
    const { maxSpeed, maxReverse, maxTurn, maxSideways = 0, maxSteering = 0, jointSpeeds = [], aims = [] } = this.limits;
    const scale = push.forward < 0 ? maxReverse : maxSpeed;
    const level = this.speedLevel;
    return {
      linear: push.forward * scale * level + 0,
      angular: push.turn * maxTurn * level + 0,
      ...(maxSideways === 0 ? {} : { lateral: (push.side ?? 0) * maxSideways * level + 0 }),
      // An angle is no speed: however slowly it goes, it can be steered as far.
      ...(maxSteering === 0 ? {} : { steering: push.turn * maxSteering + 0 }),
      ...(jointSpeeds.length === 0 ? {} : { joints: jointSpeeds.map((speed, index) => limitedUnit((push.joints?.[index] ?? 0) + aimPush(aims[index] ?? "", push)) * speed * level + 0) }),
    };
  }

  /** Whether this robot can do what a push asks for. */
  obeys(push: Stick): boolean {
    const { maxSpeed, maxSideways = 0, aims } = this.limits;
    if (aims !== undefined) return push.joints !== undefined || aims.some((axis) => aimPush(axis, push) !== 0);
    return push.side === undefined ? maxSpeed > 0 || push.joints !== undefined : maxSideways > 0;
  }

  /** Why the last hold ended, until the next begins. */
  get haltReason(): HaltReason | null {
    return this.stopped;
  }

  get mayDrive(): boolean {
    return this.epoch !== 0 && this.bars.size === 0;
  }

  isHeld(source: string): boolean {
    return this.held.has(source);
  }

  isBlocked(bar: DriveBlock): boolean {
    return this.bars.has(bar);
  }

  /** The lease is mine. Another epoch than before is another lease: nothing carries over. */
  grant(epoch: number, now: number): void {
    if (epoch === this.epoch) return;
    this.dropHolds();
    this.epoch = epoch;
    this.heardAt = now;
    this.stopped = null;
    // Time marks come only while a lease is held: the newest we know may be of long ago.
    this.tickNumber = 0;
    this.tickAt = null;
  }

  /** The lease is gone. There is nothing left that may be sent. */
  revoke(why: HaltReason): void {
    if (this.epoch === 0) return;
    this.stopped = why;
    this.epoch = 0;
    this.dropHolds();
  }

  /** A time mark of the gateway came. */
  onGatewayTick(tick: number, now: number): VelocityFrame[] {
    if (tick < this.tickNumber) return [];
    this.tickNumber = tick;
    this.tickAt = now;
    this.heardAt = now;
    return this.advance(now);
  }

  /** When the picture the driver looks at was taken, on the clock of `now`; null: none. */
  setPictureTime(takenAt: number | null): void {
    this.pictureAt = takenAt;
  }

  /**
   * Something is pressed. The frame that comes back is to be sent at once.
   *
   * @param source - names what is held, so that the same can be released
   */
  pressHold(source: string, stick: Stick, now: number, kind: HoldKind = "digital"): VelocityFrame[] {
    if (!this.mayDrive) return [];
    this.held.set(source, { kind, stick });
    this.zerosLeft = 0;
    this.stopped = null;
    this.nextAt = now;
    return this.advance(now);
  }

  /** Something that is held is held elsewhere now. Let go by a halt, it stays let go. */
  moveHold(source: string, stick: Stick, now: number): VelocityFrame[] {
    const hold = this.held.get(source);
    if (!hold) return [];
    this.held.set(source, { kind: hold.kind, stick });
    return this.advance(now);
  }

  /** Something is let go. The last one brings the robot to rest. */
  releaseHold(source: string, now: number): VelocityFrame[] {
    if (!this.held.delete(source)) return [];
    if (this.held.size === 0) return this.stopMotion("released", now);
    this.nextAt = now;
    return this.advance(now);
  }

  /**
   * Let go of everything.
   *
   * @param flush - all zero frames now: a hidden page may get no timer for a second
   */
  haltMotion(why: HaltReason, now: number, flush = false): VelocityFrame[] {
    const wasDriving = this.held.size > 0;
    this.held.clear();
    const frames = wasDriving ? this.stopMotion(why, now) : [];
    while (flush && this.zerosLeft > 0) frames.push(this.zeroFrame(now));
    return frames;
  }

  /** From now on no press counts; what is held ends. */
  block(bar: DriveBlock, now: number): VelocityFrame[] {
    this.bars.add(bar);
    if (bar !== "offline") return this.haltMotion(bar, now, bar === "hidden");
    if (this.held.size > 0) this.stopped = "offline";
    this.dropHolds();
    return [];
  }

  /** The reason is gone. Nothing starts by itself: see `press`. */
  unblock(bar: DriveBlock): void {
    this.bars.delete(bar);
    // A page that was hidden gave control back: that is to be read by whoever returns to it.
    if (bar !== "hidden") this.clearHaltReason(bar);
  }

  /** This reason of the last halt is no longer so, and need not be told. */
  clearHaltReason(why: HaltReason): void {
    if (this.stopped === why) this.stopped = null;
  }

  setLevel(level: number): void {
    if (!Number.isFinite(level)) return;
    this.steps = Math.min(10, Math.max(1, Math.round(level / LEVEL_STEP)));
  }

  faster(): void {
    this.setLevel(this.speedLevel + LEVEL_STEP);
  }

  slower(): void {
    this.setLevel(this.speedLevel - LEVEL_STEP);
  }

  /** When `beat` has something to do next; null while silent. */
  get dueAt(): number | null {
    return this.phase === "driving" || this.phase === "braking" ? this.nextAt : null;
  }

  /** Time has passed: the frames that are due. Early calls are harmless. */
  advance(now: number): VelocityFrame[] {
    if (this.phase === "braking") return now < this.nextAt ? [] : [this.zeroFrame(now)];
    if (this.phase !== "driving" || now < this.nextAt) return [];
    if (now - this.heardAt > SILENT_MS) return this.haltMotion("silent", now);
    // Timers fire late, never early: count from when it was due, without running after lost time.
    this.nextAt = Math.max(this.nextAt + FRAME_MS, now + FRAME_MS / 2);
    // Without any time mark the gateway cannot tell the frame's age and would refuse it.
    if (this.tickAt === null) return [];
    return [this.velocityFrame(this.requestedVelocity, now)];
  }

  private combinedPush(): Stick {
    if (this.epoch === 0 || this.held.size === 0) return CENTRE;
    const digital: Stick[] = [];
    const analog: Stick[] = [];
    for (const hold of this.held.values()) {
      (hold.kind === "digital" ? digital : analog).push(hold.stick);
    }
    const keys = combinedStick(digital);
    return combinedStick([this.limits.maxSteering === undefined && this.limits.aims === undefined ? curvedPush(keys) : keys, ...analog]);
  }

  private dropHolds(): void {
    this.held.clear();
    this.zerosLeft = 0;
  }

  private stopMotion(why: HaltReason, now: number): VelocityFrame[] {
    this.stopped = why;
    if (this.epoch === 0) return [];
    this.zerosLeft = ZEROS;
    return [this.zeroFrame(now)];
  }

  private zeroFrame(now: number): VelocityFrame {
    this.zerosLeft -= 1;
    this.nextAt = now + FRAME_MS;
    return this.velocityFrame({ linear: 0, angular: 0 }, now);
  }

  private velocityFrame({ linear, angular, lateral, steering, joints }: RequestedVelocity, now: number): VelocityFrame {
    this.seq += 1;
    return {
      epoch: this.epoch,
      seq: this.seq,
      tick: this.tickNumber,
      held_ms: this.tickAt === null ? 0 : Math.max(0, now - this.tickAt),
      linear: finite(linear),
      angular: finite(angular),
      ...(lateral === undefined ? {} : { lateral: finite(lateral) }),
      ...(steering === undefined ? {} : { steering: finite(steering) }),
      ...(joints === undefined ? {} : { joints: joints.map(finite) }),
      picture_ms: this.pictureAt === null ? -1 : Math.max(0, now - this.pictureAt),
    };
  }
}

function finite(value: number): number {
  return Number.isFinite(value) ? value : 0;
}
