/**
 * The driver's seat of one device: ties lease and driving machine to the connection.
 *
 * Frames leave in the same turn as the press that caused them. Everything that may end a hold
 * ends here, before anything is drawn.
 */

import { msg } from "@lit/localize";
import { Store } from "../../state/store.js";
import type { DriveUpdate, FromBrowser, LeaseUpdate } from "../../generated/wire.js";
import type { Connection } from "../../wire/connection.js";
import { LeaseMachine, type LeaseAsk } from "./lease-machine.js";
import { asksAnything, DriveMachine, LEVEL_STEP, type DriveBlock, type VelocityFrame, type HaltReason, type DriveLimits } from "./drive-machine.js";
import type { Stick } from "./stick.js";
import { haltWords } from "./drive-messages.js";

/** What a seat needs of the connection. */
export type DriveConnection = Pick<Connection, "state" | "send" | "onMessage" | "onState" | "bufferedBytes">;

export interface DriveDevice {
  readonly site: string;
  readonly device: string;
  readonly limits: DriveLimits;
}

/** How a frame is said: to the robot, or to its twin. */
export type FrameMessage = (seated: DriveDevice, frame: VelocityFrame) => FromBrowser;

const robotFrame: FrameMessage = ({ site, device }, frame) => ({ t: "drive", site, device, lateral: 0, steering: 0, joints: [], ...frame });

const LEASE_BEAT_MS = 100;
/** More than this waiting in the socket, and a moving frame would be too old on arrival. */
const BACKLOG_BYTES = 16_384;
const LINK_GONE = msg("The connection to the hub is lost. The gateway brings the vehicle to rest by itself.");
const SITE_GONE = msg("The site went offline. Its gateway brings the vehicle to rest by itself.");

export class DriveSession extends Store {
  readonly machine: DriveMachine;
  readonly lease = new LeaseMachine();
  /** What the robot is being told, by the gateway's own word; null before the first. */
  told: DriveUpdate | null = null;
  private siteOnline: boolean;
  private stops: (() => void)[] = [];
  private frameTimer: ReturnType<typeof setTimeout> | undefined;
  private leaseTimer: ReturnType<typeof setInterval> | undefined;

  constructor(
    private readonly line: DriveConnection,
    private readonly seated: DriveDevice,
    online: boolean,
    private readonly now: () => number = () => performance.now(),
    private readonly messageOf: FrameMessage = robotFrame,
  ) {
    super();
    this.machine = new DriveMachine(seated.limits);
    this.siteOnline = online;
  }

  /** Whether a press could reach the gateway. */
  get online(): boolean {
    return this.siteOnline && this.line.state === "open";
  }

  /** How long the lease still holds (ms); 0 when it is not mine. */
  get remainingMs(): number {
    return this.lease.remainingMs(this.now());
  }

  /** How long the one who is asked for control may answer (ms). */
  get answerRemainingMs(): number {
    return this.lease.answerRemainingMs(this.now());
  }

  /** What the driver should know: why a hold or the lease ended; empty when all is well. */
  get problem(): string {
    return this.lease.trouble || haltWords(this.machine.haltReason);
  }

  /** @param known - what was said of the lease before, if anything was */
  open(known?: LeaseUpdate): void {
    const { site, device } = this.seated;
    this.stops = [
      this.line.onMessage("lease_news", (news) => {
        if (news.site !== site || news.device !== device) return;
        const ended = this.lease.applyUpdate(news, this.now());
        if (ended) this.machine.revoke(ended);
        else if (this.lease.epoch) this.machine.grant(this.lease.epoch, this.now());
        this.updateAndSchedule();
      }),
      this.line.onMessage("tick", (news) => {
        if (news.site === site) this.sendFrames(this.machine.onGatewayTick(news.tick, this.now()), false);
      }),
      this.line.onMessage("drive_news", (news) => {
        if (news.site !== site || news.device !== device) return;
        this.told = news;
        this.notifyWatchers();
      }),
      this.line.onMessage("site", (news) => {
        if (news.site !== site) return;
        this.siteOnline = news.online;
        this.followLink();
      }),
      this.line.onMessage("problem", (news) => {
        if (news.about !== "lease" && news.about !== "lease_force") return;
        this.lease.onLinkLost(news.message);
        this.machine.revoke("lease lost");
        this.updateAndSchedule();
      }),
      this.line.onState(() => {
        this.followLink();
      }),
    ];
    if (known) this.lease.applyUpdate(known, this.now());
    this.followLink();
  }

  /** Leaves the seat: to rest, and the lease is free for others. */
  close(): void {
    this.sendFrames(this.machine.haltMotion("cancelled", this.now(), true));
    this.releaseControl();
    for (const stop of this.stops) stop();
    this.stops = [];
    clearTimeout(this.frameTimer);
    clearInterval(this.leaseTimer);
  }

  /** Answers who asks for control: hand it over, through rest, or keep it. */
  answerRequest(yes: boolean): void {
    if (yes) this.sendFrames(this.machine.haltMotion("freed", this.now(), true), false);
    this.sendLeaseRequest(this.lease.answerRequest(yes));
    this.updateAndSchedule();
  }

  /** Takes control from a holder who was asked in vain; the hub sees to the right. */
  forceTakeover(): void {
    if (!this.online) return;
    this.sendLeaseRequest(this.lease.forceTakeover(this.now()));
    this.updateAndSchedule();
  }

  takeControl(): void {
    if (!this.online) return;
    // Why the last lease ended is answered by asking for the next.
    this.machine.clearHaltReason("lease lost");
    this.machine.clearHaltReason("hidden");
    this.sendLeaseRequest(this.lease.requestLease(this.now()));
    this.updateAndSchedule();
  }

  /** Gives control back, through rest. */
  releaseControl(why: HaltReason = "freed"): void {
    this.sendFrames(this.machine.haltMotion(why, this.now(), true), false);
    this.machine.revoke(why);
    this.sendLeaseRequest(this.lease.releaseLease());
    this.updateAndSchedule();
  }

  pressHold(source: string, stick: Stick, kind: "digital" | "analog" = "digital"): void {
    this.sendFrames(this.machine.pressHold(source, stick, this.now(), kind));
  }

  moveHold(source: string, stick: Stick): void {
    this.sendFrames(this.machine.moveHold(source, stick, this.now()), false);
  }

  releaseHold(source: string): void {
    this.sendFrames(this.machine.releaseHold(source, this.now()));
  }

  /** The press was taken away, by the browser or the system: everything ends, not only it. */
  cancelHold(source: string): void {
    if (this.machine.isHeld(source)) this.haltMotion("cancelled");
  }

  haltMotion(why: HaltReason): void {
    this.sendFrames(this.machine.haltMotion(why, this.now()));
  }

  block(bar: DriveBlock): void {
    this.sendFrames(this.machine.block(bar, this.now()));
  }

  unblock(bar: DriveBlock): void {
    this.machine.unblock(bar);
    this.notifyWatchers();
  }

  /** No press counts while an interlock locks driving, and what is held is let go in the same turn; empty: none does. */
  followLock(reason: string): void {
    const barred = this.machine.isBlocked("interlock");
    if (reason === "" && barred) this.unblock("interlock");
    else if (reason !== "" && !barred) this.block("interlock");
  }

  /** The window has the focus again. */
  onFocus(): void {
    this.machine.clearHaltReason("blur");
    this.notifyWatchers();
  }

  /** The page is out of sight: nobody watches the robot. */
  onHidden(): void {
    this.sendFrames(this.machine.block("hidden", this.now()));
    if (this.lease.isWanted) this.releaseControl("hidden");
  }

  setLevel(level: number): void {
    this.machine.setLevel(level);
    this.notifyWatchers();
  }

  /** @param takenAt - when the picture on screen was taken, on this page's clock; null: none */
  setPictureTime(takenAt: number | null): void {
    this.machine.setPictureTime(takenAt);
  }

  private followLink(): void {
    if (this.online) {
      this.machine.unblock("offline");
    } else {
      this.machine.block("offline", this.now());
      this.lease.onLinkLost(this.line.state === "open" ? SITE_GONE : LINK_GONE);
      this.machine.revoke("offline");
      this.told = null;
    }
    this.updateAndSchedule();
  }

  private sendLeaseRequest(op: LeaseAsk | null): void {
    const { site, device } = this.seated;
    if (op === "force") this.line.send({ t: "lease_force", site, device });
    else if (op !== null) this.line.send({ t: "lease", site, device, op });
  }

  private sendFrames(frames: readonly VelocityFrame[], tell = true): void {
    for (const frame of frames) {
      if (asksAnything(frame) && this.line.bufferedBytes > BACKLOG_BYTES) continue;
      this.line.send(this.messageOf(this.seated, frame));
    }
    this.scheduleTimer();
    if (tell) this.notifyWatchers();
  }

  /** The next frame at the moment it is due. */
  private scheduleTimer(): void {
    clearTimeout(this.frameTimer);
    const due = this.machine.dueAt;
    if (due === null) return;
    this.frameTimer = setTimeout(() => {
      const phase = this.machine.phase;
      this.sendFrames(this.machine.advance(this.now()), false);
      if (this.machine.phase !== phase) this.notifyWatchers();
    }, Math.max(0, due - this.now()));
  }

  private updateAndSchedule(): void {
    if (this.lease.isWanted) this.leaseTimer ??= setInterval(this.onTimer, LEASE_BEAT_MS);
    else {
      clearInterval(this.leaseTimer);
      this.leaseTimer = undefined;
    }
    this.scheduleTimer();
    this.notifyWatchers();
  }

  private readonly onTimer = (): void => {
    const { ask, ended } = this.lease.advance(this.now());
    this.sendLeaseRequest(ask);
    if (ended) {
      this.machine.revoke(ended);
      // The gateway has been silent for seconds: what it said last is not what the robot is told now.
      this.told = null;
    }
    if (ended || this.lease.state.kind !== "mine") this.updateAndSchedule();
  };
}

/** Does what a key or a gamepad's button asks for besides a direction. */
export function applySeatPress(seat: Pick<DriveSession, "machine" | "haltMotion" | "setLevel">, press: "halt" | "faster" | "slower"): void {
  switch (press) {
    case "halt":
      seat.haltMotion("stop key");
      return;
    case "faster":
      seat.setLevel(seat.machine.speedLevel + LEVEL_STEP);
      return;
    case "slower":
      seat.setLevel(seat.machine.speedLevel - LEVEL_STEP);
      return;
  }
}
