/**
 * The driver's seat of one device: ties lease and driving machine to the connection.
 *
 * Frames leave in the same turn as the press that caused them. Everything that may end a hold
 * ends here, before anything is drawn.
 */

import { Store } from "../../state/store.js";
import type { DriveNews, LeaseNews } from "../../generated/wire.js";
import type { Connection } from "../../wire/connection.js";
import { LeaseDesk, type LeaseAsk } from "./lease-machine.js";
import { DriveMachine, type Bar, type Frame, type Halt, type Limits } from "./drive-machine.js";
import type { Stick } from "./stick.js";
import { haltWords } from "./drive-messages.js";

/** What a seat needs of the connection. */
export type Line = Pick<Connection, "state" | "send" | "on" | "onState" | "bufferedBytes">;

export interface Seated {
  readonly site: string;
  readonly device: string;
  readonly limits: Limits;
}

const LEASE_BEAT_MS = 100;
/** More than this waiting in the socket, and a moving frame would be too old on arrival. */
const BACKLOG_BYTES = 16_384;
const LINK_GONE = "The connection to the hub is lost. The gateway brings the vehicle to rest by itself.";
const SITE_GONE = "The site went offline. Its gateway brings the vehicle to rest by itself.";

export class DriveSeat extends Store {
  readonly machine: DriveMachine;
  readonly lease = new LeaseDesk();
  /** What the robot is being told, by the gateway's own word; null before the first. */
  told: DriveNews | null = null;
  private siteOnline: boolean;
  private stops: (() => void)[] = [];
  private frameTimer: ReturnType<typeof setTimeout> | undefined;
  private leaseTimer: ReturnType<typeof setInterval> | undefined;

  constructor(
    private readonly line: Line,
    private readonly seated: Seated,
    online: boolean,
    private readonly now: () => number = () => performance.now(),
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
  get remains(): number {
    return this.lease.remains(this.now());
  }

  /** How long the one who is asked for control may answer (ms). */
  get answerRemains(): number {
    return this.lease.answerRemains(this.now());
  }

  /** What the driver should know: why a hold or the lease ended; empty when all is well. */
  get trouble(): string {
    return this.lease.trouble || haltWords(this.machine.why);
  }

  /** @param known - what was said of the lease before, if anything was */
  open(known?: LeaseNews): void {
    const { site, device } = this.seated;
    this.stops = [
      this.line.on("lease_news", (news) => {
        if (news.site !== site || news.device !== device) return;
        const ended = this.lease.news(news, this.now());
        if (ended) this.machine.revoke(ended);
        else if (this.lease.epoch) this.machine.grant(this.lease.epoch, this.now());
        this.settle();
      }),
      this.line.on("tick", (news) => {
        if (news.site === site) this.run(this.machine.tick(news.tick, this.now()), false);
      }),
      this.line.on("drive_news", (news) => {
        if (news.site !== site || news.device !== device) return;
        this.told = news;
        this.changed();
      }),
      this.line.on("site", (news) => {
        if (news.site !== site) return;
        this.siteOnline = news.online;
        this.follow();
      }),
      this.line.on("problem", (news) => {
        if (news.about !== "lease" && news.about !== "lease_force") return;
        this.lease.lose(news.message);
        this.machine.revoke("lease lost");
        this.settle();
      }),
      this.line.onState(() => {
        this.follow();
      }),
    ];
    if (known) this.lease.news(known, this.now());
    this.follow();
  }

  /** Leaves the seat: to rest, and the lease is free for others. */
  close(): void {
    this.run(this.machine.halt("cancelled", this.now(), true));
    this.free();
    for (const stop of this.stops) stop();
    this.stops = [];
    clearTimeout(this.frameTimer);
    clearInterval(this.leaseTimer);
  }

  /** Answers who asks for control: hand it over, through rest, or keep it. */
  answer(yes: boolean): void {
    if (yes) this.run(this.machine.halt("freed", this.now(), true), false);
    this.ask(this.lease.answer(yes));
    this.settle();
  }

  /** Takes control from a holder who was asked in vain; the hub sees to the right. */
  force(): void {
    if (!this.online) return;
    this.ask(this.lease.force(this.now()));
    this.settle();
  }

  take(): void {
    if (!this.online) return;
    // Why the last lease ended is answered by asking for the next.
    this.machine.forget("lease lost");
    this.machine.forget("hidden");
    this.ask(this.lease.take(this.now()));
    this.settle();
  }

  /** Gives control back, through rest. */
  free(why: Halt = "freed"): void {
    this.run(this.machine.halt(why, this.now(), true), false);
    this.machine.revoke(why);
    this.ask(this.lease.free());
    this.settle();
  }

  press(source: string, stick: Stick, kind: "digital" | "analog" = "digital"): void {
    this.run(this.machine.press(source, stick, this.now(), kind));
  }

  move(source: string, stick: Stick): void {
    this.run(this.machine.move(source, stick, this.now()), false);
  }

  release(source: string): void {
    this.run(this.machine.release(source, this.now()));
  }

  /** The press was taken away, by the browser or the system: everything ends, not only it. */
  cancel(source: string): void {
    if (this.machine.holds(source)) this.halt("cancelled");
  }

  halt(why: Halt): void {
    this.run(this.machine.halt(why, this.now()));
  }

  bar(bar: Bar): void {
    this.run(this.machine.bar(bar, this.now()));
  }

  lift(bar: Bar): void {
    this.machine.lift(bar);
    this.changed();
  }

  /** The window has the focus again. */
  refocus(): void {
    this.machine.forget("blur");
    this.changed();
  }

  /** The page is out of sight: nobody watches the robot. */
  hide(): void {
    this.run(this.machine.bar("hidden", this.now()));
    if (this.lease.wanted) this.free("hidden");
  }

  setLevel(level: number): void {
    this.machine.setLevel(level);
    this.changed();
  }

  /** @param takenAt - when the picture on screen was taken, on this page's clock; null: none */
  picture(takenAt: number | null): void {
    this.machine.picture(takenAt);
  }

  private follow(): void {
    if (this.online) {
      this.machine.lift("offline");
    } else {
      this.machine.bar("offline", this.now());
      this.lease.lose(this.line.state === "open" ? SITE_GONE : LINK_GONE);
      this.machine.revoke("offline");
      this.told = null;
    }
    this.settle();
  }

  private ask(op: LeaseAsk | null): void {
    const { site, device } = this.seated;
    if (op === "force") this.line.send({ t: "lease_force", site, device });
    else if (op !== null) this.line.send({ t: "lease", site, device, op });
  }

  private run(frames: readonly Frame[], tell = true): void {
    const { site, device } = this.seated;
    for (const frame of frames) {
      const moving = frame.linear !== 0 || frame.angular !== 0;
      if (moving && this.line.bufferedBytes > BACKLOG_BYTES) continue;
      this.line.send({ t: "drive", site, device, ...frame });
    }
    this.plan();
    if (tell) this.changed();
  }

  /** The next frame at the moment it is due. */
  private plan(): void {
    clearTimeout(this.frameTimer);
    const due = this.machine.dueAt;
    if (due === null) return;
    this.frameTimer = setTimeout(() => {
      const phase = this.machine.phase;
      this.run(this.machine.beat(this.now()), false);
      if (this.machine.phase !== phase) this.changed();
    }, Math.max(0, due - this.now()));
  }

  private settle(): void {
    if (this.lease.wanted) this.leaseTimer ??= setInterval(this.beat, LEASE_BEAT_MS);
    else {
      clearInterval(this.leaseTimer);
      this.leaseTimer = undefined;
    }
    this.plan();
    this.changed();
  }

  private readonly beat = (): void => {
    const { ask, ended } = this.lease.beat(this.now());
    this.ask(ask);
    if (ended) {
      this.machine.revoke(ended);
      // The gateway has been silent for seconds: what it said last is not what the robot is told now.
      this.told = null;
    }
    if (ended || this.lease.state.kind !== "mine") this.settle();
  };
}
